"""From which strength on an effect is named, against hidden effects with noise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from dolfingrip.config import Config
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.decision import decide
from dolfingrip.diagnosis.core.evidence import InferenceProblem
from dolfingrip.diagnosis.core.search import search
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement, joined
from dolfingrip.diagnosis.plan import (
    NOISES,
    Draw,
    Hidden,
    analyse_plan,
    namings,
    read_alike,
    share,
    threshold,
)
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.files.plan import EffectOutlook

SEED = 3
DRAWS = 6
RIG = """experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.05
"""
EFFECTS = ("mooney_rivlin", "ogden_terms", "print_anisotropy", "yeoh", "permanent_set", "prony")


def made(measurement: Measurement) -> Analysis[Any]:
    return analyse_plan(measurement, Config(), Workers(Path("nowhere")), EFFECTS)


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    file = tmp_path_factory.mktemp("rig") / "rig.toml"
    file.write_text(RIG, encoding="utf-8")
    return rig.read(file, Config())[0]


@pytest.fixture(scope="module")
def planned(measurement: Measurement) -> Analysis[Any]:
    """A coupon, loaded once at one rate."""
    return made(measurement)


@pytest.fixture(scope="module")
def found(planned: Analysis[Any]) -> dict[str, EffectOutlook]:
    return by_name(namings(planned))


def by_name(found: list[EffectOutlook]) -> dict[str, EffectOutlook]:
    return {each.effect: each for each in found}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "mooney_rivlin",
        pytest.param("permanent_set", marks=pytest.mark.xfail(
            reason="two draws at each strength put the least one too low, where a third is named",
            raises=AssertionError, strict=True,
        )),
    ],
)  # fmt: skip
def test_it_takes_the_strength_that_is_told(
    name: str, planned: Analysis[Any], found: dict[str, EffectOutlook]
) -> None:
    """Named in most of noisy cases at 1.4 times the least strength, in few at 0.6 times.

    By the search of a diagnosis, with pairs of causes.
    """
    least = found[name].named_from
    assert least is not None
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    root = np.linalg.cholesky(planned.problem.covariance)
    hidden = Hidden(planned, planned.causes[name])
    shares = []
    for factor in (0.6, 1.4):
        named = 0
        for _ in range(DRAWS):
            own = root @ rng.standard_normal(len(root))
            value = (
                planned.problem.base
                + hidden.visibility.change(name, hidden.at(factor * least, rng))
                + own
            )
            decision = decide(search(replace(planned.problem, value=value), rng, sample=False))
            named += decision.answer == "cause" and decision.first == (name,)
        shares.append(named / DRAWS)
    print(found[name], shares)
    assert shares[0] < 0.3
    assert shares[1] > 0.7


@pytest.mark.slow
def test_twins_are_named_together_long_before_they_are_told_apart(
    found: dict[str, EffectOutlook],
) -> None:
    one, other = found["yeoh"], found["print_anisotropy"]
    assert "print_anisotropy" in one.confused_with
    assert one.class_from is not None
    # the best Yeoh law leaves a chi-square of 18 of the other's ordinary change without noise
    assert other.class_from is not None
    assert one.named_from is None or one.named_from > 2 * one.class_from
    assert one.class_share > one.share


@pytest.mark.slow
def test_one_loading_does_not_tell_viscosity_from_elasticity(
    measurement: Measurement, found: dict[str, EffectOutlook]
) -> None:
    """Some elastic law of the catalogue follows it; another rate or the way back tells."""
    assert found["prony"].share == 0.0
    assert found["prony"].class_share > 0.3
    assert "ogden_terms" in found["prony"].confused_with
    ways = {each.name: each for each in proposals(measurement, Config())}
    for way in ("a coupon at a tenth of the rate", "a coupon, loading and unloading"):
        both = joined(measurement, read_alike(ways[way], measurement))
        assert [test.number for test in both.tests] == [0, 1]
        after = by_name(namings(made(both), list(found.values())))
        assert after["prony"].share > 0.6
        assert after["prony"].at_ordinary
        for name, each in found.items():
            assert after[name].strength_sigma > 0.99 * each.strength_sigma
            assert after[name].share >= each.share


@pytest.mark.slow
def test_what_is_read_again_tells_more(
    measurement: Measurement, planned: Analysis[Any], found: dict[str, EffectOutlook]
) -> None:
    """Twice the readings: at most √2 times the strength, as all else is shared."""
    twice = made(joined(measurement, measurement))
    n = len(planned.problem.value)
    assert len(twice.problem.value) == 2 * n
    after = namings(twice, list(found.values()))
    for each in after:
        assert 1.0 < each.strength_sigma / found[each.effect].strength_sigma < 1.42
    often = joined(joined(measurement, measurement), joined(measurement, measurement))
    assert share(namings(made(often))) > share(list(found.values()))
    # what the addition does not feel is no weaker for it
    cases = planned, replace(planned, problem=blind(planned, n))
    for cause in planned.causes.values():
        alone, beside = (Hidden(case, cause).strength(1.0) for case in cases)
        assert beside == pytest.approx(alone)


def blind(planned: Analysis[Any], count: int) -> InferenceProblem:
    """With readings that nothing changes."""
    case, more = planned.problem, np.zeros(count)

    below = ((0, count), (0, 0))
    return replace(
        case, value=np.r_[case.value, more], base=np.r_[case.base, more],
        noise=np.r_[case.noise, more + 1.0], linear=np.pad(case.linear, below),
        blends={
            causes: replace(each, columns=np.pad(each.columns, below))
            for causes, each in case.blends.items()
        },
        covariance=scipy.linalg.block_diag(case.covariance, np.eye(count)),
        kernel=scipy.linalg.block_diag(case.kernel, np.zeros((count, count))),
    )  # fmt: skip


@pytest.mark.slow
def test_strengths_are_parts_of_the_prior(planned: Analysis[Any]) -> None:
    """The ordinary strength is among those that occur, and ζ follows from a strength."""
    for cause in planned.causes.values():
        hidden = Hidden(planned, cause)
        assert hidden.strengths[0] < 1.0 < hidden.strengths[-1]
        assert (np.diff(hidden.strengths) >= 0).all()
        first = [hidden.at(float(s))[0] for s in hidden.strengths]
        assert (np.diff(first) >= 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("least", [0, 1, 5, Policy().strengths])
def test_strengths_between_are_not_drawn(planned: Analysis[Any], least: int) -> None:
    """As where all are: none below a place is named, one draw there, and all above."""
    told = np.clip(1 + np.arange(Policy().strengths) - least, 0, NOISES)
    drawn: list[int] = []

    class Told(Hidden):
        def drawn(self, place: int) -> list[Draw]:
            drawn.append(place)
            return [(("yeoh",) if i < told[place] else (), {}) for i in range(NOISES)]

    hidden = Told(planned, planned.causes["yeoh"])
    assert (hidden.counted(lambda each: len(each[0]) == 1) == told).all()
    assert len(drawn) < Policy().strengths


@pytest.mark.parametrize(
    ("count", "least"),
    [
        ([2, 2, 2, 2], 1.0),
        ([0, 0, 2, 2], 6.0**0.5),
        ([0, 1, 2, 2], 6.0**0.5),
        ([0, 2, 1, 2], 2.0**0.5),
        ([0, 0, 0, 1], None),
        ([0, 0, 0, 0], None),
    ],
)
def test_least_strength_leaves_the_fewest_draws_on_the_wrong_side(
    count: list[int], least: float | None
) -> None:
    told = threshold(np.arange(1.0, 5.0), np.array(count))
    assert told == (None if least is None else pytest.approx(least))
