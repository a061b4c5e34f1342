"""Gradient and Hessian of the energies that every model has, against the energies themselves.

Those of laws and effects are tested by their index: ``experiments/test_laws.py`` and
``extensions/test_index.py``.

A Taylor remainder of second order in the step shows that a derivative is right; of first
order, that it is not. The orders approach 2 as the step vanishes, so 1.9 is asked at steps
of a tenth of an element and less. Where the plate is felt the steps are shorter: its curvature
jumps where a node comes to touch it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from support import bodies, taylor

SEED = 20240611
ENERGIES = ("neo-Hookean", "cavity pressure", "plate", "gravity", "all")
STEP = {"plate": 1e-4, "all": 1e-4}
"""First step (mm), where not 0.01."""


@pytest.fixture(params=ENERGIES)
def energy(request: pytest.FixtureRequest, hollow: bodies.Body) -> Iterator[str]:
    """Name of the only energy that is switched on, at a deformed state."""
    print("seed", SEED)
    name = str(request.param)
    on = {other: name in (other, "all") for other in ENERGIES}
    kept = [constant.value.copy() for constant in (hollow.mu, hollow.lmbda)]
    if not on["neo-Hookean"]:
        hollow.mu.value = hollow.lmbda.value = 0.0
    hollow.pressure.value = 0.3 if on["cavity pressure"] else 0.0
    hollow.body_force.x.array[:] = (
        np.tile([0.1, -0.2, 0.3], hollow.body_force.x.array.size // 3) if on["gravity"] else 0.0
    )
    rng = np.random.default_rng(SEED)
    hollow.displace(0.05 * rng.uniform(-1, 1, hollow.nodes.shape))
    if on["plate"]:
        # some of the facing nodes are felt, some are not yet
        facing = hollow.displacement()[hollow.nodes_in("facing plate"), 0]
        hollow.plate.offset.value = facing.min() - 0.4 * hollow.plate.width_mm
        gaps = facing - hollow.plate.offset.value
        assert (gaps < hollow.plate.width_mm).any()
        assert (gaps > hollow.plate.width_mm).any()
    yield name
    hollow.mu.value, hollow.lmbda.value = kept
    hollow.pressure.value = 0.0
    hollow.body_force.x.array[:] = 0.0
    hollow.plate.offset.value = -bodies.FAR
    hollow.displace(np.zeros_like(hollow.nodes))


def _direction(shape: tuple[int, ...]) -> np.ndarray:
    return np.random.default_rng(SEED + 1).uniform(-1, 1, shape)


def test_gradient(hollow: bodies.Body, energy: str) -> None:
    """dΠ·w is the derivative of Π along w."""
    start, w = hollow.displacement(), _direction(hollow.nodes.shape)

    def value(step: float) -> float:
        hollow.displace(start + step * w)
        return hollow.energy()

    slope = float(np.vdot(hollow.gradient(), w))
    assert slope != 0.0
    if energy == "gravity":  # linear in u: no remainder at all but round-off
        assert value(0.1) - value(0.0) == pytest.approx(0.1 * slope, rel=1e-12)
        return
    assert taylor.rates(value, slope, STEP.get(energy, 0.01)).min() > 1.9


def test_hessian(hollow: bodies.Body, energy: str) -> None:
    """A w is the derivative of the residual along w, once the carried stress is the present."""
    start, w = hollow.displacement(), _direction(hollow.nodes.shape)
    matrix = hollow.tangent()
    x, y = matrix.createVecs()
    x.array[:] = w.ravel()
    matrix.mult(x, y)
    slope = np.array(y.array).reshape(-1, 3)

    def gradient(step: float) -> np.ndarray:
        hollow.displace(start + step * w)
        return hollow.gradient()

    if energy == "gravity":
        assert not slope.any()
        return
    assert taylor.rates(gradient, slope, STEP.get(energy, 0.01)).min() > 1.9


def test_carried_stress_follows_to_first_order(hollow: bodies.Body) -> None:
    """The carried stress after a step w is S(u + w) up to second order in w."""
    carried = hollow.model.potential.carried
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    start = 0.05 * rng.uniform(-1, 1, hollow.nodes.shape)
    w = _direction(hollow.nodes.shape)

    def difference(step: float) -> np.ndarray:
        hollow.displace(start)
        carried.follow((step * w).ravel())
        followed = carried.of_parts[0].x.array.copy()
        hollow.displace(start + step * w)
        carried.reset()
        return np.asarray(carried.of_parts[0].x.array - followed)

    try:
        assert taylor.rates(difference, 0.0, 0.01).min() > 1.9
    finally:
        hollow.displace(np.zeros_like(start))


def test_plain_tangent_is_the_same() -> None:
    """Without the carried stress the tangent is what it is with a fresh one."""
    plain, carrying = (
        bodies.body(bodies.hollow_cube(), 1, carried=carried) for carried in (False, True)
    )
    assert not plain.model.potential.carried
    for solid in (plain, carrying):
        solid.displace(0.05 * np.random.default_rng(SEED).uniform(-1, 1, solid.nodes.shape))
    difference = plain.tangent() - carrying.tangent()
    assert difference.norm() < 1e-14 * plain.tangent().norm()
