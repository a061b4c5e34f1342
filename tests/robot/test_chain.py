"""The chain's derivatives and equilibria, and a fit to runs of a chain that is known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.small import short

from dolfingrip.files.robot import Accuracy
from dolfingrip.robot import build
from dolfingrip.robot.chain import Chain, Loads, Plates, equilibrium, stiffnesses
from dolfingrip.robot.fit import (
    MOST_JOINTS,
    POLICY,
    ChainPolicy,
    Fitted,
    coordinates,
    fit,
    joints,
    softness,
)
from dolfingrip.robot.runs import FingerRun, sections

SEED = 5
LENGTH, PRESSURES = 80.0, np.linspace(0.0, 200.0, 11)
KNOWN = Chain(np.stack([np.full(6, 1.5), np.zeros(6), np.linspace(10.0, 70.0, 6)], axis=1))
LAW = [[0.02, 0.0, -60.0, 1e-4], [0.002, 0.0, -20.0, 0.0], [0.5, -0.8, -400.0, 1e-3]]
LAW += [[0.0, -1.0, -3000.0, 0.0], [0.0, -2.0, -1000.0, 0.0]]
LAWS = np.tile(LAW, (6, 1))
LEVELS = np.linspace(0.0, LENGTH, 90)
TIP = np.array([[7.0, 0.0, LENGTH]])
PRESSING = np.array([[0.0, 0.0, LENGTH - 10], [0.0, 0.0, LENGTH]])


def coordinates_at_random(states: int) -> np.ndarray:
    print(f"seed {SEED}")
    return np.random.default_rng(SEED).normal(0, 0.2, (states, KNOWN.size))


@cache
def invented(gap_mm: float | None) -> FingerRun:
    """A run that the known chain would give."""
    place = -np.inf if gap_mm is None else -gap_mm
    plates = Plates(np.full(11, place), KNOWN.fixed(PRESSING), POLICY.plate_N_per_mm)
    found = equilibrium(KNOWN, LAWS, PRESSURES, plates, np.zeros((11, KNOWN.size)))
    stiff = 1 / softness(KNOWN, LAWS, found.w, KNOWN.fixed(TIP), PRESSURES)
    sections = [np.stack([np.full(90, x), 0 * LEVELS, LEVELS], axis=1) for x in (0.0, 1.0)]
    places, others = (KNOWN.places(found.w, KNOWN.fixed(each)) for each in sections)
    across = others - places
    if gap_mm is not None:
        stiff = np.full_like(stiff, np.nan)
    return FingerRun(
        gap_mm=gap_mm,
        pressure_kPa=PRESSURES,
        angle_rad=found.w[:, KNOWN.bends].sum(axis=1),
        force_N=found.forces_N,
        volume_mm3=np.zeros(11),
        stiffness_x=stiff[:, 0],
        stiffness_y=stiff[:, 1],
        levels_mm=LEVELS,
        back_mm=np.zeros(90),
        place_mm=places[..., [0, 2]],
        turn_rad=np.arctan2(across[..., 2], across[..., 0]),
        tip_mm=TIP,
        contact_mm=10.0,
        depth_mm=16.0,
        wall_s=0.0,
        failure="",
    )


@cache
def refitted() -> Fitted:
    """A fit to what the known chain would give."""
    return fit([invented(None).fitted, invented(2.0), invented(15.0)])


def test_plates_that_press_too_little_leave_the_stiffness_to_the_free_tip() -> None:
    """Without a plate's force, balance alone holds for laws of any sign and size."""
    free = invented(None)
    found = fit([free.fitted, invented(500.0)])
    assert (stiffnesses(found.laws, PRESSURES) > 0).all()
    none = Plates(np.full(11, -np.inf), found.chain.fixed(PRESSING), POLICY.plate_N_per_mm)
    start = np.zeros((11, found.chain.size))
    bent = equilibrium(found.chain, found.laws, PRESSURES, none, start).w
    angle = np.degrees(bent[:, found.chain.bends].sum(axis=1) - free.angle_rad)
    assert np.abs(angle).max() < 1.5
    soft = softness(found.chain, found.laws, bent, found.chain.fixed(TIP), PRESSURES)
    assert np.abs(1 / soft[:, 0] / free.stiffness_x - 1).max() < 0.07


def test_derivatives() -> None:
    """First and second derivatives of places against central differences."""
    w, step = coordinates_at_random(3), 1e-5
    across = np.random.default_rng(SEED).normal(0, 5.0, (9, 2))
    points = KNOWN.fixed(np.column_stack([across, LEVELS[::10]]))
    slopes = KNOWN.slopes(w, points)
    for each in range(KNOWN.size):
        moved = np.eye(KNOWN.size)[each] * step
        first = (KNOWN.places(w + moved, points) - KNOWN.places(w - moved, points)) / (2 * step)
        assert np.abs(slopes[:, :, each] - first).max() < 1e-7
        second = (KNOWN.slopes(w + moved, points) - KNOWN.slopes(w - moved, points)) / (2 * step)
        for number in range(9):
            curved = KNOWN.curvatures(w, slopes[:, number])[:, :, each]
            assert np.abs(curved - second[:, number]).max() < 1e-7


def test_a_free_chain_in_closed_form() -> None:
    """Each law is balanced by itself: w = −(a p + d p²)/(b p + c)."""
    run = invented(None)
    a, b, c, d = LAWS.T
    p = PRESSURES[:, None]
    exact = -(a * p + d * p * p) / (b * p + c)
    points = KNOWN.fixed(run.rest_line_mm(0.5))
    assert np.abs(KNOWN.places(exact, points) - run.line_mm(0.5)).max() < 1e-8


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


def test_a_chain_under_dead_loads_is_in_balance() -> None:
    """Loads times their levers are what each law gives; the stiffness is the forces' derivative."""
    p, none = PRESSURES[[4, -1]], Plates(np.full(2, -np.inf), KNOWN.fixed(PRESSING), 50.0)
    a, b, c, d = LAWS.T
    start = np.zeros((2, KNOWN.size))
    points = KNOWN.fixed(np.array([[4.0, 1.0, 40.0], TIP[0]]))
    forces = np.array([[0.1, -0.05, 0.2], [-0.02, 0.03, 0.1]])
    found = equilibrium(KNOWN, LAWS, p, none, start, Loads(points, forces))
    given = a * p[:, None] + b * p[:, None] * found.w + c * found.w + d * p[:, None] ** 2
    borne = np.einsum("smik,mk->si", KNOWN.slopes(found.w, points), forces)
    assert np.abs(given + borne).max() < 1e-8
    assert np.abs(borne).max() > 1.0
    more = equilibrium(KNOWN, LAWS, p, none, found.w, Loads(points, forces * (1 + 1e-5)))
    moved = np.linalg.solve(found.stiffness, 1e-5 * borne[..., None])[..., 0]
    assert np.abs(more.w - found.w - moved).max() < 1e-4 * np.abs(moved).max()


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
    near, line = coordinates(KNOWN, free), KNOWN.fixed(free.rest_line_mm(1.5))
    assert np.abs(KNOWN.places(near, line) - free.line_mm(1.5)).max() < 0.05
    found = refitted()
    line_mm = free.line_mm(found.chain.joints_mm[0, 0])
    lengths = np.linalg.norm(np.diff(line_mm, axis=1), axis=2).sum(axis=1)
    assert lengths == pytest.approx(LENGTH, rel=2.5e-3)  # at x = 1.5 it grows by 1 %
    plates = Plates(np.full(11, -8.0), found.chain.fixed(tested.pressing_mm), 50.0)
    start = np.zeros((11, found.chain.size))
    again = equilibrium(found.chain, found.laws, PRESSURES, plates, start)
    assert np.abs(again.forces_N - tested.force_N).max() < 0.01 * tested.force_N.max()
    angle = again.w[:, found.chain.bends].sum(axis=1)
    assert np.degrees(np.abs(angle - tested.angle_rad)).max() < 0.5
    nowhere = replace(plates, x_mm=np.full(11, -np.inf))
    w = equilibrium(found.chain, found.laws, PRESSURES, nowhere, start).w
    soft = softness(found.chain, found.laws, w, found.chain.fixed(TIP), PRESSURES)
    assert soft[:, 0] * free.stiffness_x == pytest.approx(1.0, abs=0.03)
    assert soft[:, 1] * free.stiffness_y == pytest.approx(1.0, abs=0.03)


def test_folds_that_no_chain_follows_need_no_more_joints() -> None:
    """Folds of 2 mm that open with pressure, which no chain follows."""
    free = invented(None)
    folds = 2.0 * np.sin(1.5 * LEVELS) * free.pressure_kPa[:, None] / PRESSURES[-1]
    folded = replace(free, place_mm=free.place_mm + folds[..., None])
    (plain, near), (chain, error) = joints([free.fitted]), joints([folded.fitted])
    assert len(chain.joints_mm) <= len(plain.joints_mm)
    assert chain.joints_mm[0, 0] == pytest.approx(plain.joints_mm[0, 0], abs=0.5)
    assert near < POLICY.shape_error * LENGTH
    best = np.sqrt(2 * (folds[::2] ** 2).mean())
    assert 0.9 * best < error < 1.05 * POLICY.near_best * best


@pytest.mark.slow
def test_the_fewest_joints_within_a_stated_error() -> None:
    """States that were not fitted decide: with one joint less the error is larger."""
    config = short("finger.length_mm=80")
    runs = [invented(gap_mm) for gap_mm in (2.0, 15.0, 8.0)]
    known = build.Simulated(config, invented(None), runs)
    tried: list[float] = []

    def told(number: int, most: int, note: str) -> None:
        assert (number, most) == (len(tried) + 1, MOST_JOINTS)
        tried.append(float(note.split()[0]))

    stated = Accuracy(angle_deg=1.5)
    built = build.build(known, stated, told)
    file = built.robot.file
    assert len(file.joints) == built.tried == len(tried) > 1
    assert file.excess <= 1 < min(tried[:-1])
    wrong = [each.error for each in file.comparisons if each.quantity == "angle"]
    assert max(wrong) == pytest.approx(1.5 * file.excess)
    assert {len(each.pressure_kPa) for each in file.comparisons} == {5, 11}


def test_laws_without_an_equilibrium_lead_nowhere() -> None:
    """A slide that gives way the more it is pushed: finite after all iterations."""
    run, soft = invented(None), LAWS.copy()
    soft[0, 2] = 400.0
    plates = Plates(np.full(1, -np.inf), KNOWN.fixed(run.pressing_mm), 50.0)
    found = equilibrium(KNOWN, soft, PRESSURES[-1:], plates, np.zeros((1, KNOWN.size)))
    assert np.isfinite(found.w).all()
    assert np.isfinite(found.stiffness).all()


def test_sections_of_folded_bellows_move_as_their_back() -> None:
    """Round folds that swell by a tenth while the axis x = 3 bends to an arc of a quarter turn.

    The axis keeps its length, and the crests at x = −3 move out by 11 mm times the swelling.
    """
    random = np.random.default_rng(SEED)
    z, around = random.uniform(0, LENGTH, 40_000), random.uniform(0, 2 * np.pi, 40_000)
    z[:50], z[50:100] = 0.0, LENGTH
    radius = 8 + 3 * np.cos(2 * np.pi * z / 8)

    def placed(swelling: float, turn: float) -> np.ndarray:
        x = 8 + swelling * radius * np.cos(around) - 3
        angle, reach = turn * z / LENGTH, LENGTH / turn
        bent = 3 - reach * (1 - np.cos(angle)) + x * np.cos(angle)
        y = swelling * radius * np.sin(around)
        return np.stack([bent, y, reach * np.sin(angle) + x * np.sin(angle)], axis=1)

    states = [(1.0, 1e-9), (1.05, 0.6), (1.1, np.pi / 2)]
    found = sections(placed(*states[0]), np.array([placed(*each) for each in states]))
    levels = np.array(found["levels_mm"])
    for (swelling, turn), turned, place in zip(
        states, found["turn_rad"], found["place_mm"], strict=True
    ):
        angle = turn * levels / LENGTH
        assert np.abs(np.array(turned) - angle).max() < np.radians(1.0)
        exact = np.stack([np.cos(angle) - 1, np.sin(angle)], axis=1) * LENGTH / turn
        exact += [3, 0] + (5 - 11 * swelling) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        normal = np.stack([np.cos(turned), np.sin(turned)], axis=1)
        assert np.linalg.norm(np.array(place) - 3 * normal - exact, axis=1).max() < 0.25
        axis = np.array(place) + (3 + 11 * (swelling - 1)) * normal
        assert np.linalg.norm(np.diff(axis, axis=0), axis=1).sum() == pytest.approx(
            LENGTH, rel=2e-3
        )
    assert min(found["back_mm"]) == pytest.approx(8 - 11, abs=0.1)


def test_a_fit_by_wrong_forces_is_seen() -> None:
    """Half the force in the blocked runs makes a chain of about half the stiffness."""
    free = invented(None)
    blocked = [invented(2.0), invented(15.0)]
    wrong = fit(
        [replace(free, stiffness_x=free.stiffness_x / 2).fitted]
        + [replace(run, force_N=run.force_N / 2) for run in blocked]
    )
    stiff = [np.median(each.laws[each.chain.bends, 2]) for each in (refitted(), wrong)]
    assert stiff[1] / stiff[0] == pytest.approx(0.5, abs=0.1)


def test_a_stiffness_that_is_missed_weighs_more() -> None:
    """Stiffnesses a fifth above what the forces say: nearer to them by the second fit."""
    free = invented(None)
    runs = [replace(free, stiffness_x=1.2 * free.stiffness_x).fitted, invented(2.0)]

    def missed(policy: ChainPolicy) -> float:
        found = fit(runs, policy)
        fitted = runs[0]
        p = fitted.pressure_kPa
        plates = Plates(np.full(len(p), -np.inf), found.chain.fixed(fitted.pressing_mm), 50.0)
        w = equilibrium(found.chain, found.laws, p, plates, np.zeros((len(p), found.chain.size))).w
        soft = softness(found.chain, found.laws, w, found.chain.fixed(TIP), p)[:, 0]
        return float(np.abs(1 / (soft * fitted.stiffness_x) - 1).max())

    few = replace(POLICY, shape_error=0.1)  # joints
    once = missed(replace(few, stiffness_limit=np.inf))
    assert once > POLICY.stiffness_limit
    assert missed(few) < 0.8 * once
