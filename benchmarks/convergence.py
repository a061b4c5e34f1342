"""The convergence table's figures: values by mesh, limits, errors."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.orders import Limit, extrapolate
from benchmarks.outcomes import Outcome
from benchmarks.parts import UNGRADED_MM


@dataclass(frozen=True, slots=True)
class Quantity:
    """A reading at 250 kPa."""

    name: str
    column: str
    unit: str


QUANTITIES = {
    "bending": Quantity("angle", "angle_deg", "°"),
    "blocked_force": Quantity("force", "force_N", "N"),
}
"""By experiment."""

DEFAULT = "S2 1"
"""The default mesh."""


@dataclass(frozen=True, slots=True)
class Point:
    """One mesh.

    Attributes:
        mesh: element, size (mm; of S2 the refinement), and size at concave edges where that is
            another (mm).
        size: equivalent element size, (number of elements)^(−1/3).
        seconds: processor time of the run.
    """

    mesh: str
    elements: int
    dofs: int
    size: float
    value: float
    seconds: float
    load: float


def points(outcome: Outcome, kind: str) -> list[Point]:
    """All meshes on which an experiment was run, the coarsest first."""
    found = []
    for label, runs in outcome.runs.items():
        if not label.startswith(kind + " ") or not runs:
            continue
        run = runs[-1]
        value = run["rows"][-1][QUANTITIES[kind].column]
        found.append(
            Point(
                label.removeprefix(kind + " "),
                run["elements"],
                run["dofs"],
                run["elements"] ** (-1 / 3),
                value,
                run["processor_s"],
                run["load"][0],
            )
        )
    return sorted(found, key=lambda point: point.elements)


def series(outcome: Outcome, kind: str, name: str) -> list[Point]:
    """The meshes of an element, ``P2`` or another, that belong together.

    ``uniform`` are those without a size at concave edges; of hexahedra, that is divisions of the
    default mesh. ``ungraded`` and ``graded`` have one.
    """
    element, spacing = name.split()

    def kind_of(mesh: str) -> str:
        if "/" not in mesh:
            return "uniform"
        return "ungraded" if mesh.endswith(f"/{UNGRADED_MM:g}") else "graded"

    return [
        point
        for point in points(outcome, kind)
        if point.mesh.split()[0] == element and kind_of(point.mesh) == spacing
    ]


def limits(outcome: Outcome) -> dict[str, Limit]:
    """Limits of angle and force, by experiment, from divisions of the default mesh.

    Other series of meshes widen the uncertainty where their values lie beyond.
    """
    found = {}
    for kind in QUANTITIES:
        uniform = series(outcome, kind, "S2 uniform")
        if len(uniform) < 2:
            continue
        limit = extrapolate([p.size for p in uniform], [p.value for p in uniform])
        beyond = max(p.value - limit.value for p in points(outcome, kind))
        uncertainty = max(limit.uncertainty, beyond)
        found[kind] = Limit(limit.value, limit.order, uncertainty)
    return found
