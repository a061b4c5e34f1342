"""Specimens: which stand apart from the others, and which are the same table twice."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.softening_coupons import diagnosed, measured

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import selected


def test_one_that_grips_later_is_told_with_the_answer_without_it(tmp_path: Path) -> None:
    found = diagnosed(measured(tmp_path, {"S4": 0.8}))
    assert found.apart is not None
    print(found.apart)
    assert found.apart.specimens == ("S4",)
    assert found.apart.odds > 20
    without = found.apart.without
    assert (without.answer, without.effects, without.claimed) == (
        "cause", ("mooney_rivlin",), True
    )  # fmt: skip


@pytest.mark.slow
def test_of_four_two_that_grip_later_are_both_told(tmp_path: Path) -> None:
    """Alike or not: the other two share a curve."""
    for number, late in enumerate(({"S2": 0.6, "S4": 1.0}, {"S2": 0.8, "S4": 0.8})):
        folder = tmp_path / str(number)
        folder.mkdir()
        apart = diagnosed(measured(folder, late, count=4)).apart
        print(apart)
        assert apart is not None
        assert apart.specimens == ("S2", "S4")


def test_specimens_that_are_alike_are_not_doubted(tmp_path: Path) -> None:
    """Slack as usual and scatter as usual."""
    assert diagnosed(measured(tmp_path, {"S2": 0.1, "S3": 0.15})).apart is None


@pytest.mark.parametrize("again", [False, True])
def test_the_same_table_counts_once(tmp_path: Path, again: bool) -> None:
    kept, notes = selected(measured(tmp_path, {}, again=again), Config())
    said = "coupon of S6 (lab.csv) has the very readings of coupon of S1 (lab.csv)"
    assert any(said in note for note in notes) == again
    assert [each.specimen for each in kept.tests] == ["S1", "S2", "S3", "S4", "S5"]
    assert sorted(set(kept.readings["test"])) == [0, 1, 2, 3, 4]
