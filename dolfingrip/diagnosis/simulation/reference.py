"""The reference finger's ordinary changes on the paper's protocol, computed once and shipped.

    base = simulate_base(paper_measurement(), Config(), workers)
    write(base, file)                        # JSON
    known = read(file)
    known.at(measurement)                    # candidates, aligned with the measurement's readings

So a first screen of a measurement of the reference finger, first loading, needs no simulation. What
it finds is to be simulated on the measurement's own set-up before it is believed.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.data.columns import NUMBERS, READINGS
from dolfingrip.diagnosis.data.lab_setup import LabSetup
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.simulation.base import BaseSimulation
from dolfingrip.diagnosis.simulation.legs import Leg
from dolfingrip.diagnosis.simulation.secants import Candidate

PRESSURES_kPa: Final = tuple(25.0 * i for i in range(11))
"""Those of the paper's experiments."""

RATE_kPa_per_s: Final = 25.0
"""The configuration's ordinary rate; what has a clock depends on it."""

EXPERIMENTS: Final = ("bending", "blocked_force")

_KEPT: Final = ("name", "kind", "labels", "overrides", "parts", "spread", "one_sided", "mesh")
_DIGITS: Final = 5


def paper_measurement(
    pressures_kPa: Sequence[float] = PRESSURES_kPa, specimen: str = "reference"
) -> Measurement:
    """The paper's protocol with every reading 0: something to be simulated."""
    tests = [
        SpecimenTest(i, Path("paper.csv"), name, specimen, LabSetup())
        for i, name in enumerate(EXPERIMENTS)
    ]
    rows: list[dict[str, Any]] = [
        {
            "line": 0, "test": test.number, "experiment": test.experiment, "specimen": specimen,
            "cycle": 1, "branch": "loading", **dict.fromkeys(NUMBERS, np.nan),
            "time_s": pressure / RATE_kPa_per_s, "pressure_kPa": pressure,
            **dict.fromkeys(READINGS[test.experiment], 0.0),
        }
        for test in tests
        for pressure in pressures_kPa
    ]  # fmt: skip
    return Measurement(pd.DataFrame(rows), tests)


def write(base: BaseSimulation, file: Path) -> None:
    """Write the candidates of a base simulation of :func:`paper_measurement`."""
    listed = base.measurement.listed()
    content = {
        "readings": {
            "experiment": list(listed["experiment"]),
            "column": list(listed["column"]),
            "pressure_kPa": list(listed["led"]),
        },
        "base": _short(base.readings),
        "candidates": [
            {
                **{key: getattr(candidate, key) for key in _KEPT},
                "shapes": [_short(shape) for shape in candidate.shapes],
            }
            for candidate in base.candidates
        ],
    }
    partial = file.with_suffix(".part")
    partial.write_text(json.dumps(content) + "\n", encoding="utf-8")
    partial.replace(file)


def _short(values: np.ndarray) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in values]


@dataclass(frozen=True, slots=True)
class ReferenceChanges:
    """What was written.

    Attributes:
        readings: ``experiment``, ``column`` and ``pressure_kPa`` of each reading.
        base: (m,) the base simulation's.
        candidates: with shapes (k, m).
    """

    readings: pd.DataFrame
    base: np.ndarray
    candidates: Sequence[Candidate]

    def weights(self, measurement: Measurement) -> np.ndarray:
        """(n, m) weights by which these readings make those of a measurement.

        Raises:
            ConfigError: one line, where it has other than first loadings of a finger.
        """
        listed = measurement.listed()
        found = np.zeros((len(listed), len(self.readings)))
        for (experiment, column), part in listed.groupby(["experiment", "column"], sort=False):
            same = (self.readings["experiment"] == experiment) & (self.readings["column"] == column)
            at = np.flatnonzero(same)
            if not at.size or (part["cycle"] > 1).any() or (part["branch"] != "loading").any():
                raise ConfigError(
                    f"{column} of {experiment}: not among the reference finger's; allowed: first "
                    f"loadings in {', '.join(EXPERIMENTS)}"
                )
            pressure = self.readings["pressure_kPa"].to_numpy()[at]
            rows = part.index.to_numpy()
            leg = Leg(np.arange(len(at)), pressure, rows, part["led"].to_numpy())
            found[np.ix_(rows, at)] = leg.weights(len(at))
        return found

    def at(self, measurement: Measurement) -> list[Candidate]:
        """The candidates, aligned with ``measurement.listed()``.

        Raises:
            ConfigError: one line, where it has other than first loadings of a finger.
        """
        weights = self.weights(measurement)
        return [
            replace(candidate, shapes=candidate.shapes @ weights.T) for candidate in self.candidates
        ]


def read(file: Path) -> ReferenceChanges:
    """What :func:`write` wrote."""
    content = json.loads(file.read_text(encoding="utf-8"))
    readings = pd.DataFrame(content["readings"])
    candidates = [
        Candidate(
            **{
                **{key: each[key] for key in _KEPT},
                "labels": tuple(each["labels"]),
                "overrides": tuple(map(tuple, each["overrides"])),
                "parts": tuple(each["parts"]),
                "shapes": np.array(each["shapes"], dtype=float).reshape(-1, len(readings)),
            }
        )
        for each in content["candidates"]
    ]
    return ReferenceChanges(readings, np.array(content["base"]), candidates)
