"""Readings at places of a path, with derivatives, against differences of whole runs."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pytest
from support.small import SHORT

from dolfingrip import config as configuration
from dolfingrip.config import changed
from dolfingrip.experiments.request import Answer, Place, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.parameter import find
from dolfingrip.sections.form import Form
from dolfingrip.sections.tables import assignments

KEYS = ("finger.wall_mm", "morph.xi1", "form.offsets_mm")
ASKED = {
    "blocked_force": (
        [Place("pressure_kPa", 50.0), Place("force_N", 0.8)],
        ["force_N", "angle_deg", "pressure_kPa", "work_mJ", "peak_stretch"],
    ),
    "bending": ([Place("angle_deg", 3.0)], ["pressure_kPa", "tip_x_mm", "cavity_volume_mm3"]),
    "push": ([Place("pressure_kPa", 50.0)], ["stiffness_y_N_per_mm"]),
}
ROUGH = {"peak_stretch": 0.2}
"""The slope of the largest stretch is that of a smooth mean near it."""


@pytest.mark.slow
@pytest.mark.parametrize("experiment", ASKED)
def test_questions_against_differences(experiment: str) -> None:
    """Along one direction of a dimension, ξ1 and all numbers of a free form together."""
    base = configuration.load(
        None,
        assignments([*SHORT, "solver.rtol=1e-12", "finger.gap_mm=0.3", "experiment.step_kPa=25"]),
    )
    made_for = base
    count = Form(along=3, offsets_mm=()).count(made_for.geometry.solid())
    rng = np.random.default_rng(3)
    base = base.changed(form={"along": 3, "offsets_mm": rng.uniform(-0.03, 0.03, count).tolist()})
    keys = [each.key for each in find(base, list(KEYS))]
    values = np.array([each.value(base) for each in find(base, keys)])
    along = np.array([0.1, 0.1, *rng.uniform(-0.02, 0.02, len(keys) - 2)])
    places, columns = ASKED[experiment]

    def at(step: float, wanted: Sequence[str] | None = None) -> Answer:
        moved = changed(base, dict(zip(keys, (values + step * along).tolist(), strict=True)))
        asked = {"columns": tuple(columns), "places": tuple(places), "made_for": made_for}
        return compute(Request.of(experiment, moved, wanted, **asked))

    # a place is found to 1e-9 of the pressure, which is 1e-4 of a difference over 2e-3
    found, step = at(0.0, keys), 5e-3
    ahead, back = at(step), at(-step)
    for i, place in enumerate(places):
        for column in columns:
            if column in (place.column, "pressure_kPa") and place.column == "pressure_kPa":
                continue
            slope = along @ [found.slopes[column, key][i] for key in keys]
            expected = (ahead.columns[column][i] - back.columns[column][i]) / (2 * step)
            size = abs(expected) if column != place.column else 1.0
            apart = abs(slope - expected) / size
            print(experiment, place, column, slope, expected)
            assert apart < ROUGH.get(column, 1e-4), (place, column)


def test_a_place_that_is_not_reached() -> None:
    asked = Request.of(
        "blocked_force", configuration.load(None, assignments(SHORT)), columns=("angle_deg",),
        places=(Place("force_N", 99.0),),
    )  # fmt: skip
    answer = compute(asked)
    assert answer.failure_class == "not reached"
    assert re.match(r"force_N = 99 is not reached up to 50 kPa; it is \d", answer.failure or "")
