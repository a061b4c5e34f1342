"""Which causes are simulated further, by invented changes; no simulation."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.diagnosis.core.emulator import Scaled, SimulatedChanges
from dolfingrip.diagnosis.core.evidence import InferenceProblem
from dolfingrip.diagnosis.core.unknown import factor_of_moduli
from dolfingrip.diagnosis.finger.training import columns_of, worth_simulating
from dolfingrip.diagnosis.policy import POLICY

SEED = 23
X = np.linspace(0.05, 1.0, 40)
NOISE = 0.02
BASE = 10 * X**1.3
CHANGES = {
    "softening": X**3,
    "stiffening": -(X**2.7),
    "offset": np.ones(len(X)),
    "waver": np.sin(9 * X),
    "kink": np.maximum(X - 0.6, 0.0),
}


def read(**strengths: float) -> InferenceProblem:
    """Readings of a model 10 % too stiff, with causes of so many standard deviations of noise."""
    rng = np.random.default_rng(SEED)
    value = 0.9 * BASE + NOISE * rng.standard_normal(len(X))
    for name, sigma in strengths.items():
        value = value + sigma * NOISE * CHANGES[name] / np.linalg.norm(CHANGES[name])
    n, factor = len(X), factor_of_moduli(0.2, -4.0, 4.0)
    kernel = np.diag((0.1 * BASE) ** 2)
    return InferenceProblem(
        value, BASE, (factor,), {}, np.eye(n) * NOISE**2, kernel, {},
        Scaled.alone(BASE, np.ones(n, bool), factor),
    )  # fmt: skip


def columns() -> dict[str, np.ndarray]:
    return {name: each[:, None] for name, each in CHANGES.items()}


@pytest.mark.parametrize("hidden", [{}, {"waver": 40.0}])
def test_what_can_be_seen_is_simulated(hidden: dict[str, float]) -> None:
    print("seed", SEED)
    assert worth_simulating(read(**hidden), columns(), set()) == set(hidden)


def test_a_weak_cause_beside_a_strong_one_is_simulated() -> None:
    readings = read(waver=40.0, offset=12.0)
    assert worth_simulating(readings, columns(), set()) == {"waver"}
    assert "offset" in worth_simulating(readings, columns(), {"waver"})


def test_what_a_first_simulation_tells_well_enough_needs_no_further_one() -> None:
    """The cause can be seen, but what its first simulation may miss changes no odds."""
    readings = read(waver=40.0, offset=8.0)
    known = np.column_stack([BASE, CHANGES["waver"]])
    both = np.column_stack([known, CHANGES["offset"]])
    missed = [
        readings.value - each @ np.linalg.lstsq(each, readings.value, rcond=None)[0]
        for each in (known, both)
    ]
    less, least = (float(np.square(each / NOISE).sum()) for each in missed)
    assert less - least > POLICY.visible_sigma**2 + 1
    assert "offset" not in worth_simulating(readings, columns(), {"waver"})


def test_what_a_finished_cause_explains_needs_no_other() -> None:
    """Others explain no more of what is left than chance may."""
    assert worth_simulating(read(waver=40.0), columns(), {"waver"}) == set()


def test_causes_that_look_alike_are_both_simulated() -> None:
    """They differ by less than what a first simulation may miss of either."""
    found = worth_simulating(read(softening=60.0), columns(), set())
    assert {"softening", "stiffening"} <= found
    assert "waver" not in found


def test_columns_are_changes_and_their_derivatives() -> None:
    """At the middle one of three moduli; a derivative that is not known has no column."""
    values = np.stack([np.stack([CHANGES["kink"]]) * by for by in (0.5, 1.0, 2.0)])
    slopes = np.full((3, 1, 2, len(X)), np.nan)
    slopes[:, 0, 0] = CHANGES["waver"]
    told = SimulatedChanges(np.zeros((1, 2)), values, slopes, np.array([-1.0, 0.0, 1.0]))
    found = columns_of(told, np.full(len(X), NOISE))
    assert found.shape == (len(X), 2)
    both = np.column_stack([CHANGES["kink"], CHANGES["waver"]])
    left = both - found @ np.linalg.lstsq(found, both, rcond=None)[0]
    assert np.abs(left).max() < 1e-12
