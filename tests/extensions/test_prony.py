"""Viscoelasticity: relaxation, dissipation, steps taken back."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from mpi4py import MPI
from support import bars

from dolfingrip import config
from dolfingrip.config import Solver
from dolfingrip.experiments.rigs.bar_rig import build
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.sections.tables import assignments

SEED = 11
G, TAU = 0.3, 10.0
PRONY = (f"extensions.prony.g=[{G}]", f"extensions.prony.tau_s=[{TAU}]")
TWO = ("extensions.prony.g=[0.1, 0.2]", "extensions.prony.tau_s=[0.5, 20]")
HELD_S = np.geomspace(0.1, 60.0, 30)


def relaxation(travel_mm: float, *overrides: str) -> np.ndarray:
    """Stress at ``HELD_S`` after a sudden pull."""
    times, travel = [0.0, *HELD_S], [travel_mm] * (1 + len(HELD_S))
    result = bars.pull(*PRONY, *overrides, *bars.protocol(times, travel))
    return result.column("nominal_stress_MPa")


def test_relaxation_at_small_strain() -> None:
    """In uniaxial stress with an elastic bulk K, by the correspondence principle:

    E(t) = E∞ + (E₀ − E∞) exp(−t/τ'), τ' = τ (3K + μ₀)/(3K + μ∞), E = 9Kμ/(3K + μ).
    Time steps that grow by a quarter leave an error of 1e-4 in the lateral strain's part.
    """
    strain = 1e-5
    mu = config.Config().material.mu_MPa
    bulk = config.Config().material.lmbda_MPa + 2 * mu / 3
    mu_0 = mu / (1 - G)
    young, young_0 = (9 * bulk * m / (3 * bulk + m) for m in (mu, mu_0))
    tau = TAU * (3 * bulk + mu_0) / (3 * bulk + mu)
    found = relaxation(33 * strain) / strain
    assert found[0] == pytest.approx(young_0, rel=2e-4)
    expected = young + (young_0 - young) * np.exp(-HELD_S / tau)
    np.testing.assert_allclose(found[1:], expected, rtol=3e-4)


def test_relaxation_at_large_strain() -> None:
    """Of an incompressible bar at once: P(t) = P∞ (1 + g/(1 − g) exp(−t/τ)) at any stretch.

    At a stretch that does not change a step of any length is exact.
    """
    found = relaxation(33 * 0.8, *bars.INCOMPRESSIBLE)
    relaxed = (1.8 - 1.8**-2) * config.Config().material.mu_MPa
    expected = relaxed * (1 + G / (1 - G) * np.exp(-np.array([0.0, *HELD_S]) / TAU))
    np.testing.assert_allclose(found, expected, rtol=3e-4)


def test_steps_in_time_are_of_second_order() -> None:
    """A ramp over 2 τ in 4, 8, 16 and 128 steps: the error falls to a quarter."""

    def end(steps: int) -> float:
        part = np.linspace(0, 1, steps + 1)
        result = bars.pull(
            *PRONY, "coupon.step_strain=0.5", *bars.protocol(2 * TAU * part, 16.5 * part)
        )
        return float(result.column("nominal_stress_MPa")[-1])

    exact = end(128)
    errors = np.abs([end(steps) - exact for steps in (4, 8, 16)])
    assert (errors[1:] < errors[:-1] / 3.5).all()


def test_slow_and_fast_ramps_have_the_relaxed_and_the_instantaneous_modulus() -> None:
    ramp = ("coupon.max_strain=0.3", "coupon.step_strain=0.1")
    base = bars.stress(bars.pull(*ramp, *bars.INCOMPRESSIBLE))[1]
    for rate, factor in ((1e-4, 1.0), (1e5, 1 / (1 - G))):
        rated = f"coupon.rate_mm_per_s={rate}"
        found = bars.stress(bars.pull(*ramp, *bars.INCOMPRESSIBLE, *PRONY, rated))[1]
        np.testing.assert_allclose(found, factor * base, rtol=1e-3, atol=1e-9)


def test_dissipation_is_never_negative() -> None:
    """At all times of an irregular protocol, and in sum over a closed cycle."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    settings = config.load(None, assignments(TWO))
    bar = build(settings, MPI.COMM_SELF)
    path = LoadPath(Newton(bar.model, settings.solver), {"displacement_mm": 3.0})
    found = []
    for time_s in np.cumsum(rng.exponential(2.0, 25)):
        travel = rng.uniform(-5, 15)
        arrival = path.advance({"displacement_mm": travel, "time_s": float(time_s)})
        assert arrival.failure is None
        values = {k: v.reshape(-1, 3, 3) for k, v in bar.history.values().items()}
        c = np.linalg.inv(values["prony.C_inverse"])
        for tau, a in zip(settings.extensions.prony.tau_s, ("prony.A1", "prony.A2"), strict=True):
            x = c @ values[a]
            trace = np.trace(x + np.linalg.inv(x), axis1=1, axis2=2)
            found.append((trace - 6).min() / tau)
    assert min(found) > -1e-12
    assert max(found) > 1e-3


def test_a_cycle_takes_work() -> None:
    """The loop between loading and unloading is passed through clockwise."""
    cycle = bars.pull(*TWO, "experiment.cycles=3", "coupon.max_strain=0.2")
    force, travel = cycle.column("force_N"), cycle.column("displacement_mm")
    number = cycle.column("cycle")
    work = [np.trapezoid(force[number == n], travel[number == n]) for n in (2, 3)]
    assert min(work) > 0.005 * force.max() * travel.max()


def test_a_step_taken_back_leaves_no_trace() -> None:
    """A rejected step halves the next: the same as having asked for the halves.

    Solves leave less than the states may differ by: factors of a step taken back serve later ones.
    """
    settings = config.load(None, assignments((*TWO, "solver.rtol=1e-12", "solver.atol_N=1e-12")))
    ends = []
    for answers, parts in ((["not so far"], [1.0]), ([], [0.5, 1.0])):
        bar = build(settings, MPI.COMM_SELF)
        newton = Newton(bar.model, settings.solver)
        reasons = iter(answers)
        path = LoadPath(newton, {"displacement_mm": 4.0}, partial(next, reasons, ""))
        arrivals = [path.advance({"displacement_mm": 4 * k, "time_s": 6 * k}) for k in parts]
        assert next(reasons, "") == "", "the rejection was not asked for"
        assert sum(arrival.steps for arrival in arrivals) == 2
        ends.append(bar.model.state())
    first, second = ends
    assert first.controls == second.controls
    assert set(first.history) == {"crosshead_mm", "prony.A1", "prony.A2", "prony.C_inverse"}
    for name, values in first.history.items():
        np.testing.assert_allclose(values, second.history[name], atol=1e-12)
    np.testing.assert_allclose(first.displacement, second.displacement, atol=1e-10)


def test_a_restored_state_goes_the_same_way_again() -> None:
    settings = config.load(None, assignments(TWO))
    bar = build(settings, MPI.COMM_SELF)
    path = LoadPath(Newton(bar.model, Solver(rtol=1e-12)), {"displacement_mm": 5.0})
    path.advance({"displacement_mm": 5.0, "time_s": 1.0})
    kept = bar.model.state()
    forces = []
    for _ in range(2):
        path.advance({"displacement_mm": 1.0, "time_s": 3.0})
        forces.append(bar.force().value())
        bar.model.restore(kept)
    assert forces[0] == pytest.approx(forces[1], rel=1e-10)
