"""The blind benchmark: figures of verdicts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.blind import ci, score
from benchmarks.blind.opinions import Interval, Judged, Opinion


def judged(
    number: int, kind: str, hidden: tuple[str, ...], said: Opinion, **others: object
) -> Judged:
    first = Opinion("cause", 0.99, hidden, (hidden,)) if hidden else Opinion("none", 0.9, (), ())
    values = {
        "strengths_sigma": (14.0,) * len(hidden), "unexplained_sigma": 0.0, "bound": first,
        "name": f"case {number}", "protocol": "P7+", "full": False, **others,
    }  # fmt: skip
    return Judged(kind=kind, hidden=hidden, said=said, **values)  # type: ignore[arg-type]


def cause(*names: str, probability: float = 0.95) -> Opinion:
    return Opinion("cause", probability, names, (names,))


NOTHING = Opinion("none", 0.8, ("gent",), ())
UNKNOWN = Opinion("unknown", 0.8, ("gent",), ())


def of(cases: list[Judged]) -> dict[str, score.Figure]:
    return {figure.name: figure for figure in score.figures(cases)}


def test_figures_of_verdicts_by_hand() -> None:
    inside, outside = Interval("g", 0.1, 0.3, 0.2), Interval("g", 0.1, 0.3, 0.4)
    twins = Opinion("cause", 0.99, ("prony", "gent"), (("prony", "gent"),))
    every = [
        judged(0, "one", ("prony",), cause("prony"), intervals=(inside,), cut=0.6, bound_cut=0.7),
        judged(1, "one", ("prony",), cause("gent", "prony"), intervals=(outside,), bound=twins),
        judged(2, "one", ("gent",), cause("prony", probability=0.5), cut=0.5, bound_cut=0.1),
        judged(3, "one", ("gent",), NOTHING, strengths_sigma=(0.2,)),
        judged(4, "none", (), NOTHING),
        judged(5, "none", (), cause("gent")),
        judged(6, "outsider", ("tear",), UNKNOWN, unexplained_sigma=9.0),
        judged(7, "outsider", ("slip",), cause("gent"), unexplained_sigma=2.0),
        judged(8, "two", ("gent", "prony"), cause("gent", probability=0.91)),
    ]
    found = of(every)
    visible = found["class named first, visible single effects"]
    assert (visible.count, visible.value, visible.bound) == (3, pytest.approx(2 / 3), 1.0)
    assert visible.met is False
    assert found["class named first, invisible ones"].value == 1.0  # the class leads, unclaimed
    # a class that leads counts as first even where the answer is none or unknown
    assert found["answered with the hidden cause's class, visible single effects"].value == (
        pytest.approx(2 / 3)
    )
    strong = found["class named first on P7+, from 12 σ"]
    assert (strong.count, strong.met) == (3, False)
    assert found["class named first on P7+, 6 to 12 σ"].met is None
    assert found["claims with P ≥ 0.9"].value == pytest.approx(4 / 7)
    assert found["claims with P ≥ 0.9"].bound == pytest.approx(5 / 7)
    assert found["of these right"].value == pytest.approx(3 / 4)
    assert found["false alarms where there is no cause"].value == 0.5
    assert found["detection from 6 σ"].value == 1.0
    unknown = found["outsiders from 6 σ unexplained called unknown"]
    assert (unknown.count, unknown.value, unknown.met) == (1, 1.0, True)
    ties = found["ties not named by one member"]
    assert (ties.count, ties.met) == (1, True)
    assert found["90 % intervals that hold the truth"].value == 0.5
    cut = found["error on readings left out is cut by"]
    assert (cut.count, cut.value, cut.bound, cut.met) == (1, 0.6, 0.7, True)


def test_a_leading_class_that_is_not_answered_is_no_answer() -> None:
    shy = Opinion("unknown", 1.0, ("prony",), ())
    found = of([judged(0, "one", ("prony",), shy)])
    assert found["class named first, visible single effects"].value == 1.0
    answered = found["answered with the hidden cause's class, visible single effects"]
    assert (answered.value, answered.bound, answered.met) == (0.0, 1.0, False)


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
    assert [each.case for each in committed] == ci.names()
    assert len(committed) >= 12
    assert {each.answer for each in committed} == {"cause", "none", "unknown"}
    assert any(" + " in each.named for each in committed)
    assert any(" or " in each.named for each in committed)
