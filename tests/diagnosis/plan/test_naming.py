"""From which strength on an effect is named, against hidden effects with noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from diagnosis.inference import synthetic

from dolfingrip.diagnosis.inference.noise import noise_matrix
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights
from dolfingrip.diagnosis.plan.naming import CLAIM, Naming, namings, share
from dolfingrip.diagnosis.plan.readings import Readings, joined

SEED = 3
DRAWS = 200


def readings(table: pd.DataFrame | None = None) -> Readings:
    own = synthetic.index() if table is None else table
    own = own.assign(run=own["run"].astype("category").cat.codes)
    columns = synthetic.nuisances(own)
    return Readings(
        own, noise_matrix(own, synthetic.NOISE), synthetic.noise_std(own),
        {"modulus": columns[:, 0], "plate_gap": columns[:, 1]}, np.zeros(len(own)),
        np.zeros((len(own), 0)), synthetic.candidates(own),
    )  # fmt: skip


def by_name(found: list[Naming]) -> dict[str, Naming]:
    return {each.effect: each for each in found}


@pytest.mark.parametrize("name", ["hardening", "kink", "set"])
def test_it_takes_the_strength_that_is_told(name: str) -> None:
    """Named in most of noisy cases at 1.4 times the least strength, in few at 0.6 times."""
    own = readings()
    naming = by_name(namings(own))[name]
    assert naming.named_from is not None
    place = [each.name for each in own.candidates].index(name)
    weights = HypothesisWeights()
    none = weights.none / (weights.single / len(own.candidates))
    change = own.candidates[place].shapes[0].change
    print("seed", SEED)
    noise = own.covariance.sample(np.random.default_rng(SEED), DRAWS)
    shares = []
    for factor in (0.6, 1.4):
        hidden = factor * naming.named_from * change
        named = [
            synthetic.exact_posterior(hidden + noise[:, k], own.candidates, own.covariance, none)[
                1 + place
            ]
            > CLAIM
            for k in range(DRAWS)
        ]
        shares.append(np.mean(named))
    print(naming, shares)
    assert shares[0] < 0.3
    assert shares[1] > 0.7


def test_twins_are_named_together_long_before_they_are_told_apart() -> None:
    found = by_name(namings(readings()))
    friction, contact = found["plate_friction"], found["no_self_contact"]
    assert "no_self_contact" in friction.confused_with
    assert "plate_friction" in contact.confused_with
    assert friction.class_from is not None
    assert friction.named_from is None or friction.named_from > 2 * friction.class_from
    assert friction.class_share > friction.share


def test_what_is_read_again_tells_more() -> None:
    """Twice the readings: at most √2 times the strength, more where a nuisance is shared."""
    own = readings()
    twice = joined(own, own)
    assert len(twice.index) == 2 * len(own.index)
    assert set(twice.nuisances) == {"modulus", "plate_gap", "plate_gap of the addition"}
    before, after = by_name(namings(own)), by_name(namings(twice))
    for name, each in before.items():
        assert 1.0 < after[name].strength_sigma / each.strength_sigma < 1.42
    assert share(list(after.values())) > share(list(before.values()))
    # what the addition does not feel is no weaker for it
    blind = joined(own, replace(own, candidates=()))
    for name, each in by_name(namings(blind)).items():
        assert each.strength_sigma > 0.99 * before[name].strength_sigma
