"""One model with every kind of term at once: Π, its gradient and its Hessian belong together.

A short finger against a plate on a spring, on a compliant clamp, under its weight, under
volume control, its bellows touching, friction on both. A Taylor remainder of second order shows
that a derivative is right; of first order, that it is not.
"""

from __future__ import annotations

import numpy as np
import pytest
from support import small, taylor, trial
from support.paths import by_pressure

from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.mechanics.newton.newton import Newton

SEED = 31
SETTINGS = (
    "finger.gap_mm=0.3",
    "plate.tilt_deg=10",
    "gravity.acceleration_m_s2=9.81",
    "experiment.control=volume",
    "extensions.plate_friction={}",
    "extensions.bellows_friction={}",
    "extensions.plate_compliance={}",
    "extensions.clamp_compliance={}",
)
FIRST = 1e-5
"""First step along the direction (mm): the plate's curvature jumps where a node comes to touch it,
so the steps are short against the distances of nodes from there."""


@pytest.fixture(scope="module")
def finger() -> FingerModel:
    """Pressed and touching, in the middle of a load step."""
    made = small.model(small.short(*SETTINGS), plate=True)
    path = by_pressure(Newton(made.by_pressure, made.config.solver))
    for pressure in (100.0, 150.0):
        assert path.advance({"pressure_kPa": pressure}).failure is None
    names = {term.name for term in made.model.terms}
    assert names >= {"plate", "contact", "friction", "volume"}
    contact, plate = made.contact, made.plate
    assert contact is not None
    assert plate is not None
    dofs = made.model.u.x.array
    assert np.linalg.norm(contact.gradient(dofs), axis=1).max() > 0.01  # N: bellows touch
    assert plate.force_N() > 0.1
    made.model.update_lagged()
    return made


def _direction(finger: FingerModel) -> np.ndarray:
    """An irregular change of all unknowns as an owned array, 0 where they are held."""
    print("seed", SEED)
    model = finger.model
    found = np.random.default_rng(SEED).uniform(-1, 1, model.unknowns.owned_size)
    for bc in model.supports:
        found[bc.dof_indices()[0]] = 0.0
    rows = model.unknowns.global_rows(found)
    rows[len(model.unknowns.global_unknowns) :] = 0.0  # what fills up blocks
    assert model.constraint is not None
    for unknown in model.constraint.global_unknowns:  # the clamp moves with its global unknowns
        found[model.constraint.dofs] += unknown.change(model.unknowns.to_local(found)) * trial.way(
            finger, unknown
        )
    return found


def test_gradient_is_the_derivative_of_the_energy(finger: FingerModel) -> None:
    model, along = finger.model, _direction(finger)
    start, step = model.unknowns.local(), model.unknowns.to_local(along)

    def energy(e: float) -> float:
        model.unknowns.set_local(start + e * step)
        return model.energy()

    try:
        model.unknowns.set_local(start)
        slope = float(model.gradient() @ along)
        assert slope != 0
        assert taylor.rates(energy, slope, 10 * FIRST)[:4].min() > 1.9
    finally:
        model.unknowns.set_local(start)


def test_hessian_is_the_derivative_of_the_gradient(finger: FingerModel) -> None:
    model, along = finger.model, _direction(finger)
    newton = Newton(model, finger.config.solver)
    start, step = model.unknowns.local(), model.unknowns.to_local(along)
    model.potential.carried.reset()
    newton.tangent.assemble()
    x, y = newton.tangent.matrix.createVecs()
    x.array[:] = along
    newton.tangent.matrix.mult(x, y)

    def gradient(e: float) -> np.ndarray:
        model.unknowns.set_local(start + e * step)
        return model.gradient()

    try:
        expected = np.where(along != 0, y.array, 0.0)
        assert (
            taylor.rates(lambda e: np.where(along != 0, gradient(e), 0.0), expected, FIRST)[
                :4
            ].min()
            > 1.9
        )
    finally:
        model.unknowns.set_local(start)
