"""Two causes that act on one another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.blind_coupons import diagnosed
from support.hidden_coupon import Truth


@pytest.mark.slow
def test_both_are_named_though_the_sum_of_their_changes_is_far_off(tmp_path: Path) -> None:
    """Mullins' softening of another law: a sum of both changes is off by some 20 standard
    deviations, and simulations at fits tell the rest."""
    law = {"extensions.mooney_rivlin.C01_MPa": 2.0}
    softening = {"inverse_r": 0.444, "m_MPa": 0.0707, "beta": 0.0707}
    own = {f"extensions.mullins.{name}": value for name, value in softening.items()}
    found = diagnosed("loops", Truth(causes=law | own), tmp_path)
    fit = found.posterior.best(("mooney_rivlin", "mullins"))
    analysis = found.analysis
    assert found.decision.first == ("mullins",)
    assert "mooney_rivlin" in found.decision.second
    (told,) = analysis.simulated([fit])
    assert told is not None
    problem = analysis.problem
    rest = problem.linear @ fit.zeta[problem.simulated_count : problem.nuisance_count]
    off = analysis.exact(fit) - rest - told.told[0, :, 0]
    assert np.abs(off / analysis.errors.noise).max() < 1.0
    values = analysis.overrides(fit)
    assert values["extensions.mullins.inverse_r"] == pytest.approx(0.444, rel=0.05)
    assert values["extensions.mooney_rivlin.C01_MPa"] == pytest.approx(2.0, rel=0.15)
