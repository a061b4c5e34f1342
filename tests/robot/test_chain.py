"""The chain's derivatives and equilibria, and a fit to runs of a chain that is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dolfingrip.robot.chain import Chain, Plates, equilibrium, stiffnesses
from dolfingrip.robot.fit import POLICY, Sideways, coordinates, fit, sideways_softness
from dolfingrip.robot.runs import FingerRun
from dolfingrip.sections.errors import ConfigError

SEED = 5
LENGTH, PRESSURES = 80.0, np.linspace(0.0, 200.0, 11)
KNOWN = Chain(np.stack([np.full(6, 1.5), np.linspace(10.0, 70.0, 6)], axis=1))
LAWS = np.tile([[0.02, 0.0, -60.0, 1e-4], [0.5, -0.8, -400.0, 1e-3]], (6, 1))
STIFF = Sideways((1.0, 3000.0), (2.0, 1000.0))
BACK = np.stack([np.zeros(90), np.linspace(0.0, LENGTH, 90)], axis=1)


def coordinates_at_random(states: int) -> np.ndarray:
    print(f"seed {SEED}")
    return np.random.default_rng(SEED).normal(0, 0.2, (states, KNOWN.size))


def invented(gap_mm: float | None) -> FingerRun:
    """A run that the known chain would give."""
    tip, pressing = np.array([[7.0, LENGTH]]), np.array([[0.0, LENGTH], [0.0, LENGTH - 10]])
    place = -np.inf if gap_mm is None else -gap_mm
    plates = Plates(np.full(11, place), KNOWN.fixed(pressing), POLICY.plate_N_per_mm)
    found = equilibrium(KNOWN, LAWS, PRESSURES, plates, np.zeros((11, KNOWN.size)))
    along = KNOWN.slopes(found.w, KNOWN.fixed(tip))[:, 0, :, 0]
    soft = (along**2 / stiffnesses(LAWS, PRESSURES)).sum(axis=1)
    side = sideways_softness(KNOWN, found.w, KNOWN.fixed(tip), STIFF, PRESSURES)
    free = gap_mm is None
    return FingerRun(
        gap_mm=gap_mm,
        pressure_kPa=PRESSURES,
        angle_rad=found.w[:, KNOWN.hinges].sum(axis=1),
        force_N=found.forces_N,
        stiffness_x=1 / soft if free else np.full(11, np.nan),
        stiffness_y=1 / side if free else np.full(11, np.nan),
        back_rest_mm=BACK,
        back_mm=KNOWN.places(found.w, KNOWN.fixed(BACK)),
        tip_mm=tip,
        pressing_mm=pressing,
        depth_mm=16.0,
        wall_s=0.0,
        failure="",
    )


def test_derivatives() -> None:
    """First and second derivatives of places against central differences."""
    w, step = coordinates_at_random(3), 1e-5
    points = KNOWN.fixed(BACK[::10])
    slopes = KNOWN.slopes(w, points)
    for each in range(KNOWN.size):
        moved = np.eye(KNOWN.size)[each] * step
        first = (KNOWN.places(w + moved, points) - KNOWN.places(w - moved, points)) / (2 * step)
        assert np.abs(slopes[:, :, each] - first).max() < 1e-7
        second = (KNOWN.slopes(w + moved, points) - KNOWN.slopes(w - moved, points)) / (2 * step)
        assert np.abs(KNOWN.curvatures(slopes)[:, :, :, each] - second).max() < 1e-7


def test_a_free_chain_in_closed_form() -> None:
    """Each law is balanced by itself: w = −(a p + d p²)/(b p + c)."""
    run = invented(None)
    a, b, c, d = LAWS.T
    p = PRESSURES[:, None]
    exact = -(a * p + d * p * p) / (b * p + c)
    points = KNOWN.fixed(BACK)
    assert np.abs(KNOWN.places(exact, points) - run.back_mm).max() < 1e-8


def test_a_blocked_chain_is_in_balance() -> None:
    """The plate's force times its lever is what each law gives, and it never pulls."""
    run = invented(8.0)
    plates = Plates(np.full(11, -8.0), KNOWN.fixed(run.pressing_mm), POLICY.plate_N_per_mm)
    found = equilibrium(KNOWN, LAWS, PRESSURES, plates, np.zeros((11, KNOWN.size)))
    lever = KNOWN.slopes(found.w, plates.points)[..., 0]
    depth = -8.0 - KNOWN.places(found.w, plates.points)[..., 0]
    force = POLICY.plate_N_per_mm * np.maximum(depth, 0)
    p = PRESSURES[:, None]
    a, b, c, d = LAWS.T
    given = a * p + b * p * found.w + c * found.w + d * p * p
    assert np.abs(given + np.einsum("smi,sm->si", lever, force)).max() < 1e-8
    assert force.sum(axis=1) == pytest.approx(found.forces_N)
    assert found.forces_N[-1] > 1.0
    assert (np.diff(found.forces_N) >= 0).all()


def test_forces_fall_back_on_their_derivatives() -> None:
    """The stiffness at an equilibrium is the derivative of its forces."""
    run = invented(8.0)
    plates = Plates(np.full(11, -8.0), KNOWN.fixed(run.pressing_mm), POLICY.plate_N_per_mm)
    w = equilibrium(KNOWN, LAWS, PRESSURES, plates, np.zeros((11, KNOWN.size))).w
    softer = LAWS * [1.0, 1.0, 1.0 - 1e-5, 1.0]
    found = equilibrium(KNOWN, LAWS, PRESSURES, plates, w)
    other = equilibrium(KNOWN, softer, PRESSURES, plates, w)
    moved = np.linalg.solve(found.stiffness, ((softer - LAWS)[:, 2] * w)[..., None])[..., 0]
    assert np.abs(other.w - w - moved).max() < 1e-4 * np.abs(other.w - w).max()
    told = (found.pressing * moved).sum(axis=1)
    assert other.forces_N - found.forces_N == pytest.approx(told, abs=1e-7)


def test_a_fit_finds_what_the_runs_come_from() -> None:
    """A gap that was not fitted: the known chain's angle and force."""
    free, tested = invented(None), invented(8.0)
    near = coordinates(KNOWN, free)
    assert np.abs(KNOWN.places(near, KNOWN.fixed(BACK)) - free.back_mm).max() < 0.05
    found = fit([free.fitted, invented(2.0), invented(15.0)])
    assert found.chain.joints_mm[0, 0] == pytest.approx(1.5, abs=0.3)
    plates = Plates(np.full(11, -8.0), found.chain.fixed(tested.pressing_mm), 50.0)
    start = np.zeros((11, found.chain.size))
    again = equilibrium(found.chain, found.laws, PRESSURES, plates, start)
    assert np.abs(again.forces_N - tested.force_N).max() < 0.01 * tested.force_N.max()
    angle = again.w[:, found.chain.hinges].sum(axis=1)
    assert np.degrees(np.abs(angle - tested.angle_rad)).max() < 0.5


def test_a_back_that_no_chain_follows_is_refused() -> None:
    """Folds of 2 mm that open with pressure, as those of round bellows."""
    free = invented(None)
    folds = 2.0 * np.sin(1.5 * BACK[:, 1]) * free.pressure_kPa[:, None] / PRESSURES[-1]
    folded = replace(free, back_mm=free.back_mm + folds[..., None])
    with pytest.raises(ConfigError, match="a chain of 24 joints follows the free finger's back to"):
        fit([folded.fitted, invented(2.0)])


def test_a_fit_by_wrong_forces_is_seen() -> None:
    """Half the force in the blocked runs makes a chain of about half the stiffness."""
    free = invented(None)
    blocked = [invented(2.0), invented(15.0)]
    right = fit([free.fitted, *blocked])
    wrong = fit(
        [replace(free, stiffness_x=free.stiffness_x / 2).fitted]
        + [replace(run, force_N=run.force_N / 2) for run in blocked]
    )
    stiff = [np.median(each.laws[each.chain.hinges, 2]) for each in (right, wrong)]
    assert stiff[1] / stiff[0] == pytest.approx(0.5, abs=0.1)
