"""By how much the place between simulations may be off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pandas as pd
import pytest

from dolfingrip.diagnosis.between import OFF, ROUGH, UNTRIED, surface_error
from dolfingrip.diagnosis.problem import Problem

PRESSURE_kPa = np.linspace(0, 250, 11)


@pytest.mark.parametrize(("effect", "part"), [("permanent_set", OFF), ("mullins", UNTRIED)])
def test_a_surface_is_off_where_its_change_passes_zero_too(effect: str, part: float) -> None:
    """Variances by hand: of the change, of its root mean square, and of that from one to the next.

    In one channel that changes, and one that does not: there it is not off.
    """
    one = pd.DataFrame(
        {"experiment": "bending", "channel": "angle_deg", "run": 0, "cycle": 1,
         "branch": "loading", "pressure_kPa": PRESSURE_kPa, "time_s": PRESSURE_kPa / 25,
         "displacement_mm": np.nan}
    )  # fmt: skip
    index = pd.concat([one, one.assign(channel="tip_x_mm")], ignore_index=True)
    change = np.concatenate([np.linspace(-2, 2, 11), np.zeros(11)])
    problem = cast(Problem, SimpleNamespace(index=index))
    error = surface_error(problem, effect, change)
    square = np.mean(change[:11] ** 2)
    expected = part**2 * (change[:11] ** 2 + square * (1 + ROUGH**2))
    np.testing.assert_allclose((error**2).sum(axis=1)[:11], expected, rtol=1e-4)
    np.testing.assert_allclose(error[11:], 0.0, atol=1e-12)
    covariance = error @ error.T
    assert covariance[4, 6] > 0.5 * covariance[4, 4]  # smooth
    assert covariance[0, 10] == pytest.approx(0.0, abs=0.2 * covariance[0, 0])
