"""Whether a result can be trusted: mesh, energy, elements turned inside out, measurement.

What the elements went through is computed anew from stored displacements, independently of the
solver: shape functions of ``meshes``, the law of the configuration, sums in numpy.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config
from dolfingrip.experiments.material_fit.law import OfStretches
from dolfingrip.experiments.results import doubts
from dolfingrip.files.table import Columns, numbers, select_rows
from dolfingrip.meshes.cells import of_cell
from dolfingrip.meshes.quality import OF_LINEAR
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.page.content import Check, Verdict
from dolfingrip.report.page.finger import Fields
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.runs import Run, over
from dolfingrip.sections.geometry.adopted import AdoptedGeometry

Floats = npt.NDArray[np.float64]

SERENDIPITY: Final = 20
"""Nodes of a quadratic hexahedron; the file also has middles of faces, which follow from them."""

MPA_PER_KPA: Final = 1e-3


def _rule(nodes: int) -> tuple[Floats, Floats]:
    """Points and weights: of degree 3 on the reference hexahedron, of 2 on the tetrahedron."""
    if nodes in (4, 10):
        a, b = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
        return np.full((4, 3), a) + (b - a) * np.vstack([np.zeros(3), np.eye(3)]), np.full(
            4, 1 / 24
        )
    ends = 0.5 + np.array([-1, 1]) / np.sqrt(12)
    return np.array(list(product(ends, repeat=3))), np.full(8, 1 / 8)


def _gradients(mesh: FieldMesh) -> tuple[npt.NDArray[np.int64], Floats, Floats]:
    """Nodes of the cells, gradients of their shape functions, and volumes of the points.

    Returns:
        Shapes (cells, nodes), (cells, points, nodes, 3) and (cells, points).
    """
    cells = mesh.cells[:, :SERENDIPITY]
    points, weights = _rule(cells.shape[1])
    along = of_cell(cells.shape[1]).gradients(points)
    jacobian = np.einsum("cnk,qnj->cqkj", mesh.points[cells], along)
    volumes = np.abs(np.linalg.det(jacobian)) * weights
    return cells, np.einsum("qnj,cqjk->cqnk", along, np.linalg.inv(jacobian)), volumes


def deformation(mesh: FieldMesh, displacement: Floats) -> tuple[Floats, Floats]:
    """F at the integration points, shape (cells, points, 3, 3), and their volumes in mm³."""
    cells, gradients, volumes = _gradients(mesh)
    return np.eye(3) + np.einsum("cnk,cqnj->cqkj", displacement[cells], gradients), volumes


def volume_ratios(mesh: FieldMesh, displacement: Floats) -> Floats:
    """det F at the integration points, shape (cells, points)."""
    f, _ = deformation(mesh, displacement)
    return np.asarray(np.linalg.det(f))


def strain_energy_mJ(config: Config, mesh: FieldMesh, displacement: Floats) -> float:
    """Strain energy of the base material in the meshed part."""
    f, volumes = deformation(mesh, displacement)
    logarithms = np.log(np.linalg.eigvalsh(np.swapaxes(f, -2, -1) @ f)) / 2
    ratio = logarithms.sum(axis=-1)  # ln J
    material = config.material
    if material.volumetric(1.0, 0.0) > 0:
        logarithms -= ratio[..., None] / 3
    energy = material.energy(material.constants(), OfStretches(np.moveaxis(logarithms, -1, 0))).f
    if not material.volumetric(1.0, 0.0) > 0:  # a law of I₁ itself leaves λ alone to the volume
        energy -= material.shear_MPa * ratio
    bulk = material.volumetric(material.shear_MPa, material.lmbda_MPa)
    return float((volumes * (energy + bulk / 2 * ratio**2)).sum())


def balance(run: Run, fields: Fields) -> float | str:
    """Difference of the work of pressure and the strain energy at the last step, by the work.

    The work is ∫ p dV of the cubic spline through the readings, V being
    the cavity's volume.

    Returns:
        The share; or why it cannot be told.
    """
    config = run.result.config
    effects = sorted(config.extensions.model_fields_set)
    if effects:
        return f"the energy of {', '.join(effects)} is not known here"
    if config.film.model_fields_set:
        return "the energy of its films is not known here"
    pressure, volume = run.column("cavity_pressure_kPa"), run.column("cavity_volume_mm3")
    if pressure is None or volume is None:
        return "nothing was inflated"
    if config.gravity.acceleration_m_s2 or run.column("force_N") is not None:
        return "weight or the plate take part of the work"
    if len(set(run.branch)) > 1 or not (np.diff(volume) > 0).all():
        return "the volume falls"
    curve = CubicSpline(volume, pressure) if len(volume) > 2 else None
    if curve is None:
        return "too few readings"
    work = MPA_PER_KPA * float(curve.integrate(volume[0], volume[-1]))
    energy = strain_energy_mJ(config, fields.mesh, fields.displacements[-1])
    if run.result.facts.mesh.half:
        energy *= 2
    return abs(energy - work) / work


MESH_ERROR: Final = 0.02
"""Largest difference to the finest mesh, by the finest's largest reading."""

ENERGY_ERROR: Final = 0.03
"""Largest difference of work and energy, by the work."""

LEAST_DET_F: Final = 0.0
"""Smallest ratio of volumes; an element that is turned inside out has none > 0."""

NOISE_STD: Final = 2.0
"""Root mean square difference to a measurement, in standard deviations of its noise."""


OPEN: Final = "not checked"


def checks(
    runs: Sequence[Run],
    fields: dict[int, Fields],
    finer: dict[int, int],
    measured: Columns | None,
) -> list[Check]:
    """The rows of "Can I trust it?".

    Args:
        runs: with different titles.
        fields: of the runs that have them, by the run's place.
        finer: for a run on a coarse mesh, the place of the one on the finest mesh.
        measured: readings of an instrument.
    """
    rows = []
    for place, run in enumerate(runs):
        rows.append(_ended(run))
        if place not in finer.values():
            rows.append(_mesh(run, runs[finer[place]] if place in finer else None))
        rows += [
            Check(f"{run.title}: {doubt.title}", "–", "no doubt", "fail", doubt.sentence)
            for doubt in doubts.of_run(run.result, run.result.facts.mesh.single_walls)
        ]
        if isinstance(run.result.config.geometry, AdoptedGeometry):
            linear = run.result.config.solver.element == "P1"
            rows += _adopted(run.title, run.result.config.geometry, linear=linear)
        run_fields = fields.get(place)
        rows += _balance(run, run_fields)
        if run_fields is not None:
            rows.append(_inverted(run, run_fields))
        if measured is not None:
            rows += _measured(run, measured)
    return rows


def _adopted(title: str, part: AdoptedGeometry, *, linear: bool) -> list[Check]:
    """The rows on the back and the mesh of a user's own part, as they were adopted."""
    if not part.back:
        return []
    back: Verdict = "pass" if part.bends_to_back else "open"
    doubts = [doubt for doubt in part.doubts if linear or OF_LINEAR not in doubt]
    words = "; ".join(doubts) or "no element is nearly flat"
    return [
        Check(f"{title}: back of the part", "–", "it bends to it", back, part.back),
        Check(f"{title}: elements of the part", "–", "no doubt", passes(not doubts), words),
    ]


def passes(good: bool) -> Verdict:
    """The verdict on what is good or not."""
    return "pass" if good else "fail"


def _ended(run: Run) -> Check:
    failure = run.result.failure
    complete = run.result.facts.complete
    sentence = failure.sentence() if failure else "all steps converged"
    if not complete and not failure:
        sentence = "it has not come to its end"
    value = f"{len(run.result)} readings"
    return Check(f"{run.title}: load path", value, "to its end", passes(complete), sentence)


def of_mesh(run: Run) -> str:
    """Name of the check of a run's mesh."""
    return f"{run.title}: mesh"


def _mesh(run: Run, finest: Run | None) -> Check:
    """The main reading against that on the finest mesh at the same load, or its estimated error."""
    name = of_mesh(run)
    goal = f"≤ {100 * MESH_ERROR:g} %"
    column = run.experiment.plot.curves[0].column
    if finest is None:
        return _estimated(run, column, name, goal)
    x, y = run.column(over(run).name), run.column(column)
    fine_x, fine_y = finest.column(over(run).name), finest.column(column)
    if x is None or y is None or fine_x is None or fine_y is None:
        return Check(name, "–", goal, "open", f"{OPEN}: one has no {column}")
    rising = np.argsort(fine_x, kind="stable")
    common = (x >= fine_x.min()) & (x <= fine_x.max())
    expected = np.interp(x[common], fine_x[rising], fine_y[rising])
    size = float(np.nanmax(np.abs(expected))) or 1.0
    error = float(np.nanmax(np.abs(y[common] - expected))) / size
    counts = f"{run.elements} against {finest.elements} elements"
    return Check(name, f"{100 * error:.2g} %", goal, passes(error <= MESH_ERROR), counts)


def _estimated(run: Run, column: str, name: str, goal: str) -> Check:
    """The error of the main reading that its run has estimated, where it is largest."""
    check, y = run.result.facts.mesh_check, run.column(column)
    if check is None or y is None:
        again = "run it with --mesh-check, or " if run.experiment.mesh_check else ""
        again += "give a run on a finer mesh beside it"
        return Check(name, "–", goal, "open", f"{OPEN}: {again}")
    if column not in check.errors:
        return Check(name, "–", goal, "open", f"cannot tell: {check.reason(column)}")
    errors = np.array(check.errors[column])
    row, size = int(np.abs(errors).argmax()), float(np.nanmax(np.abs(y))) or 1.0
    share, channel = abs(errors[row]) / size, CHANNELS[column]
    off = f"{errors[row]:+{channel.form}}{channel.symbol}"
    words = f"{said(float(y[row]), channel.symbol)} (mesh: {off})"
    return Check(name, f"{100 * share:.2g} %", goal, passes(share <= MESH_ERROR), words)


def _balance(run: Run, fields: Fields | None) -> list[Check]:
    """The work of pressure against energies, by the run's own book, else by its fields."""
    name, goal = f"{run.title}: energy balance", f"≤ {100 * ENERGY_ERROR:g} %"
    work, error = run.column("pressure_mJ"), run.column("energy_error_mJ")
    share: float | str
    if error is not None:
        most = float(np.nanmax(np.abs(work))) if work is not None else 0.0
        share = float(np.nanmax(np.abs(error))) / most if most else float("nan")
        what = "work of pressure against energy, friction and motion"
    elif fields is not None:
        share = balance(run, fields)
        what = "work of pressure against strain energy, at the last step"
    else:
        return []
    if isinstance(share, str):
        return [Check(name, "–", goal, "open", f"{OPEN}: {share}")]
    return [Check(name, f"{100 * share:.2g} %", goal, passes(share <= ENERGY_ERROR), what)]


def _inverted(run: Run, fields: Fields) -> Check:
    least = min(float(volume_ratios(fields.mesh, u).min()) for u in fields.displacements)
    return Check(
        f"{run.title}: smallest det F", said(least), "> 0", passes(least > LEAST_DET_F),
        f"at the elements' integration points, over {len(fields.rows)} steps",
    )  # fmt: skip


def _measured(run: Run, table: Columns) -> list[Check]:
    """The root mean square difference of each measured channel, by its noise."""
    readings = select_rows(table, "experiment", run.experiment.name)
    along = over(run).name
    x, simulated_x = numbers(readings, along), run.column(along)
    rows = []
    for curve in run.experiment.plot.curves:
        y, simulated = numbers(readings, curve.column), run.column(curve.column)
        channel = CHANNELS.get(curve.column)
        if x is None or y is None or simulated is None or simulated_x is None or not channel:
            continue
        rising = np.argsort(simulated_x, kind="stable")
        inside = (x >= np.nanmin(simulated_x)) & (x <= np.nanmax(simulated_x)) & np.isfinite(y)
        if not inside.any():
            continue
        expected = np.interp(x[inside], simulated_x[rising], simulated[rising])
        rms = float(np.sqrt(np.mean((y[inside] - expected) ** 2)))
        many = rms / channel.noise if channel.noise else float("inf")
        rows.append(
            Check(
                f"{run.title}: measured {channel.title.lower()}",
                f"{said(rms, channel.symbol)} rms",
                f"≤ {said(NOISE_STD * channel.noise, channel.symbol)}",
                passes(many <= NOISE_STD),
                f"{said(many)} times an ordinary instrument's noise, "
                f"{int(inside.sum())} of {len(y)} readings",
            )
        )
    return rows


def finest(runs: Sequence[Run]) -> dict[int, int]:
    """For each run, the place of one with the same configuration on the finest mesh, if any."""
    finer, kinds = {}, [_but_mesh(run) for run in runs]
    for place, run in enumerate(runs):
        alike = [i for i, kind in enumerate(kinds) if kind == kinds[place]]
        best = max(alike, key=lambda i: runs[i].elements or 0)
        if (runs[best].elements or 0) > (run.elements or 0):
            finer[place] = best
    return finer


def _but_mesh(run: Run) -> tuple[str, dict[str, Any]]:
    """Experiment and configuration of a run, without its mesh, its solver and its steps."""
    config = {k: v for k, v in run.result.facts.config.items() if k not in ("mesh", "solver")}
    procedure = {k: v for k, v in config.get("experiment", {}).items() if k != "step_kPa"}
    return run.experiment.name, {**config, "experiment": procedure}
