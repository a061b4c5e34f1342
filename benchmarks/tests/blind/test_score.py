"""The blind benchmark: figures of verdicts, and the cases of continuous integration."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.blind import ci, score


def row(kind: str, hidden: str, answer: str, first: str = "", **others: str) -> score.Row:
    values = {
        "protocol": "pull", "second": "", "probability": "0.95", "sigma": "9", "exact_first": "",
        "exact_second": "", "covers": "", "processor_s": "2.0", "commit": "a1", **others,
    }  # fmt: skip
    return {"kind": kind, "hidden": hidden, "answer": answer, "first": first, **values}


def test_figures_of_verdicts_by_hand() -> None:
    every = [
        row("one", "prony", "cause", "prony gent", covers="1 0"),
        row("one", "prony", "cause", "gent"),
        row("one", "prony", "cause", "gent", probability="0.5"),
        row("one", "gent", "unknown", probability="0.8", commit="b2"),
        row("none", "", "none"),
        row("none", "", "cause", "gent", probability="0.6"),
        row("outsider", "", "cause", "gent"),
        row("outsider", "", "cause", "gent", sigma="5.9"),  # the catalogue has its like
        row("with_outsider", "gent", "cause", "gent", second="prony"),
        row("two", "gent prony", "cause", "prony", second="gent yeoh", exact_first="gent"),
        row("two", "gent prony", "cause", "yeoh prony", second=""),
        row("nuisance", "modulus", "cause", "modulus", exact_first="modulus"),
    ]
    told = [line.split(" | ") for line in score.table(every).splitlines()]
    figures = [(line[0].lstrip("| "), line[-1].lstrip("| ").split(" (")[0]) for line in told]
    # one row of 12 does not count
    assert "Cases by the commit whose package answered: a1 10, b2 1." in score.table(every)
    assert figures[2:-4] == [
        ("one cause: named", "1 of 4"),
        ("wrong", "1 of 4"),
        ("cause and outsider: named", "1 of 1"),
        ("wrong", "1 of 1"),  # what the outsider does is claimed as of the catalogue
        ("outsider alone: claimed as of the catalogue", "1 of 1"),
        ("nuisance 3 to 5 σ out: named", "1 of 1"),
        ("named by exact evidence", "1 of 1"),
        ("wrong", "0 of 1"),
        ("two causes: both named", "1 of 2"),
        ("both named by exact evidence", "0 of 2"),
        ("two causes: one of them named", "2 of 2"),
        ("wrong", "0 of 2"),
        ("nothing hidden: alarm", "1 of 2"),
        ("90 % intervals hold the truth", "0.50"),
    ]
    assert "named by exact evidence" not in score.table([row("nuisance", "modulus", "none")])


def test_intervals_of_shares() -> None:
    """Clopper and Pearson (1934): 0.05 = (1 − high)ⁿ of no hits, symmetric for all."""
    low, high = score.interval(0, 20)
    assert low == 0
    assert high == pytest.approx(1 - 0.05 ** (1 / 20))
    assert score.interval(20, 20) == (pytest.approx(1 - high), 1.0)


def test_a_verdict_that_is_worse() -> None:
    before = ci.Answered("a", "prony", "cause", "prony", True)
    assert not before.worse_than(before)
    assert "told apart" in replace(before, named="gent or prony").worse_than(before)
    assert "is right" in replace(before, answer="none", named="", right=False).worse_than(before)
    assert not before.worse_than(replace(before, right=False))
    tied = replace(before, named="gent or prony")
    assert "the readings allow gent or prony" in before.worse_than(tied)


def test_every_kind_of_answer_is_among_the_committed_ones() -> None:
    committed = ci.expected()
    assert [each.case for each in committed] == sorted(f"{c.protocol} {c.name}" for c in ci.cases())
    assert len(committed) == len(ci.CASES) + 3
    assert len(committed) >= 12
    assert {each.answer for each in committed} == {"cause", "none", "unknown"}
    assert any(" + " in each.named for each in committed)
    assert any(" or " in each.named for each in committed)
