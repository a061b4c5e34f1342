"""The page of a diagnosis: its bands of load, its rows, and what its charts share with it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from dolfingrip.diagnosis.answer.statistics import bands, common_change
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files.diagnosis_words import page
from dolfingrip.report.diagnosis import probabilities


def test_tables_come_below_the_lines_and_doubts_last() -> None:
    verdict = outcome.Verdict.model_validate(
        {"answer": "none", "class": (), "probability": 0.4, "takes_part": 0.0, "claimed": False}
    )  # fmt: skip
    proposed = outcome.NextExperiment(
        name="a hold", minutes=3.0, gain=4.0, gain_per_minute=1.3, chance=0.3
    )
    number = outcome.FittedNumber(key="material.mu_MPa", value=3.0, low=2.9, high=3.1, unit="MPa")
    found = outcome.DiagnosisFile(
        version="0", data=(), quick=False, readings=1, verdict=verdict, causes=(), none=0.9,
        headline=outcome.Headline(number=number, option=""), unknown=0.1,
        next_experiments=(proposed,), warnings=("beware",),
        simulated_s=0.0,
    )  # fmt: skip
    lines = page(found).splitlines()
    assert "| a hold | 3 | 0.30 | – | 4 |" in lines
    assert lines[-1] == "- beware"
    bars = probabilities(found).series[-1]
    assert dict(zip(bars.said, bars.x, strict=True)) == {"0.40": 0.4, "0.50": 0.5, "0.10": 0.1}
    assert [row for row in lines if row.startswith(("| none", "| hid"))] == [
        "| none: noise alone |  | 0.40 |  |", "| hidden: not seen, not excluded |  | 0.50 |  |",
    ]  # fmt: skip


CONTROL = np.array([-20.0, -10.0, -0.1, 20.0, 60.0, 100.0])


def bending(control: np.ndarray = CONTROL) -> Any:
    """Readings of 0.1° a kPa; at rest the gauge wavers."""
    rows = pd.DataFrame({"experiment": "bending", "control": control})
    read = np.ones(len(control), dtype=bool)
    errors = SimpleNamespace(
        along=SimpleNamespace(load=control / 100.0), noise=np.full(len(control), 0.01)
    )
    return SimpleNamespace(
        problem=SimpleNamespace(value=0.1 * control), configured=0.1 * control, errors=errors,
        measurement=SimpleNamespace(
            listed=rows, channels=lambda: {"angle_deg": read}, policy=Policy(),
            tests=[SimpleNamespace(experiment="bending", prescribed="pressure_kPa")],
        ),
    )  # fmt: skip


def test_suction_has_bands_of_its_own() -> None:
    """A model whose angle is 0.1° low throughout."""
    found = [band for band, *_ in bands(bending(), 0.1 * CONTROL - 0.1)]
    assert [(each.experiment, each.channel, each.start, each.end) for each in found] == [
        ("bending", "angle_deg", 0.0, 25.0), ("bending", "angle_deg", 0.0, -25.0),
        ("bending", "angle_deg", 50.0, 75.0), ("bending", "angle_deg", 75.0, 100.0),
    ]  # fmt: skip
    assert found[1].mean == pytest.approx(-0.1)
    assert found[1].percent == pytest.approx(-100 * 0.1 / 1.5)


def test_a_set_tells_what_its_members_change_alike() -> None:
    """At 100 kPa, 10°, one turns the finger 0.6° less and another 0.5°; at 60 kPa they differ."""
    changes = np.zeros((2, len(CONTROL)))
    changes[:, -1] = -0.6, -0.5
    changes[:, -2] = -0.9, 0.9
    model = bending()
    alike = common_change(model, model.configured + changes, of_body=True)
    assert alike is not None
    assert (alike.way, alike.above, alike.below) == ("stiffer", 75.0, None)
    assert (alike.percent, alike.low, alike.high) == pytest.approx((6.0, 5.0, 6.0))
    with_instrument = common_change(model, model.configured + changes, of_body=False)
    assert with_instrument is not None
    assert with_instrument.way == "lower"
    either_way = (1 + np.array([[0.1], [-0.1]])) * model.configured
    assert common_change(model, either_way, of_body=True) is None
    # 20 times softer, and not reached above
    soft = np.where(CONTROL > 80, np.nan, 0.005 * CONTROL)
    model.configured = soft
    far = common_change(model, np.array([0.1 * CONTROL]), of_body=True)
    assert far is not None
    assert (far.way, far.above, far.below) == ("softer", 50.0, 75.0)
    assert far.percent == pytest.approx(1900.0)
