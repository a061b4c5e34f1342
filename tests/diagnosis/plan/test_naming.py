"""From which strength on an effect is named, against hidden effects with noise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import Config
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.core.decision import decide
from dolfingrip.diagnosis.core.search import search
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.plan.case import PlannedCase, joined, planned_case
from dolfingrip.diagnosis.plan.naming import Hiding, Naming, namings, share
from dolfingrip.diagnosis.plan.plan import read_alike
from dolfingrip.diagnosis.simulation.runner import Workers

SEED = 3
DRAWS = 12
RIG = """experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.05
"""
EFFECTS = ("mooney_rivlin", "gent", "force_offset")


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    file = tmp_path_factory.mktemp("rig") / "rig.toml"
    file.write_text(RIG, encoding="utf-8")
    return rig.read(file, Config())[0]


@pytest.fixture(scope="module")
def planned(measurement: Measurement) -> PlannedCase:
    return planned_case(measurement, Config(), Workers(Path("nowhere")), EFFECTS)


def by_name(found: list[Naming]) -> dict[str, Naming]:
    return {each.effect: each for each in found}


def test_it_takes_the_strength_that_is_told(planned: PlannedCase) -> None:
    """With noise and with pairs as rivals, named in most cases at twice the least strength, in few
    at 0.4 times it."""
    found = by_name(namings(planned))
    print("seed", SEED, found)
    rng = np.random.default_rng(SEED)
    root = np.linalg.cholesky(planned.case.covariance)
    name = "gent"
    least = found[name].named_from
    assert least is not None
    hiding = Hiding(planned, planned.causes[name])
    shares = []
    for factor in (0.4, 2.0):
        hidden = planned.hidden(name, hiding.at(factor * least))
        named = []
        for _ in range(DRAWS):
            value = hidden.value + root @ rng.standard_normal(len(root))
            decision = decide(search(replace(hidden, value=value), rng, sample=False))
            named.append(decision.answer == "cause" and decision.first == (name,))
        shares.append(np.mean(named))
    print(shares)
    assert shares[0] < 0.4
    assert shares[1] > 0.6


def test_strengths_are_parts_of_the_prior(planned: PlannedCase) -> None:
    """The ordinary strength is among those that occur, and ζ follows from a strength."""
    for cause in planned.causes.values():
        hiding = Hiding(planned, cause)
        assert hiding.strengths[0] < 1.0 < hiding.strengths[-1]
        assert (np.diff(hiding.strengths) >= 0).all()
        first = [hiding.at(float(s))[0] for s in hiding.strengths]
        assert (np.diff(first) >= 0).all()


def test_what_is_read_besides_tells_more(measurement: Measurement, planned: PlannedCase) -> None:
    ways = proposals(measurement, Config())
    more = next(each for each in ways if each.name == "a coupon, loading and unloading")
    whole = joined(measurement, read_alike(more, measurement))
    assert [test.number for test in whole.tests] == [0, 1]
    assert len(whole.listed()) == len(measurement.listed()) + len(more.measurement.listed())
    before = by_name(namings(planned))
    after = namings(planned_case(whole, Config(), Workers(Path("nowhere")), EFFECTS), before)
    for each in after:
        assert each.strength_sigma > 0.99 * before[each.effect].strength_sigma
        assert each.share >= before[each.effect].share
    assert share(after) >= share(list(before.values()))
    print(before, after)
