"""The page of a diagnosis: ten lines, then tables."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd

from dolfingrip.diagnosis.answer.diagnosis import SetupEstimate
from dolfingrip.diagnosis.answer.ten_lines import _off, answer_sentence
from dolfingrip.diagnosis.results import _off as off_in_words
from dolfingrip.diagnosis.results import page
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files.diagnosis import HEADINGS
from dolfingrip.report.diagnosis import probabilities

LINES = outcome.Brief(
    result="the cause is a regulator whose scale is off (pressure_gain)", size="6 %", fit="0.1 deg",
    check="not done", not_explained="1 %", also_possible="nothing", cannot_be_seen="nothing",
    assumed="the modulus", do_next="nothing", use_it="dolfingrip bend",
)  # fmt: skip


def test_ten_lines_come_first_and_doubts_last() -> None:
    verdict = outcome.Verdict.model_validate(
        {"answer": "cause", "class": ("pressure_gain",), "probability": 0.95, "takes_part": 0.95,
         "sentence": "the cause is pressure_gain"}
    )  # fmt: skip
    noise = outcome.AssumedNoise(std={}, sentences=())
    proposed = outcome.NextExperiment(
        name="a hold", minutes=3.0, gain=4.0, gain_per_minute=1.3, chance=0.3
    )
    found = outcome.DiagnosisFile(
        version="0", data=(), quick=False, readings=1, verdict=verdict, brief=LINES, causes=(),
        none=0.0, unknown=0.0, screen={}, fits=(), sentences=(), noise=noise,
        under_other_priors={}, nuisances={}, next_experiments=(proposed,), warnings=("beware",),
        simulated_s=0.0,
    )  # fmt: skip
    lines = page(found).splitlines()
    for line, heading in zip(lines, HEADINGS.values(), strict=False):
        assert line.startswith(heading)
    assert lines[0].endswith("(pressure_gain)")
    assert "| a hold | 3 | 0.30 | – | +4.0 |" in lines
    assert lines[-1] == "- beware"
    none = verdict.model_copy(update={"answer": "none", "probability": 0.4})
    hides = found.model_copy(update={"verdict": none, "none": 0.9, "unknown": 0.1})
    bars = probabilities(hides).series[-1]
    assert dict(zip(bars.said, bars.x, strict=True)) == {"0.40": 0.4, "0.50": 0.5, "0.10": 0.1}
    assert [row for row in page(hides).splitlines() if row.startswith(("| none", "| hid"))] == [
        "| none: noise alone | 0.40 |", "| hidden: not seen, not excluded | 0.50 |",
    ]  # fmt: skip


def test_causes_that_were_not_simulated_are_not_excluded() -> None:
    """What no effect explains is said of those that were compared."""
    decision = SimpleNamespace(answer="unknown", nearest=())
    analysis = SimpleNamespace(problem=None, failed={})
    found: Any = SimpleNamespace(
        decision=decision, analysis=analysis, probability=0.97, undecided=False
    )
    assert "that no effect of the catalogue explains" in answer_sentence(found)
    analysis.failed = {"gent": "no equilibrium"}
    assert "no effect of the catalogue that could be simulated explains" in answer_sentence(found)


def test_suction_has_bands_of_its_own() -> None:
    """A model whose angle is 0.1° low throughout; at rest the gauge wavers."""
    control = np.array([-20.0, -10.0, -0.1, 20.0, 60.0, 100.0])
    rows = pd.DataFrame({"experiment": "bending", "control": control})
    read = np.ones(len(control), dtype=bool)
    analysis = SimpleNamespace(
        problem=SimpleNamespace(value=0.1 * control),
        errors=SimpleNamespace(along=SimpleNamespace(load=control / 100.0)),
        measurement=SimpleNamespace(listed=rows, channels=lambda: {"angle_deg": read}),
    )
    found: Any = SimpleNamespace(analysis=analysis, with_best_modulus=lambda: 0.1 * control - 0.1)
    assert [each.split(": ")[0] for each in off_in_words(found)] == [
        "bending, angle_deg, 0 to 25 kPa", "bending, angle_deg, 0 to -25 kPa",
        "bending, angle_deg, 50 to 75 kPa", "bending, angle_deg, 75 to 100 kPa",
    ]  # fmt: skip
    assert off_in_words(found)[1].endswith("-0.1 deg (-6.7 %)")


def test_a_plate_that_was_set_often_is_told_in_one_sentence() -> None:
    gaps = [
        SetupEstimate(f"plate_gap_mm at {at} mm in gap{at}.csv", "mm", 0.3, value, 0.0)
        for at, value in enumerate((0.3, 1.4, 1.6, 1.9))
    ]
    gain = SetupEstimate("pressure_gain", "%", 1.5, 41.0, 0.0)
    assert _off([gain, *gaps]) == [
        "pressure_gain is off by +41 % (prior ±1.5 %: 27.3 standard deviations)",
        "plate_gap_mm is off by +1.4 to +1.9 mm in 3 of 4 settings (prior ±0.3 mm: up to 6.3 "
        "standard deviations)",
    ]
    assert _off(gaps, every=True) == [
        "plate_gap_mm is off by +0.3 to +1.9 mm in 4 of 4 settings (prior ±0.3 mm: up to 6.3 "
        "standard deviations)",
    ]
