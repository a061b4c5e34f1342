"""Friction on the plate, in cycles of a short finger that presses against it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support import small, taylor, trial
from support.paths import by_pressure

from dolfingrip.experiments import Result, run
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.extensions.bellows_friction import BellowsFriction
from dolfingrip.extensions.plate_friction import PlateFriction
from dolfingrip.mechanics.contact.friction import SLIP_MM, Friction
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath

APART = ("contact.self_contact=false", "experiment.max_pressure_kPa=50")
READINGS = ("force_N", "angle_deg", "cavity_volume_mm3")


@cache
def blocked(mu: float | None, step_kPa: float, cycles: int = 1, *overrides: str) -> Result:
    on = {} if mu is None else {PlateFriction: {"mu": mu}}
    found = run(
        "blocked_force",
        trial.configured(
            on,
            *APART,
            f"experiment.step_kPa={step_kPa}",
            f"experiment.cycles={cycles}",
            "experiment.unload=true",
            *overrides,
        ),
        comm=trial.SELF,
    )
    assert found.failure is None
    assert found.column("load_steps").max() == 1
    return found


def pressing(*overrides: str) -> tuple[FingerModel, Friction, LoadPath]:
    """A finger with friction on its plate, its friction, and a path."""
    settings = trial.configured({PlateFriction: {}}, *APART, *overrides)
    finger = small.model(settings, plate=True)
    (friction,) = (term for term in finger.model.terms if isinstance(term, Friction))
    return finger, friction, by_pressure(Newton(finger.model, settings.solver))


def test_both_frictions_are_of_one_law() -> None:
    finger = small.model(trial.configured({PlateFriction: {}, BellowsFriction: {}}), plate=True)
    found = [term for term in finger.model.terms if isinstance(term, Friction)]
    assert [term.slip_mm for term in found] == [SLIP_MM, SLIP_MM]
    coefficient = {id(term.contact): term.coefficient for term in found}
    own = finger.parameters
    assert coefficient[id(finger.plate)] is own["extensions.plate_friction.mu"]
    assert coefficient[id(finger.contact)] is own["extensions.bellows_friction.coefficient"]


def test_without_a_coefficient_it_is_the_base_model() -> None:
    base, found = (blocked(mu, 10.0, 1, *trial.STRICT) for mu in (None, 0.0))
    for name in READINGS:
        scale = np.abs(base.column(name)).max()
        np.testing.assert_allclose(found.column(name), base.column(name), atol=1e-9 * scale)


def test_two_cycles_close_their_loop() -> None:
    """The second cycle is the first; between loading and unloading there is a loop."""
    found, smooth = (blocked(mu, 10.0, 2) for mu in (0.6, None))
    force = found.column("force_N")
    top = int(np.argmax(found.column("pressure_kPa")))
    for name in READINGS:
        values = found.column(name)
        scale = np.ptp(values)
        np.testing.assert_allclose(
            values[2 * top :], values[: 2 * top + 1], atol=1e-5 * scale, rtol=0
        )
    loading, unloading = force[: top + 1], force[top : 2 * top + 1][::-1]
    assert (loading[1:-1] > smooth.column("force_N")[1:top]).all()
    assert (loading - unloading)[1:-1].min() > 0.01 * force.max()


def test_it_takes_few_iterations() -> None:
    """Normal forces follow Newton's steps: no more than a half beyond those of hardly any friction.

    51 and 34 in 20 steps; 80 where normal forces are held in each step, and taken anew after it.
    A finger without friction would return through the states that it had, in no iteration.
    """
    rough, smooth = (blocked(mu, 10.0, 2).facts.newton.iterations for mu in (0.6, 1e-9))
    print("iterations", rough, "of hardly any friction", smooth)
    assert rough <= 52
    assert rough <= 1.55 * smooth


def test_half_the_step_leads_to_the_same() -> None:
    coarse, fine = (blocked(0.6, step) for step in (10.0, 5.0))
    for name in READINGS:
        scale = np.ptp(coarse.column(name))
        np.testing.assert_allclose(
            fine.column(name)[::2], coarse.column(name), rtol=0, atol=1e-3 * scale
        )


def test_the_first_touch_rubs() -> None:
    """A plate at a distance, reached in the only step: as where it is reached in many."""
    forces = []
    for steps in (1, 8):
        finger, friction, path = pressing("plate.gap_mm=0.05", "solver.max_step_kPa=50")
        assert not friction.forces_N(finger.model.u.x.array).any()
        for pressure in np.linspace(0, 50, steps + 1)[1:]:
            arrival = path.advance({"pressure_kPa": pressure})
            assert arrival.failure is None
            assert arrival.steps == 1
        along = friction.forces_N(finger.model.u.x.array).sum(axis=0)
        limit = 0.6 * finger.plate.force_N() / finger.model.domain.copies
        assert np.linalg.norm(along[[0, 2]]) > 0.5 * limit
        forces.append(finger.plate.force_N())
    assert forces[0] == pytest.approx(forces[1], rel=0.01)


def test_a_finger_at_rest_stays() -> None:
    """Moved to and fro on its plate, then held for a minute in steps of any length."""
    finger, _, path = pressing("solver.rtol=1e-9")
    for pressure in (10.0, 20.0, 35.0, 30.0):
        assert path.advance({"pressure_kPa": pressure}).failure is None
    start, force = finger.model.u.x.array.copy(), finger.plate.force_N()
    for time_s in np.cumsum([0.01, 0.3, 2, 10, 0.1, 1e-3, 30, 15, 1, 1.6]):
        assert path.advance({"time_s": float(time_s)}).failure is None
    assert np.abs(finger.model.u.x.array - start).max() < 1e-9
    assert finger.plate.force_N() == pytest.approx(force, rel=1e-9)


def test_derivatives() -> None:
    """Value to gradient to Hessian on the plate, after a step on it; and by μ."""
    finger, friction, path = pressing()
    for pressure in (10.0, 20.0, 15.0):
        assert path.advance({"pressure_kPa": pressure}).failure is None
    start = finger.model.u.x.array.copy()
    print("seed", trial.SEED)
    rng = np.random.default_rng(trial.SEED)
    start += 0.1 * SLIP_MM * rng.uniform(-1, 1, start.shape)
    along = rng.uniform(-1, 1, start.shape)
    nodes = friction.contact.touching.at_nodes(along)
    slope = float(np.vdot(friction.forces_N(start), nodes))
    longest = 0.02 * SLIP_MM
    assert taylor.rates(lambda e: friction.value(start + e * along), slope, longest).min() > 1.9
    slopes = (friction.hessian(start) @ nodes.ravel()).reshape(-1, 3)
    found = taylor.rates(lambda e: friction.forces_N(start + e * along), slopes, longest)
    assert found.min() > 1.9


def test_forces_follow_a_step() -> None:
    """H w + C(w) to forces with normal forces taken anew; C' to C, also in the middle of a step."""
    finger, friction, path = pressing()
    for pressure in (10.0, 20.0, 15.0):
        assert path.advance({"pressure_kPa": pressure}).failure is None
    print("seed", trial.SEED)
    rng = np.random.default_rng(trial.SEED)
    start = finger.model.u.x.array.copy()
    start += 0.02 * SLIP_MM * rng.uniform(-1, 1, start.shape)
    along = rng.uniform(-1, 1, start.shape)
    assert friction.update_lagged(start)
    correction = friction.lagged_correction(start)
    assert correction is not None
    nodes = friction.contact.touching.at_nodes(along)
    held = (friction.hessian(start) @ nodes.ravel()).reshape(-1, 3)

    def change(dofs: np.ndarray) -> np.ndarray:
        found = Gradient(finger.model.unknowns)
        correction.add_change(dofs - start, found)
        return found.array

    def rate() -> np.ndarray:
        found = Gradient(finger.model.unknowns)
        correction.add_rate(along, found)
        return found.array

    def anew(e: float) -> np.ndarray:
        friction.update_lagged(start + e * along)
        return friction.forces_N(start + e * along)

    longest = 0.002 * SLIP_MM
    assert not change(start).any()
    more = friction.contact.touching.at_nodes(rate())
    assert np.abs(more).max() > 0.01 * np.abs(held).max()
    assert taylor.rates(anew, held + more, longest).min() > 1.9
    for place in (start, start + 0.1 * longest * rng.uniform(-1, 1, start.shape)):
        correction.linearise(place - start, convex=False)
        found = taylor.rates(lambda e, at=place: change(at + e * along), rate(), longest)
        assert found.min() > 1.9


def test_a_restored_finger_goes_on_alike() -> None:
    finger, _, path = pressing(*trial.STRICT)
    for pressure in (10.0, 20.0, 30.0, 25.0):
        assert path.advance({"pressure_kPa": pressure}).failure is None
    good = finger.model.state()
    found = []
    for _ in range(2):
        finger.model.restore(good)
        finger.model.prescribe({"pressure_kPa": 20.0})
        assert path.newton.solve().converged
        finger.model.accept_step()
        found.append(finger.model.u.x.array.copy())
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-12)
