"""A leading fit is held against its simulation, on a case whose answer is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, ClassVar, cast

import numpy as np

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.core.decision import sensitivity
from dolfingrip.diagnosis.core.emulator import Emulator, Scaled, linear
from dolfingrip.diagnosis.core.evidence import InferenceProblem, MapFit
from dolfingrip.diagnosis.core.search import search
from dolfingrip.diagnosis.core.unknown import factor_of_moduli
from dolfingrip.diagnosis.finger.analysis import FingerAnalysis
from dolfingrip.jobs.run import silent

SEED = 5
N = 30
MISS = 2.0
X = np.linspace(0.1, 1.0, N)
BASE = 300.0 * X
TRUE = 10.0 * X**3
FALSE = TRUE + 0.5 * np.sin(40.0 * X)
NUMBERS = 6
"""Of the false cause: only their sum counts, so a fit can evade a place where it was corrected."""


@dataclass(frozen=True, eq=False)
class Flat(Emulator):
    """A change by the sum of some numbers."""

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slopes = np.full((len(zeta), 1, NUMBERS), NUMBERS**-0.5)
        return zeta.sum(axis=1, keepdims=True) * NUMBERS**-0.5, slopes


class Simulated(FingerAnalysis):
    """Simulations of the false cause miss the readings, wherever they are made."""

    misses: ClassVar[list[np.ndarray]] = []

    def simulated(
        self, fit: MapFit, addition: Any = None, *, derived: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        exact = self.exact(fit)
        if "false" in fit.subset:
            self.misses.append(MISS * np.random.default_rng(len(self.misses)).standard_normal(N))
            exact = exact + self.misses[-1]
        return exact, self.problem.slopes(fit.subset, fit.zeta)


class Nearly(FingerAnalysis):
    """Emulators are off by half a standard deviation of the noise."""

    count: ClassVar[int] = 0

    def simulated(
        self, fit: MapFit, addition: Any = None, *, derived: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        Nearly.count += 1
        return self.exact(fit) + 0.5 * np.cos(9 * X), self.problem.slopes(fit.subset, fit.zeta)


class Failing(FingerAnalysis):
    """No simulation reaches all readings."""

    def simulated(
        self, fit: MapFit, addition: Any = None, *, derived: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        raise ConfigError("stopped at 153 kPa")


def problem() -> InferenceProblem:
    """Readings, noise 1, that the emulator of a false cause follows better than the true one."""
    print("seed", SEED)
    noise = np.random.default_rng(SEED).standard_normal(N)
    value = BASE + 2.0 * FALSE + noise
    factor, every = factor_of_moduli(0.1, -8.0, 8.0), np.ones(N, dtype=bool)
    flat = Flat(FALSE[:, None], np.zeros((N, 0)), 0.0)
    emulators: dict[str, Emulator] = {"true": linear(TRUE), "false": flat}
    return InferenceProblem(
        value, BASE, (factor,),
        {name: Scaled.of(each, every, factor) for name, each in emulators.items()},
        np.eye(N), 1e-6 * np.eye(N),
        {"true": np.array([[-3.3, 3.3]]), "false": np.array([[-3.3, 3.3]] * NUMBERS)},
        Scaled.alone(BASE, every, factor),
    )  # fmt: skip


def test_a_cause_whose_simulations_do_not_keep_what_emulators_promise_is_not_named() -> None:
    case = problem()
    before = search(case, np.random.default_rng(0))
    assert sensitivity(before)[0].first == ("false",)
    off, unused = cast("Any", SimpleNamespace(noise=np.ones(N))), cast("Any", None)
    _, posterior, left = Simulated(case, {}, off, unused, ()).verified(before, silent)
    assert len(Simulated.misses) > 1
    decision, _ = sensitivity(posterior)
    assert (decision.answer, decision.first) == ("cause", ("true",))
    assert left < 1.0


def test_where_nothing_can_be_simulated_the_answer_is_that_of_the_screen() -> None:
    case = problem()
    before, unused = search(case, np.random.default_rng(0)), cast("Any", None)
    _, posterior, left = Failing(case, {}, unused, unused, ()).verified(before, silent)
    np.testing.assert_array_equal(posterior.probability, before.probability)
    assert np.isnan(left)


def test_a_fit_that_is_near_to_a_simulated_one_is_not_simulated() -> None:
    case = problem()
    only = {"true": case.emulators["true"]}
    case = replace(
        case, value=BASE + 2.0 * TRUE, emulators=only, boxes={"true": case.boxes["true"]}
    )
    off, unused = cast("Any", SimpleNamespace(noise=np.ones(N))), cast("Any", None)
    before = search(case, np.random.default_rng(0))
    _, posterior, left = Nearly(case, {}, off, unused, ()).verified(before, silent)
    assert sensitivity(posterior)[0].first == ("true",)
    assert Nearly.count == 1
    assert left < 0.2
