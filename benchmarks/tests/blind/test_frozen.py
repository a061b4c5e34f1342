"""Blind cases as files: each has readings, a set-up and a truth; a row comes back as it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.hidden_coupon import NOISE_N, PROTOCOLS, Truth

from benchmarks.blind import answers, frozen, score
from benchmarks.blind.case import SEEN, strength
from benchmarks.blind.coupons.cases import Strength
from benchmarks.blind.frozen import FrozenCase
from dolfingrip.diagnosis.data.measurement import read

CASE = FrozenCase(
    "pull", "with_outsider", 3, True, ("yeoh",), "screw", 1.5, (41.5, 30.25), None,
    {"modulus": 1.25, "extensions.prony.tau_s": [8.0]}, (1, 2),
)  # fmt: skip


def test_a_case_comes_back_as_it_was(tmp_path: Path) -> None:
    measured = tmp_path / "measured" / "pull.csv"
    measured.parent.mkdir()
    measured.write_text("displacement_mm,force_N\n1,2\n3,4\n", encoding="utf-8")
    measured.with_suffix(".toml").write_text('experiment = "coupon"\n', encoding="utf-8")
    folder = tmp_path / "frozen"
    frozen.add(CASE, measured, folder)
    other = FrozenCase("pull", "none", 3, False, left=7.5)
    frozen.add(other, measured, folder)
    assert frozen.cases("pull", folder) == [CASE, other]
    assert list(frozen.protocols(folder)) == ["pull"]
    for case in (CASE, other):
        again = frozen.written(case, tmp_path / "again", folder)
        for suffix in (".csv", ".toml"):
            assert again.with_suffix(suffix).read_text() == measured.with_suffix(suffix).read_text()
    # killed between the readings and the truth: the readings do not stand twice
    (folder / "pull-truth.csv").unlink()
    frozen.add(CASE, measured, folder)
    assert frozen.written(CASE, tmp_path / "again", folder).read_text() == measured.read_text()
    measured.with_suffix(".toml").write_text('experiment = "bending"\n', encoding="utf-8")
    with pytest.raises(ValueError, match="another set-up than that of none-3"):
        frozen.add(other, measured, folder)


@pytest.mark.parametrize("protocol", list(frozen.protocols()))
def test_committed_cases_are_measured_data(protocol: str, tmp_path: Path) -> None:
    """Cases say what is hidden, and the first of each kind is measured data."""
    cases = frozen.cases(protocol)
    assert len({case.name for case in cases}) == len(cases)
    for case in cases:
        strong = case.sigma[:-1] if case.kind == "with_outsider" else case.sigma
        assert len(case.hidden) == {"two": 2, "none": 0, "outsider": 0}.get(case.kind, 1)
        assert bool(case.outsider) == (case.kind in ("outsider", "with_outsider"))
        if case.kind not in ("nuisance", "none"):
            assert min(strong) > SEEN / 2  # the draw's own count was SEEN or more
        if case.number == 0:
            file = frozen.written(case, tmp_path / case.name)
            found = read([file], answers.configured(protocol))
            assert not found.warnings
            assert found.listed["value"].isna().sum() == 0


def test_strength_of_a_change() -> None:
    """By hand: noise 2, a rig that moves both readings alike, and a modulus that moves one."""
    noise, both = 4 * np.eye(2), np.ones((2, 1))
    along = np.array([1.0, 0.0])
    assert strength(np.array([5.0, 0.0]), noise, along) == pytest.approx(0.0)
    assert strength(np.array([0.0, 6.0]), noise, along) == pytest.approx(3.0)
    # alike they are within what the rig does: 6²/(4 + 2·9) of each, after the modulus less
    with_rig = strength(np.array([0.0, 6.0]), noise + 9 * both @ both.T, along)
    assert with_rig == pytest.approx(6 / np.sqrt(4 + 9))


def test_strengths_of_coupons_come_from_simulations_alone() -> None:
    """A force that is 1.2 N off is within the scatter of specimens; one of its shape is not."""
    by = Strength(PROTOCOLS["pull"])
    assert by.of(Truth(modulus=1.3)) < 0.5 * by.of(Truth({"extensions.yeoh.C20_MPa": 0.5}))
    assert by.of(Truth(gauge=1.02), "coupon.gauge_length_mm") > by.of(Truth(gauge=1.02))
    rubs = [by.of(Truth(outsider=("guide_rubs", size))) for size in (0.5, 1.0)]
    assert rubs[1] == pytest.approx(2 * rubs[0], rel=0.02)
    assert NOISE_N * rubs[0] > 0


def test_answers_are_scored_beside_the_truth(tmp_path: Path) -> None:
    """Scores of committed cases, by answers that are written by hand."""
    one, nothing = (
        next(each for each in frozen.cases("pull") if each.kind == kind) for kind in ("one", "none")
    )
    rows = [
        {"protocol": "pull", "kind": "one", "number": one.number, "answer": "cause",
         "first": one.hidden[0], "second": "", "probability": 0.95, "covers": "1 0"},
        {"protocol": "pull", "kind": "none", "number": nothing.number, "answer": "none",
         "first": "", "second": "", "probability": 0.9, "covers": "1"},
    ]  # fmt: skip
    header = list(answers.COLUMNS)
    lines = [",".join(header)]
    for row in rows:
        told = {"processor_s": 1.5, "commit": "c0ffee1", **row}
        lines.append(",".join(str(told.get(name, "")) for name in header))
    (tmp_path / "pull.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    figures = score.table(list(answers.scored(tmp_path)))
    assert "| one cause: named |  | 1 of 1" in figures
    assert "| nothing hidden: alarm | ≤ 0.05 | 0 of 1" in figures
    assert "| 0.67 (" in figures
