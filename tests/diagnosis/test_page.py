"""The third line of a summary: what to measure next, and what may be expected of it."""

from __future__ import annotations

import pytest

from dolfingrip.diagnosis import outcome, page


def found(
    verdict: outcome.Verdict, proposed: tuple[outcome.NextExperiment, ...] = (), none: float = 0.0
) -> outcome.DiagnosisFile:
    noise = outcome.Noise(std={}, correlated_std={}, models={}, verdicts={}, sentences=())
    return outcome.DiagnosisFile(
        version="0", data=(), quick=False, readings=1, verdict=verdict, classes=(), none=none,
        unknown=0.0, screen={}, fits=(), differences=(), sentences=(), noise=noise, nuisances={},
        next_experiments=proposed, simulated_s=0.0,
    )  # fmt: skip


def third_line(gain: float, splits: bool) -> str:
    verdict = outcome.Verdict.model_validate(
        {"answer": "cause", "class": ("gent", "ogden"), "probability": 0.95, "takes_part": 0.95,
         "sentence": "the cause is gent or ogden"}
    )  # fmt: skip
    proposed = outcome.NextExperiment(
        name="a hold", minutes=3.0, gain=gain, gain_per_minute=gain / 3, splits=splits
    )
    return page.text(found(verdict, (proposed,))).splitlines()[2]


@pytest.mark.parametrize(
    ("none", "told"),
    [
        (0.9, "Next experiment: none; the readings agree with the model within their noise."),
        (0.4, "Next experiment: none is ranked, as nothing is claimed; another channel, unloading, "
              "or a coupon in another mode would tell more."),
    ],
)  # fmt: skip
def test_a_weak_none_asks_for_other_readings(none: float, told: str) -> None:
    verdict = outcome.Verdict.model_validate(
        {"answer": "none", "class": (), "probability": none, "takes_part": 0.0,
         "sentence": "no cause can be seen"}
    )  # fmt: skip
    assert page.text(found(verdict, none=none)).splitlines()[2] == told


@pytest.mark.parametrize(
    ("gain", "splits", "told"),
    [
        (20.0, True, "Next experiment: a hold (3 minutes)."),
        (4.0, False, "Next experiment: a hold (3 minutes); it may not tell all of them apart."),
        (0.01, False, "Next experiment: no addition of the list tells them apart; a hold would "
                      "tell the most."),
    ],
)  # fmt: skip
def test_an_experiment_that_tells_nothing_is_not_proposed(
    gain: float, splits: bool, told: str
) -> None:
    assert third_line(gain, splits) == told
