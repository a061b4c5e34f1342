"""Solved designs, and interpolation between them: shapes, fields and readings."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator, RBFInterpolator
from scipy.optimize import nnls

from dolfingrip.channels import PRESSURE
from dolfingrip.config import Config, ConfigError, felt
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.explore import policy
from dolfingrip.explore.space import EXPERIMENTS, Space
from dolfingrip.explore.wanted import Wanted
from dolfingrip.meshes import dimensions
from dolfingrip.report.page import runs
from dolfingrip.report.page.run_scene import scene_of
from dolfingrip.report.page.scene import UPRIGHT, Scene, ScenePart

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Solved:
    """A solved design.

    Attributes:
        run: its result.
        place: values of the parameters, in shares of the sliders' ranges, shape (parameters,).
        coarse: whether its mesh is coarser than configured.
    """

    run: runs.Run
    place: Floats
    coarse: bool

    @cached_property
    def scene(self) -> Scene:
        """Return the steps of the blended design in 3D."""
        return scene_of(self.run)

    @cached_property
    def mesh(self) -> str:
        """Hash of the surface's triangles: what those of one mesh share."""
        digest = hashlib.sha256(str(self.coarse).encode())
        for part in self.scene.parts:
            digest.update(part.name.encode())
            digest.update(part.skin.triangles.tobytes())
        return digest.hexdigest()

    @property
    def largest_kPa(self) -> float:
        """The highest pressure."""
        return float(self.run.result.config.experiment.max_pressure_kPa)

    def loads(self, largest_kPa: float) -> Floats | None:
        """Pressures up to a highest one, shape (steps,); None if it was not solved that far."""
        there = np.asarray(self.scene.load.values)
        if _same(largest_kPa, self.largest_kPa):
            return there
        rising = bool((np.diff(np.abs(there)) > 0).all())
        if not rising or not 0 < largest_kPa / self.largest_kPa < 1:
            return None
        return np.append(there[np.abs(there) < abs(largest_kPa) * (1 - 1e-9)], largest_kPa)

    def reading(self, column: str) -> Floats:
        """A column, shape (rows,); NaN where it is missing."""
        values = self.run.column(column)
        return np.full(len(self.run.result), np.nan) if values is None else values

    def reading_at(self, column: str, loads: Floats) -> Floats:
        """A column at some pressures, shape (steps,)."""
        return _along(self.reading(PRESSURE.name), self.reading(column), loads)

    def values_at(self, values: Floats, loads: Floats) -> Floats:
        """Values at the scene's steps, (steps, …), at some pressures."""
        return _along(np.asarray(self.scene.load.values), values, loads)


@dataclass(frozen=True, slots=True)
class Blend:
    """A design as a weighted sum of solved ones, or a solved one up to a lower pressure.

    Attributes:
        config: of the design.
        of: solved designs; one alone if it is the design itself.
        weights: shape (designs,), their sum is 1.
        loads: pressures, shape (steps,).
    """

    config: Config
    of: Sequence[Solved]
    weights: Floats
    loads: Floats

    @property
    def own(self) -> bool:
        """True where it is the solution of the design itself, whatever its mesh."""
        return len(self.of) == 1

    @property
    def exact(self) -> bool:
        """True where it is the design's own solution with all its steps."""
        return self.own and _same(float(self.loads[-1]), self.of[0].largest_kPa)

    @property
    def coarse(self) -> bool:
        """True where the mesh is coarser than configured."""
        return self.of[0].coarse

    @property
    def checked(self) -> bool:
        """True where enough designs are solved to tell the error of what lies between them."""
        return self.own or len(self.of) >= policy.CHECKED

    def scene(self) -> Scene:
        """The steps in 3D: the design's own dimensions, moved as the solved ones are.

        Raises:
            MeshError: one line, where the points of a solved mesh cannot be moved to the design.
        """
        first = self.of[0]
        if self.exact:
            return first.scene
        count = len(self.loads)
        branches = [*first.scene.load.branches[: count - 1], first.scene.load.branches[-1]]
        load = replace(
            first.scene.load, values=self.loads, rows=np.arange(count), branches=branches
        )
        parts = [self._part(i) for i in range(len(first.scene.parts))]
        return replace(first.scene, parts=parts, load=load, solved=False)

    def reading(self, column: str) -> Floats:
        """A column, shape (steps,)."""
        if self.exact:
            return self.of[0].reading(column)
        return np.asarray(self.weights @ self._readings(column))

    def error(self, column: str) -> Floats | None:
        """Root mean square error of the interpolation at each step, from designs left out in turn.

        None where too few designs are solved to tell.
        """
        return self._left_out(lambda: self._readings(column))

    def shape_error_mm(self) -> float | None:
        """Error of a point's place at the highest pressure, found likewise: the largest of all."""

        def places() -> Floats:
            last = [self._moved(solved, 0)[-1] for solved in self.of]
            return np.array(last).reshape(len(last), -1)

        error = self._left_out(places)
        return None if error is None else float(np.linalg.norm(error.reshape(-1, 3), axis=1).max())

    def _left_out(self, values: Callable[[], Floats]) -> Floats | None:
        if self.own or not self.checked:
            return None
        places, samples = np.array([solved.place for solved in self.of]), values()
        off = []
        for i in range(len(self.of)):
            others = np.arange(len(self.of)) != i
            off.append(weights(places[others], places[i]) @ samples[others] - samples[i])
        return np.asarray(np.sqrt(np.mean(np.array(off) ** 2, axis=0)))

    def _readings(self, column: str) -> Floats:
        """A column of each solved design, shape (designs, steps)."""
        return np.array([solved.reading_at(column, self.loads) for solved in self.of])

    def _moved(self, solved: Solved, number: int) -> Floats:
        """Displacements of a part of a solved design, shape (steps, points, 3)."""
        frames = solved.scene.parts[number].frames
        return solved.values_at(frames[1:] - frames[0], self.loads)

    def _part(self, number: int) -> ScenePart:
        parts = [solved.scene.parts[number] for solved in self.of]
        first = parts[0]
        if len(first.frames) == 1:  # a clamp, a plate
            frames = self._summed([part.frames for part in parts])
            return replace(first, skin=replace(first.skin, points=frames[0]), frames=frames)
        still = carried(first.frames[0], self.of[0].run.result.config, self.config)
        moved = self._summed([self._moved(solved, number) for solved in self.of])
        shared = [name for name in first.fields if all(name in part.fields for part in parts)]
        pairs = list(zip(self.of, parts, strict=True))
        fields = {
            name: self._summed([e.values_at(p.fields[name], self.loads) for e, p in pairs])
            for name in shared
        }
        frames = np.concatenate([still[None], still + moved])
        return replace(first, skin=replace(first.skin, points=still), frames=frames, fields=fields)

    def _summed(self, values: Sequence[Floats]) -> Floats:
        return np.asarray(np.tensordot(self.weights, np.array(values), axes=1))


@dataclass
class Library:
    """Solved designs of a space.

    Args:
        space: what varies.
        folders: results that are there.
    """

    space: Space
    solved: dict[str, list[Solved]] = field(default_factory=lambda: {e: [] for e in EXPERIMENTS})
    places: dict[Path, Solved] = field(default_factory=dict)

    def add(self, folder: Path) -> bool:
        """Take up the result in a folder; False where it is of something else."""
        folder = folder.resolve()
        if folder in self.places:
            return True
        try:
            run = runs.read(folder)
            kind = run.experiment.name
            if kind not in EXPERIMENTS or not run.fields.is_file():
                return False
            solved = self._solved(run, kind)
        except (ConfigError, OSError, ValueError, KeyError):
            return False
        if solved is None or not run.result.facts.complete:
            return False
        self.places[folder] = solved
        self.solved[kind].append(solved)
        return True

    def counts(self) -> dict[str, int]:
        """Number of solved designs by experiment, those on coarse meshes left out."""
        return {kind: sum(not d.coarse for d in designs) for kind, designs in self.solved.items()}

    def blend(self, wanted: Wanted, experiment: str | None = None) -> Blend | None:
        """A design from its own solution or from those around it; None if these do not tell it."""
        kind, config = experiment or wanted.view, wanted.config
        largest = config.experiment.max_pressure_kPa
        there = [d for d in self.solved.get(kind, ()) if d.loads(largest) is not None]
        if not there:
            return None
        at = self.space.place(config)
        away = {id(d): float(np.linalg.norm(d.place - at)) for d in there}
        exact = [d for d in there if away[id(d)] <= policy.SAME]
        if exact:
            best = min(exact, key=lambda e: (e.coarse, not _same(e.largest_kPa, largest)))
            return Blend(config, [best], np.ones(1), _known(best.loads(largest)))
        near = sorted(there, key=lambda e: (away[id(e)], e.coarse))[: policy.LOOKED_AT]
        blends = []
        for mesh in dict.fromkeys(d.mesh for d in near):
            alike = _one_of_each([d for d in near if d.mesh == mesh])[: policy.NEIGHBOURS]
            places = np.array([d.place for d in alike])
            if tells(places, at):
                loads = _known(alike[0].loads(largest))
                blends.append(Blend(config, alike, weights(places, at), loads))
        return min(blends, key=lambda e: (not e.checked, e.coarse), default=None)

    def _solved(self, run: runs.Run, kind: str) -> Solved | None:
        """A run of the space; None if it differs in more than parameters, pressure and mesh."""
        config = run.result.config
        base = Request.of(kind, self.space.base).config
        steps = ("max_pressure_kPa", "step_kPa")
        other = config.changed(experiment={key: getattr(base.experiment, key) for key in steps})
        varied = (*self.space.varied, *self.space.chambers)
        equal = {v.key: v.parameter.value(base) for v in varied}
        other, base = self.space.put(other, equal), self.space.put(base, equal)
        finer = other.changed(mesh={"edge_size_mm": base.mesh.edge_size_mm})
        for coarse, one in enumerate((other, finer)):
            if felt(one) == felt(base):
                return Solved(run, self.space.place(config), bool(coarse))
        return None


def _known(loads: Floats | None) -> Floats:
    assert loads is not None
    return loads


def _same(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-12)


def _one_of_each(solved: Sequence[Solved]) -> list[Solved]:
    """One solved design of each place."""
    return list({tuple(np.round(d.place, 6)): d for d in reversed(solved)}.values())[::-1]


def _along(loads: Floats, values: Floats, at: Floats) -> Floats:
    """Values along a load path at other loads, by monotone cubics (Fritsch and Carlson, 1980)."""
    if len(loads) == len(at) and np.allclose(loads, at, rtol=1e-9, atol=1e-9):
        return values
    interpolated = PchipInterpolator(np.abs(loads), values, axis=0)(np.abs(at))
    return np.asarray(interpolated, dtype=float)


def carried(points: Floats, solved: Config, config: Config) -> Floats:
    """Points of a scene of a solved design without load, in another design.

    Args:
        points: shape (n, 3), mm.
        solved: configuration of the solved design.
        config: of the other one.

    Raises:
        MeshError: one line, where they cannot be moved, as their number of chambers differs, say.
    """
    straight = undeformed.unplaced(points * UPRIGHT, solved)
    before, after = solved.adapted().geometry, config.adapted().geometry
    if before != after:
        straight = dimensions.moved(straight, before, after)
    return np.asarray(undeformed.placed(straight, config) * UPRIGHT)


def beyond(places: Floats, at: Floats) -> float:
    """Distance of a place from the convex hull of others.

    Args:
        places: shape (n, parameters).
        at: shape (parameters,).

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    >>> [round(beyond(square, np.array(at)), 3) for at in ([0.3, 0.9], [0.5, 1.5])]
    [0.0, 0.5]
    """
    sum_of_shares = np.full(len(places), 1e3)  # heavy, as the shares' sum is 1
    shares, _ = nnls(np.vstack([places.T, sum_of_shares]), np.append(at, 1e3))
    return float(np.linalg.norm(shares @ places / shares.sum() - at))


def tells(places: Floats, at: Floats) -> bool:
    """Tell whether solved designs say something of another one.

    It lies among them. Or, in directions in which they differ, it lies no farther outside than one
    of them does that is left out in turn, so that the error contains such a distance.

    Args:
        places: of solved designs, shape (n, parameters).
        at: of the other one, shape (parameters,).

    >>> line = np.array([[0.0, 0.0], [0.3, 0.0], [0.6, 0.0], [0.8, 0.0]])
    >>> [tells(line, np.array(at)) for at in ([0.5, 0.0], [1.0, 0.0], [1.2, 0.0], [0.5, 0.1])]
    [True, True, False, False]
    """
    if len(places) < policy.CHECKED:
        return len(places) > 1 and beyond(places, at) <= policy.OUTSIDE
    mean, axes = _span(places)
    aside = (at - mean) - (at - mean) @ axes.T @ axes
    tried = [beyond(np.delete(places, i, axis=0), place) for i, place in enumerate(places)]
    reach = max(policy.OUTSIDE, *tried)
    return bool(np.linalg.norm(aside) <= policy.OUTSIDE and beyond(places, at) <= reach)


def _span(places: Floats) -> tuple[Floats, Floats]:
    """Mean of places, and the directions in which they differ, shape (directions, parameters)."""
    mean = places.mean(axis=0)
    _, spread, axes = np.linalg.svd(places - mean, full_matrices=False)
    return mean, axes[spread > policy.SAME]


def weights(places: Floats, at: Floats) -> Floats:
    """Weights of values at some places in the value at another one.

    Radial basis functions r² ln r with a linear part where there are enough places for it, else r
    with a constant, in the directions in which the places differ (Wendland, Scattered Data
    Approximation, 2005, chapters 7 and 8). Values at the places themselves are reproduced.

    Args:
        places: shape (n, parameters).
        at: shape (parameters,).

    Returns:
        Shape (n,); their sum is 1.

    >>> weights(np.array([[0.0], [1.0]]), np.array([0.25])).round(3)
    array([0.75, 0.25])
    """
    count, (mean, axes) = len(places), _span(places)
    if not len(axes):
        return np.full(count, 1 / count)
    linear = count > len(axes) + 1
    kernel, degree = ("thin_plate_spline", 1) if linear else ("linear", 0)
    rbf = RBFInterpolator((places - mean) @ axes.T, np.eye(count), kernel=kernel, degree=degree)
    return np.asarray(rbf((at - mean)[None] @ axes.T)[0], dtype=float)
