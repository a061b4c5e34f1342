"""Told errors of meshes against the extrapolated mesh, for fingers of all kinds.

    scripts/run python -m benchmarks.mesh_errors

writes ``benchmarks/mesh_errors.csv``. Runs are kept in ``--out``, so that a second call goes on.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from benchmarks.orders import Limit, extrapolate
from dolfingrip.config import Config, ConfigError, load
from dolfingrip.experiments.loop import run
from dolfingrip.experiments.mesh_error import estimate
from dolfingrip.experiments.results.readings import Readings
from dolfingrip.files import table, whole
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.sections.tables import assignments

COLUMNS: Final = {"bending": "angle_deg", "blocked_force": "force_N"}
TABLE: Final = Path(__file__).with_suffix(".csv")

_BELLOWS: Final = (
    "finger.bellows=3 finger.length_mm=45 plate.contact_length_mm=10 "
    "experiment.max_pressure_kPa=100 experiment.step_kPa=50 solver.max_step_kPa=50"
)
_CAST: Final = (
    "finger.kind=cast cast.chambers=2 plate.contact_length_mm=5 film.silk.model=layer "
    "film.silk.region=film film.silk.Et_N_per_mm=50 material.mu_MPa=0.0204 "
    "experiment.max_pressure_kPa=10 experiment.step_kPa=5 solver.max_step_kPa=5"
)
_PNEUNET: Final = (
    "finger.kind=pneunet pneunet.chambers=2 plate.contact_length_mm=5 film.paper.model=layer "
    "film.paper.region=paper film.paper.Et_N_per_mm=50 experiment.max_pressure_kPa=100 "
    "experiment.step_kPa=50 solver.max_step_kPa=50"
)
_ROUND: Final = (
    "finger.kind=round_bellows round_bellows.convolutions=2 plate.contact_length_mm=5 "
    "cavity.cavity_2.pressure_ratio=0 experiment.max_pressure_kPa=20 experiment.step_kPa=10 "
    "solver.max_step_kPa=10"
)
PART: Final = Path("examples/half_round_finger.step")
MESHES: Final = {
    "half_round_6.msh": MeshRequest(size_mm=6.0, order=1),
    "half_round_2.msh": MeshRequest(size_mm=2.0, order=2),
    "half_round_1.5.msh": MeshRequest(size_mm=1.5, order=2),
    "half_round_1.msh": MeshRequest(size_mm=1.0, order=2),
}
"""Meshes of that part, which are made where a finger names them. Those of the limit are curved."""
_ADOPTED: Final = (
    "finger.kind=adopted adopted.length_mm=70 adopted.width_mm=20 adopted.depth_mm=13 "
    "adopted.wall_mm=2.48 solver.element=P2 material.mu_MPa=0.24 contact.self_contact=false "
    "film.sheet.Et_N_per_mm=100 plate.contact_length_mm=5 experiment.max_pressure_kPa=10 "
    "experiment.step_kPa=5 solver.max_step_kPa=5"
)
_THREAD: Final = (
    f"{_ADOPTED} film.thread.group=skin film.thread.Et_N_per_mm=0 "
    "film.thread.fibre_Et_N_per_mm=[300,300] film.thread.fibre_deg=[85,-85]"
)


@dataclass(frozen=True)
class Series:
    """A finger, and meshes that its limit is extrapolated from.

    Attributes:
        settings: of the finger, as KEY=VALUE.
        meshes: settings of the reference meshes, with a size in any unit.
    """

    settings: str
    meshes: tuple[tuple[str, float], ...]


_OF_PART: Final = (
    ("mesh.file=half_round_2.msh", 2.0),
    ("mesh.file=half_round_1.5.msh", 1.5),
    ("mesh.file=half_round_1.msh", 1.0),
)
BISECTED: Final = "mesh.refine=2"
"""What the check of a mesh runs again, too."""
REFINED: Final = (("", 1.0), (BISECTED, 0.5))
SERIES: Final = {
    "bellows": Series(_BELLOWS, REFINED),
    "thin bellows": Series(f"{_BELLOWS} finger.wall_mm=1.2", REFINED),
    "paper's design": Series(f"{_BELLOWS} morph.xi1=0.507 morph.xi2=-0.499", REFINED),
    "cast block": Series(_CAST, (*REFINED, ("mesh.refine=3", 1 / 3))),
    "cast block of three": Series(f"{_CAST} cast.chambers=3", (*REFINED, ("mesh.refine=3", 1 / 3))),
    "pneu-net": Series(_PNEUNET, REFINED),
    "round bellows": Series(_ROUND, (("mesh.size_mm=2", 2.0), ("mesh.size_mm=1.4", 1.4))),
    "adopted mesh": Series(_ADOPTED, _OF_PART),
    "fibre-reinforced": Series(_THREAD, _OF_PART),
}

KNOWN: Final = {
    ("default finger", "bending"): Limit(148.1, float("nan"), 0.1),
    ("default finger", "blocked_force"): Limit(3.928, float("nan"), 0.0087),
}
"""Limits of the default finger at 250 kPa; from ``benchmarks/results.md``."""

ROWS: Final = (
    ("bellows", "mesh.edge_size_mm=7", "bending"),
    ("bellows", "mesh.edge_size_mm=7", "blocked_force"),
    ("bellows", "solver.element=P2 mesh.size_mm=4", "bending"),
    ("bellows", "solver.element=P2 mesh.size_mm=4", "blocked_force"),
    ("bellows", "", "bending"),
    ("bellows", "", "blocked_force"),
    ("adopted mesh", "mesh.file=half_round_6.msh", "bending"),
    ("fibre-reinforced", "mesh.file=half_round_6.msh", "bending"),
    ("cast block", "", "bending"),
    ("cast block of three", "", "bending"),
    ("pneu-net", "", "bending"),
    ("round bellows", "mesh.size_mm=6", "bending"),
    ("thin bellows", "", "bending"),
    ("paper's design", "", "bending"),
    ("paper's design", "", "blocked_force"),
    ("round bellows", "mesh.size_mm=4", "bending"),
    ("default finger", "", "bending"),
    ("default finger", "", "blocked_force"),
)
"""Finger, its mesh, and the experiment."""


class Runs:
    """Runs that are kept in a folder by what was asked.

    Args:
        folder: made where there is none.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._file = folder, folder / "runs.json"
        self._known: dict[str, Any] = (
            json.loads(self._file.read_text(encoding="utf-8")) if self._file.exists() else {}
        )

    def of(self, experiment: str, settings: str) -> dict[str, Any]:
        """Run an experiment, or read what it gave.

        Args:
            experiment: its name.
            settings: as KEY=VALUE.

        Returns:
            Last reading, unknowns, and seconds.
        """
        key = " ".join([experiment, *settings.split()])
        if key not in self._known:
            result = run(experiment, self._config(settings))
            found = {
                "value": float(result.column(COLUMNS[experiment])[-1]),
                "dofs": result.facts.mesh.dofs, "wall_s": result.facts.wall_s,
            }  # fmt: skip
            self._known[key] = found
            whole.write(self._file, json.dumps(self._known, indent=1))
            print(key, found, flush=True)
        answer: dict[str, Any] = self._known[key]
        return answer

    def told(self, experiment: str, settings: str) -> tuple[float | None, float]:
        """The error of the last reading as a run with a mesh check tells it.

        Args:
            experiment: its name.
            settings: as KEY=VALUE.

        Returns:
            The error in the reading's unit, None where the run says that it cannot tell; and
            seconds of the check.
        """
        column, config = COLUMNS[experiment], self._config(settings)
        own = self.of(experiment, settings)
        try:
            finer = self.of(experiment, f"{settings} {BISECTED}")
        except ConfigError as reason:
            print(f"{experiment} {settings}: cannot tell: {reason}", flush=True)
            return None, 0.0
        here, there = (
            Readings(experiment, config, [{column: each["value"]}]) for each in (own, finer)
        )
        errors = estimate(here, there).errors.get(column)
        return None if errors is None else errors[-1], finer["wall_s"]

    def _config(self, settings: str) -> Config:
        return load(None, self._placed(assignments(settings.split())))

    def _placed(self, settings: dict[str, Any]) -> dict[str, Any]:
        """Settings with the place of their mesh, which is made where there is none."""
        if (name := settings.get("mesh.file")) is None:
            return settings
        if not (file := self._folder / name).exists():
            part = adopt(PART, Asked(), MESHES[name])
            files.write(file, part.mesh)
        return settings | {"mesh.file": str(file)}


def verdict(true: float, told: float | None, uncertainty: float) -> str:
    """Judge a told error: right, wrong, or what kept it from being either.

    Args:
        true: error against the limit.
        told: error; None: the run says that it cannot tell.
        uncertainty: of the limit.
    """
    if told is None:
        return "cannot tell"
    if abs(told - true) <= abs(true) / 3:
        return "right"
    return "within the limit's" if abs(told - true) <= uncertainty + abs(true) / 3 else "wrong"


def limit(finger: str, experiment: str, runs: Runs) -> Limit:
    """Extrapolate a reading.

    Args:
        finger: of :data:`SERIES` or :data:`KNOWN`.
        experiment: its name.
        runs: of its meshes.
    """
    if (finger, experiment) in KNOWN:
        return KNOWN[finger, experiment]
    series = SERIES[finger]
    sizes = [size for _, size in series.meshes]
    values = [
        float(runs.of(experiment, f"{series.settings} {mesh}")["value"])
        for mesh, _ in series.meshes
    ]
    return extrapolate(sizes, values)


def rows(runs: Runs) -> list[dict[str, object]]:
    """Make the table.

    Args:
        runs: kept ones.
    """
    found: list[dict[str, object]] = []
    for finger, mesh, experiment in ROWS:
        settings = SERIES[finger].settings if finger in SERIES else ""
        own = runs.of(experiment, f"{settings} {mesh}")
        limiting = limit(finger, experiment, runs)
        true = own["value"] - limiting.value
        told, check_s = runs.told(experiment, f"{settings} {mesh}")
        found.append(
            {
                "finger": finger, "mesh": mesh or "default", "reading": COLUMNS[experiment],
                "unknowns": own["dofs"], "value": f"{own['value']:.4f}",
                "limit": f"{limiting.value:.4f}", "uncertainty": f"{limiting.uncertainty:.4f}",
                "error": f"{true:.4f}", "told": "cannot tell" if told is None else f"{told:.4f}",
                "told_by_error": "" if told is None else f"{told / true:.2f}",
                "left_percent": ""
                if told is None
                else f"{100 * abs(true - told) / abs(limiting.value):.2f}",
                "verdict": verdict(true, told, limiting.uncertainty),
                "run_s": own["wall_s"], "check_s": check_s,
            }
        )  # fmt: skip
        table.write(TABLE, found)
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/mesh_errors"))
    for row in rows(Runs(parser.parse_args(arguments).out)):
        print(*row.values(), sep="\t")


if __name__ == "__main__":
    main()
