"""A finger that swings without damping: second order in the step in time, and kept energy.

Reference: the scheme's order, from steps that are halved.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from benchmarks import ring_down

SHORT = {
    "finger.length_mm": 38.0, "finger.bellows": 2, "mesh.size_mm": 10.0, "mesh.edge_size_mm": 10.0,
    "contact.self_contact": False, "solver.rtol": 1e-9,
}  # fmt: skip


@pytest.mark.slow
def test_a_short_finger_converges_in_second_order() -> None:
    """The rise is smooth, so that it hardly excites modes that steps do not resolve."""
    part = np.minimum(np.arange(31) / 10, 1.0)
    loading = {
        "time_s": [i / 1000 for i in range(31)],
        "pressure_kPa": (20 * part**3 * (10 - 15 * part + 6 * part**2)).tolist(),
    }
    *_, last = ring_down.rows(SHORT, [1e-3, 5e-4, 2.5e-4, 1.25e-4], loading)
    for name in ring_down.ERRORS.values():
        assert last[name] == pytest.approx(2.0, abs=0.2), name
    assert last["energy_change"] < 1e-4


def test_the_table_of_the_default_finger_tends_to_second_order() -> None:
    """Errors fall from row to row; those of the energy and of the first mode by about four."""
    with Path(ring_down.__file__).with_suffix(".csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["step_ms"]) for row in rows] == list(ring_down.STEPS_MS[:-1])
    errors = {name: np.array([float(row[name]) for row in rows]) for name in ring_down.ERRORS}
    for name, fallen in errors.items():
        assert (np.diff(fallen) < 0).all(), name
    halvings = len(rows) - 1
    for name in ("first_mode_deg", "energy_change"):
        assert np.log2(errors[name][0] / errors[name][-1]) / halvings > 1.7, name
    assert float(rows[-1]["order"]) == pytest.approx(2.0, abs=0.2)
