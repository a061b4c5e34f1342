"""The page of a diagnosis: ten lines, then tables."""

from __future__ import annotations

from dolfingrip.diagnosis import outcome, page
from dolfingrip.diagnosis.page import HEADINGS

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
    noise = outcome.Noise(std={}, sentences=())
    proposed = outcome.NextExperiment(
        name="a hold", minutes=3.0, gain=4.0, gain_per_minute=1.3, chance=0.3
    )
    found = outcome.DiagnosisFile(
        version="0", data=(), quick=False, readings=1, verdict=verdict, brief=LINES, causes=(),
        none=0.0, unknown=0.0, screen={}, fits=(), sentences=(), noise=noise,
        under_other_priors={}, nuisances={}, next_experiments=(proposed,), warnings=("beware",),
        simulated_s=0.0,
    )  # fmt: skip
    lines = page.text(found).splitlines()
    for line, heading in zip(lines, HEADINGS.values(), strict=False):
        assert line.startswith(heading)
    assert lines[0].endswith("(pressure_gain)")
    assert "| a hold | 3 | +4.0 | no |" in lines
    assert lines[-1] == "- beware"
