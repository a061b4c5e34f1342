"""A step's model: the interior-point method against SciPy's SLSQP, and limits that contradict."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from dolfingrip.design.gradient.subproblem import Floats, ObjectiveModel, Rows, best_step


def problem(seed: int, n: int, m: int, k: int, bend: float) -> tuple[ObjectiveModel, Rows, Rows]:
    """A convex model of n variables, k objectives and m limits, half of them firm."""
    print("seed", seed)
    random = np.random.default_rng(seed)
    root = random.standard_normal((n, n))
    curvature = root @ root.T / (2 * n) + 0.01 * np.eye(n)
    model = ObjectiveModel(
        -3 + 0.1 * random.standard_normal(k), random.standard_normal((k, n)), curvature
    )
    slopes, values = random.standard_normal((m, n)), 0.2 * random.random(m) - 0.15
    half = m // 2
    soft = Rows(values[:half], slopes[:half], np.full(half, bend))
    return model, soft, Rows(-np.abs(values[half:]), slopes[half:], np.zeros(m - half))


def by_slsqp(model: ObjectiveModel, soft: Rows, firm: Rows, box: float, price: float) -> float:
    """The least of objective and price of the excess, from an independent method."""
    n = len(model.curvature)

    def limits(y: Floats) -> Floats:
        step, excess, largest = y[:n], y[n], y[n + 1]
        bent = soft.values + soft.slopes @ step + soft.bend * float(step @ step) / 2
        return np.concatenate(
            [
                excess - bent,
                -firm.values - firm.slopes @ step,
                largest - model.values - model.slopes @ step,
            ]
        )

    def whole(y: Floats) -> float:
        return float(y[n + 1] + y[:n] @ model.curvature @ y[:n] / 2 + price * y[n])

    begin = np.append(np.zeros(n), [1.0, model.values.max()])
    bounds = [(-box, box)] * n + [(0, None), (None, None)]
    found = minimize(
        whole, begin, method="SLSQP", bounds=bounds, options={"maxiter": 400, "ftol": 1e-12},
        constraints=[{"type": "ineq", "fun": limits}],
    )  # fmt: skip
    assert found.status in (0, 8), found.message  # 8: rounding allows no further step
    return float(found.fun)


@pytest.mark.parametrize(
    ("n", "m", "k", "bend"), [(3, 2, 1, 0.0), (8, 12, 3, 0.5), (12, 6, 1, 1.0), (10, 0, 2, 0.0)]
)
def test_against_slsqp(n: int, m: int, k: int, bend: float) -> None:
    model, soft, firm = problem(10 * n + k, n, m, k, bend)
    penalty, box = 5.0, 0.3
    step, excess = best_step(model, soft, firm, (np.full(n, -box), np.full(n, box)), penalty)
    price = penalty * float(np.abs(model.values).max())
    assert np.abs(step).max() <= box
    assert (firm.values + firm.slopes @ step).max(initial=-1.0) < 1e-8
    bent = soft.values + soft.slopes @ step + soft.bend * float(step @ step) / 2
    assert bent.max(initial=0.0) <= excess + 1e-8
    expected = by_slsqp(model, soft, firm, box, price)
    assert model.at(step) + price * excess == pytest.approx(expected, abs=1e-6)


def test_a_variable_at_both_bounds_stays() -> None:
    model, soft, firm = problem(1, 4, 0, 1, 0.0)
    low, high = np.array([-0.2, 0.0, -0.2, -0.2]), np.array([0.2, 0.0, 0.2, 0.2])
    assert best_step(model, soft, firm, (low, high), 5.0)[0][1] == 0.0


def test_limits_that_contradict_each_other_end() -> None:
    """The step stays in its box; the caller looks whether the limits are kept."""
    model, soft, _ = problem(2, 3, 0, 1, 0.0)
    slopes = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    firm = Rows(np.array([0.1, 0.1]), slopes, np.zeros(2))
    step, _ = best_step(model, soft, firm, (np.full(3, -0.2), np.full(3, 0.2)), 5.0)
    assert np.isfinite(step).all()
    assert np.abs(step).max() <= 0.2
