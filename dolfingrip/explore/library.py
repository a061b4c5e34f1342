"""Solved designs, and interpolation between them: shapes, fields and readings."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.interpolate import RBFInterpolator

from dolfingrip.config import Config, ConfigError, felt
from dolfingrip.experiments.request import Request
from dolfingrip.explore.policy import POLICY
from dolfingrip.explore.space import EXPERIMENTS, Space
from dolfingrip.explore.wanted import Wanted
from dolfingrip.report.page import runs
from dolfingrip.report.page.run_scene import scene_of
from dolfingrip.report.page.scene import Part, Scene

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Solved:
    """A solved design.

    Attributes:
        run: its result.
        place: values of the parameters, in shares of the sliders' ranges, shape (parameters,).
    """

    run: runs.Run
    place: Floats

    @cached_property
    def scene(self) -> Scene:
        """Return the steps of the blended design in 3D."""
        return scene_of(self.run)

    @cached_property
    def mesh(self) -> str:
        """Hash of the surface's triangles and of the loads: what those of one mesh share."""
        digest = hashlib.sha256(np.round(self.scene.load.values, 6).tobytes())
        for part in self.scene.parts:
            digest.update(part.name.encode())
            digest.update(part.skin.triangles.tobytes())
        return digest.hexdigest()

    def reading(self, column: str) -> Floats:
        """A column, shape (rows,); NaN where it is missing."""
        found = self.run.column(column)
        return np.full(len(self.run.result), np.nan) if found is None else found


@dataclass(frozen=True, slots=True)
class Blend:
    """A design as a weighted sum of solved ones.

    Attributes:
        of: solved designs; one alone if it is the design itself.
        weights: shape (designs,), their sum is 1.
        exact: whether it is a solved design.
        outside: whether it lies beyond the solved ones in a parameter.
    """

    of: Sequence[Solved]
    weights: Floats
    exact: bool
    outside: bool

    def scene(self) -> Scene:
        """The steps in 3D."""
        if self.exact:
            return self.of[0].scene
        scenes = [each.scene for each in self.of]
        parts = [
            _blended([scene.parts[i] for scene in scenes], self.weights)
            for i in range(len(scenes[0].parts))
        ]
        return replace(scenes[0], parts=parts, solved=False)

    def reading(self, column: str) -> Floats:
        """A column, shape (rows,)."""
        return np.asarray(self.weights @ np.array([each.reading(column) for each in self.of]))

    def error(self, column: str) -> Floats | None:
        """Root mean square error of the interpolation at each row, from designs left out in turn.

        None where too few designs are solved to tell.
        """
        if self.exact or len(self.of) < POLICY.checked:
            return None
        places = np.array([each.place for each in self.of])
        values = np.array([each.reading(column) for each in self.of])
        off = []
        for i in range(len(self.of)):
            rest = np.arange(len(self.of)) != i
            off.append(weights(places[rest], places[i]) @ values[rest] - values[i])
        return np.sqrt(np.mean(np.array(off) ** 2, axis=0))


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
            place = self._place(run.result.config, kind)
        except (ConfigError, OSError, ValueError, KeyError):
            return False
        if place is None or not run.result.facts.complete:
            return False
        found = self.places[folder] = Solved(run, place)
        self.solved[kind].append(found)
        return True

    def counts(self) -> dict[str, int]:
        """Number of solved designs by experiment."""
        return {kind: len(found) for kind, found in self.solved.items()}

    def blend(self, wanted: Wanted, experiment: str | None = None) -> Blend | None:
        """A design from solved ones; None if none is."""
        kind = experiment or wanted.view
        there = self.solved.get(kind, ())
        if not there:
            return None
        at = self.place(wanted.inputs)
        distances = np.array([np.linalg.norm(each.place - at) for each in there])
        order = np.argsort(distances, kind="stable")
        nearest = there[int(order[0])]
        if distances[order[0]] <= POLICY.same:
            return Blend([nearest], np.ones(1), exact=True, outside=False)
        alike = [there[int(i)] for i in order if there[int(i)].mesh == nearest.mesh]
        alike = alike[: POLICY.neighbours]
        places = np.array([each.place for each in alike])
        outside = bool(((at < places.min(axis=0) - POLICY.same)
                        | (at > places.max(axis=0) + POLICY.same)).any())  # fmt: skip
        return Blend(alike, weights(places, at), exact=False, outside=outside)

    def place(self, inputs: Mapping[str, float]) -> Floats:
        """Values in shares of the sliders' ranges, shape (parameters,)."""
        return np.array([(inputs[v.key] - v.low) / (v.high - v.low) for v in self.space.varied])

    def _place(self, config: Config, kind: str) -> Floats | None:
        """The place of a run; None if it differs from the space in more than its parameters."""
        inputs = {each.key: each.parameter.value(config) for each in self.space.varied}
        base, own = Request.of(kind, self.space.base).config, config
        for each in self.space.varied:  # what varies is made equal
            own = each.parameter.at(own, each.parameter.value(base))
        return self.place(inputs) if felt(own) == felt(base) else None


def weights(places: Floats, at: Floats) -> Floats:
    """Weights of values at some places in the value at another one.

    Radial basis functions r² ln r with a linear part where there are enough places for it, else r
    with a constant (Wendland, Scattered Data Approximation, 2005, chapters 7 and 8). Values at the
    places themselves are reproduced.

    Args:
        places: shape (n, parameters).
        at: shape (parameters,).

    Returns:
        Shape (n,); their sum is 1.

    >>> weights(np.array([[0.0], [1.0]]), np.array([0.25])).round(3)
    array([0.75, 0.25])
    """
    count, parameters = places.shape
    if count == 1:
        return np.ones(1)
    spread = np.linalg.matrix_rank(places - places.mean(axis=0), tol=POLICY.same)
    linear = count > parameters + 1 and spread == parameters
    kernel, degree = ("thin_plate_spline", 1) if linear else ("linear", 0)
    found = RBFInterpolator(places, np.eye(count), kernel=kernel, degree=degree)
    return np.asarray(found(at[None])[0], dtype=float)


def _blended(parts: Sequence[Part], weights: Floats) -> Part:
    """A part as a weighted sum of the same part of several designs."""

    def summed(values: Sequence[Floats]) -> Floats:
        return np.asarray(np.tensordot(weights, np.array(values), axes=1))

    first = parts[0]
    frames = summed([part.frames for part in parts])
    known = [name for name in first.fields if all(name in part.fields for part in parts)]
    return replace(
        first,
        skin=replace(first.skin, points=frames[0]),
        frames=frames,
        fields={name: summed([part.fields[name] for part in parts]) for name in known},
    )
