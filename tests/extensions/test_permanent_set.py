"""Permanent set: an elastic, perfectly plastic element in parallel with a spring."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI
from support import bars

from dolfingrip import config
from dolfingrip.experiments.rigs.bar_rig import CouponModel, build
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.sections.tables import assignments

SEED = 17
MU = config.Config().material.mu_MPa
G, YIELD = 0.3, 0.04


def on(g: float = G, yield_strain: float = YIELD) -> tuple[str, ...]:
    return (
        f"extensions.permanent_set.g={g}",
        f"extensions.permanent_set.yield_strain={yield_strain}",
    )


def test_small_strain_is_a_jenkin_element() -> None:
    """σ = 3μ ε + 3gμ (ε − ε_p), |ε − ε_p| ≤ ε_y; the rest is of the order of the strains, 1e-4."""
    strain_y = 1e-4
    strains = strain_y * np.array([0, 0.5, 1, 2, 3, 2, 1, 0.5, 0, -2, 0, 3])
    plastic, expected = 0.0, []
    for strain in strains:
        plastic += strain - plastic - np.clip(strain - plastic, -strain_y, strain_y)
        expected.append(3 * MU * (strain + G * (strain - plastic)))
    result = bars.pull(
        *bars.INCOMPRESSIBLE,
        *on(yield_strain=strain_y),
        *bars.protocol(np.arange(strains.size), 33 * strains),
    )
    found = result.column("nominal_stress_MPa")
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-3 * np.max(expected))
    # at rest again it pulls back by the stress at which it yields
    assert found[8] == pytest.approx(-3 * MU * G * strain_y, rel=1e-3)


def test_what_yields_pulls_with_the_same_force_at_any_stretch() -> None:
    """Kirchhoff stress P λ of a growing stretch: 3 gμ ε_y and the elastic part's.

    Up to the order of ε_y and of the load step in strain, both 0.01.
    """
    strain_y = 0.01
    travel = 33 * np.linspace(0, 0.6, 61)
    result = bars.pull(
        *bars.INCOMPRESSIBLE,
        *on(yield_strain=strain_y),
        *bars.protocol(np.arange(travel.size), travel),
    )
    stretch, found = bars.stress(result)
    more = (found - MU * (stretch - stretch**-2)) * stretch
    np.testing.assert_allclose(more[20:], 3 * MU * G * strain_y, rtol=0.05)


def test_dissipation_is_never_negative() -> None:
    """q with the old A is never below q with the new one, at any time of an irregular protocol."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    settings = config.load(None, assignments(on()))
    bar = build(settings, MPI.COMM_SELF)
    path = LoadPath(Newton(bar.model, settings.solver), {"displacement_mm": 100.0})
    before = bar.history.values()["permanent_set.A"].reshape(-1, 3, 3)
    found = []
    for time_s, travel in enumerate(rng.uniform(-5, 12, 20)):
        arrival = path.advance({"displacement_mm": travel, "time_s": float(time_s)})
        assert arrival.steps == 1
        after = bar.history.values()["permanent_set.A"].reshape(-1, 3, 3)
        c = right_cauchy_green(bar)
        found.append((network(before, c) - network(after, c)).min())
        before = after
    assert min(found) > -1e-12
    assert max(found) > 1e-4


def right_cauchy_green(bar: CouponModel) -> np.ndarray:
    """Isochoric C (3, 3) of the evenly stretched bar."""
    nodes = bar.model.u.function_space.tabulate_dof_coordinates()
    moved = bar.model.u.x.array.reshape(-1, 3)
    slopes = np.linalg.lstsq(np.c_[nodes, np.ones(len(nodes))], moved)[0][:3]
    f = np.eye(3) + slopes.T
    c = f.T @ f
    return np.asarray(np.linalg.det(c) ** (-1 / 3) * c)


def network(a: np.ndarray, c: np.ndarray) -> np.ndarray:
    """q of each A."""
    return np.asarray(np.einsum("pij,ij->p", a, c) - np.log(np.linalg.det(a)) - 3)
