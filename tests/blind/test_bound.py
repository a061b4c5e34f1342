"""The blind benchmark: what exact evidence says of a case."""

from __future__ import annotations

import numpy as np
import pytest
from blind.made_up import case, made_up

from benchmarks.blind import bound, cases
from benchmarks.blind.opinions import Opinion
from benchmarks.blind.response import Hidden


def test_the_bound_names_what_is_strong_and_nothing_where_nothing_is() -> None:
    catalogue = made_up()
    exact = bound.Bound(catalogue)
    strong = case(catalogue, Hidden("mooney_rivlin", 0, 1.0))
    found = exact.attained(strong, cases.read(strong, catalogue.vector(strong.truth)))
    opinion = Opinion.of_verdict(found.verdict)
    assert (opinion.answer, opinion.named) == ("cause", (("mooney_rivlin",),))
    assert found.strengths_sigma[0] > 6
    assert found.cut > 0.5
    (strength,) = found.intervals
    assert strength.high - strength.low < 0.5
    none = case(catalogue, kind="none")
    nothing = exact.attained(none, cases.read(none, catalogue.vector(none.truth)))
    assert nothing.verdict.answer == "none"
    assert (nothing.strengths_sigma, nothing.unexplained_sigma) == ((), 0.0)


def test_what_a_cause_of_the_catalogue_explains_is_not_unexplained() -> None:
    catalogue = made_up()
    exact = bound.Bound(catalogue)
    kept = np.ones(len(exact.index), dtype=bool)
    analysis = exact.analysis(kept)
    own = analysis.covariance.whiten(exact.change([Hidden("mooney_rivlin", 0, 1.0)]))
    assert bound.unexplained(analysis, own) == pytest.approx(0, abs=1e-4)
    other = analysis.covariance.whiten(exact.change([Hidden("perspective", 0, 1.0)]))
    assert 0.5 < bound.unexplained(analysis, other) <= np.linalg.norm(other)
