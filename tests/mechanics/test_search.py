"""The search along a Newton step: down to where the forces do no more work, either way."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.globalisation import Globalisation, IterationVerdict
from dolfingrip.mechanics.newton.policy import StepPolicy

POLICY = StepPolicy()


class Line:
    """One unknown x in the wells of Π = (x² − 1)² / 4, of force x³ − x."""

    singular_at_rest = False
    crowded: frozenset[str] = frozenset()

    def __init__(self, x: float, longest: float = 1.0) -> None:
        self.x = np.array([x])
        self._longest = longest
        self.unknowns = SimpleNamespace(local=self.x.copy, set_local=self._set)

    def _set(self, values: np.ndarray) -> None:
        self.x[:] = values

    def admissible_step(self, step: np.ndarray) -> tuple[float, str]:
        return self._longest, "" if self._longest == 1 else "contact"

    def work(self, step: np.ndarray) -> float:
        return float((self.x**3 - self.x) @ step)


def taken(line: Line, step: float) -> tuple[float, Globalisation]:
    """Fraction of ``step`` that is taken where the residual has stagnated."""
    model: Any = line
    rules = Globalisation(model, Solver(), line.work, POLICY)
    for iteration in range(7):
        rules.judge(iteration, 1.0)
    return rules.fraction(np.array([step])), rules


@pytest.mark.parametrize("longest", [1.0, 0.9])
@pytest.mark.parametrize(("x", "step"), [(0.2, 1.4), (0.2, -1.4), (-0.1, 2.0), (1.4, -0.8)])
def test_ends_in_a_well(x: float, step: float, longest: float) -> None:
    """Also where the step crosses the maximum at 0, as towards a saddle."""
    line = Line(x, longest)
    start = line.work(np.array([step]))
    fraction, rules = taken(line, step)
    assert line.x == [x]  # nothing has moved yet
    assert np.sign(fraction) == -np.sign(start)
    line.x[:] += fraction * step
    assert abs(line.work(np.array([step]))) <= POLICY.remaining * abs(start)
    assert (line.x**2 - 1) ** 2 < (x**2 - 1) ** 2
    assert rules.bound == ("" if longest == 1 else "contact")


def test_a_whole_step_where_there_is_still_work() -> None:
    assert taken(Line(2.0), -0.3)[0] == 1.0


def test_damped_solves_search_every_step_and_allow_a_rising_residual() -> None:
    """What ends another solve, or is taken whole in it, is searched."""
    model: Any = Line(0.2)
    for damped, expected in ((False, 1.0), (True, 0.4)):
        rules = Globalisation(model, Solver(), model.work, POLICY, damped=damped)
        rules.judge(0, 1.0)
        fraction = rules.fraction(np.array([2.0]))
        assert fraction == pytest.approx(expected, abs=0.0 if expected == 1 else 0.1)
        verdicts = [rules.judge(iteration, 10.0**iteration) for iteration in range(1, 8)]
        assert (IterationVerdict.HOPELESS in verdicts) is not damped


def test_a_step_far_too_long_is_searched_by_decades() -> None:
    """A membrane's force, 1 − (x/s)³ for s = 1e-5: regula falsi alone takes thousands of values."""
    model: Any = Line(0.0)
    calls = []

    def work(step: np.ndarray) -> float:
        calls.append(model.x[0])
        return float(((model.x[0] / 1e-5) ** 3 - 1) * step[0])

    rules = Globalisation(model, Solver(), work, POLICY, damped=True)
    rules.judge(0, 1.0)
    model.x[:] = rules.fraction(np.array([1.0]))
    assert len(calls) <= 13
    assert abs(work(np.array([1.0]))) <= POLICY.remaining
