"""The reference finger's protocol, whose simulations are computed once and shipped."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pandas as pd

from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.lab_setup import LabSetup
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.table import READINGS

PRESSURES_kPa: Final = tuple(25.0 * i for i in range(1, 11))
"""Those of the paper's experiments, above 0."""

RATE_kPa_per_s: Final = 25.0
"""The configuration's ordinary rate; what has a clock depends on it."""

CYCLES: Final = 3

EXPERIMENTS: Final = ("bending", "blocked_force")


def reference_measurement(
    count: int = CYCLES, *, unload: bool = True, experiments: Sequence[str] = EXPERIMENTS
) -> Measurement:
    """Free bending and blocked force in ``count`` cycles, every reading 0: to be simulated."""
    tests = [
        SpecimenTest(i, Path("reference.csv"), name, "reference", LabSetup())
        for i, name in enumerate(experiments)
    ]
    way = rig.cycles(count, unload=unload)
    tables = [
        rig.planned_rows(test, way, PRESSURES_kPa, RATE_kPa_per_s, READINGS[test.experiment])
        for test in tests
    ]
    return Measurement(pd.concat(tables, ignore_index=True), tests)
