"""Energy densities by themselves: plain numbers, no mesh and no compiler."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import ufl

from dolfingrip.forms import (
    gent,
    invariants,
    mixed_bulk_modulus,
    neo_hookean,
    ogden_terms,
    plate,
    polynomial,
    transient_network,
    yielding_network,
)
from dolfingrip.forms.evaluate import nominal_stress, number

SEED = 23
MU, LMBDA = 2.93, 26.37


def psi(strain: np.ndarray) -> float:
    """Strain energy of the Green–Lagrange strain."""
    return number(neo_hookean.energy(ufl.as_matrix(strain.tolist()), MU, LMBDA))


def random_strain(size: float) -> np.ndarray:
    """A symmetric (3, 3) strain."""
    print("seed", SEED)
    full = np.random.default_rng(SEED).uniform(-size, size, (3, 3))
    return np.asarray((full + full.T) / 2)


def slope(function: Callable[[float], float], at: float, step: float) -> float:
    """Central difference."""
    return (function(at + step) - function(at - step)) / (2 * step)


def test_no_energy_at_rest() -> None:
    """ψ(0) = 0 and it has a minimum there."""
    assert psi(np.zeros((3, 3))) == 0.0
    strain = random_strain(1e-3)
    assert psi(strain) > 0.0
    assert psi(-strain) > 0.0


def test_mixed_energy_is_stationary_where_it_is_the_same() -> None:
    """At p = λ ln J it has the value of the energy without p, and is greatest there."""
    strain = random_strain(0.2)
    best = LMBDA * np.log(np.linalg.det(2 * strain + np.eye(3))) / 2

    def mixed(p: float) -> float:
        given = ufl.as_matrix(strain.tolist())
        volumetric = mixed_bulk_modulus.energy(given, p, LMBDA)
        return number(neo_hookean.energy(given, MU, 0.0) + volumetric)

    assert mixed(best) == pytest.approx(psi(strain), rel=1e-12)
    for away in (-0.5, 0.5):
        drop = away**2 / (2 * LMBDA)
        assert mixed(best) - mixed(best + away) == pytest.approx(drop, rel=1e-9)


def test_mixed_stress_of_a_cube_whose_sides_are_held() -> None:
    """P = μ (λ − 1/λ) + p/λ: 1.5 + 3 at a stretch of 2."""

    def mixed(strain: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
        return neo_hookean.energy(strain, 1.0, 0.0) + mixed_bulk_modulus.energy(strain, 6.0, 9.0)

    assert nominal_stress(mixed, 2.0, held=True) == pytest.approx(4.5, abs=1e-9)


def test_small_strain_is_hooke() -> None:
    """ψ → μ E:E + λ/2 (tr E)² at small strain, with an error of third order.

    At strains of 1e-4 that is about 1e-4 of the energy, and round-off 1e-16/1e-8.
    """
    for size in (1e-3, 1e-4):
        strain = random_strain(size)
        hooke = MU * np.sum(strain**2) + LMBDA / 2 * np.trace(strain) ** 2
        assert psi(strain) == pytest.approx(hooke, rel=10 * size)


def test_value_in_uniaxial_strain() -> None:
    """F = diag(λ, 1, 1): ψ = μ/2 (λ² − 1 − 2 ln λ) + Λ/2 (ln λ)², by hand."""
    for stretch in (0.5, 1.2, 3.0):
        strain = np.diag([(stretch**2 - 1) / 2, 0, 0])
        log = np.log(stretch)
        expected = MU / 2 * (stretch**2 - 1 - 2 * log) + LMBDA / 2 * log**2
        assert psi(strain) == pytest.approx(expected, rel=1e-13)


def test_stress_of_a_bar_of_constant_volume() -> None:
    """P = 2 (λ − λ⁻²)(∂ψ/∂Ī₁ + ∂ψ/∂Ī₂/λ), and of Ogden's terms Σ 2μ/α (λ^(α−1) − λ^(−α/2−1)).

    Yeoh's and Mooney–Rivlin's energies at a stretch of 2, where Ī₁ − 3 = 2; Ogden's with α = 1 in
    place of neo-Hooke's at 1.5.
    """
    yeoh = nominal_stress(lambda e: polynomial.energy(e, {(2, 0): 0.5, (3, 0): 0.25}), 2.0)
    assert yeoh == pytest.approx(17.5, abs=1e-9)
    mooney = nominal_stress(lambda e: polynomial.energy(e, {(0, 1): 1.0, (1, 0): -1.0}), 2.0)
    assert mooney == pytest.approx(-1.75, abs=1e-9)
    ogden = nominal_stress(lambda e: ogden_terms.energy(e, [1.0, -1.0], [1.0, 2.0]), 1.5)
    assert ogden == pytest.approx(2 * (1 - 1.5**-1.5) - (1.5 - 1.5**-2), abs=1e-9)


def test_isotropic() -> None:
    """ψ(QᵀEQ) = ψ(E)."""
    strain = random_strain(0.2)
    turn, _ = np.linalg.qr(np.random.default_rng(SEED + 1).normal(size=(3, 3)))
    assert psi(turn.T @ strain @ turn) == pytest.approx(psi(strain), rel=1e-12)


def barrier(gap: float, width: float = 0.1, stiffness: float = 2.0) -> float:
    """The plate's energy per area."""
    return number(plate.energy(ufl.as_ufl(gap), ufl.as_ufl(width), ufl.as_ufl(stiffness)))


def test_barrier_reach() -> None:
    """Nothing from the width on; more and more without bound towards the plane."""
    assert barrier(0.1001) == barrier(0.25) == 0.0
    gaps = np.geomspace(1e-12, 0.0999, 60)
    energies = np.array([barrier(gap) for gap in gaps])
    assert (np.diff(energies) < 0).all()
    assert (energies > 0).all()
    assert barrier(1e-300) > 30.0


def test_barrier_pressure() -> None:
    """−dψ/dg = κ (1 − s) down to s = ½, then κ/4s: κ/2 where they meet."""
    for s, pressure in ((0.8, 0.2), (0.5 + 1e-3, 0.499), (0.5 - 1e-3, 0.25 / 0.499), (0.1, 2.5)):
        assert -slope(barrier, 0.1 * s, 1e-7) == pytest.approx(2.0 * pressure, rel=1e-6)


def test_barrier_is_stiff_at_first_touch() -> None:
    """d²ψ/dg² = κ/ĝ just inside, also where round-off puts the skin just outside."""
    gap = ufl.variable(ufl.as_ufl(0.1 * (1 + 1e-12)))
    energy = plate.energy(gap, ufl.as_ufl(0.1), ufl.as_ufl(2.0))
    assert number(ufl.diff(ufl.diff(energy, gap), gap)) == pytest.approx(20.0)


def test_barrier_begins_gently() -> None:
    """ψ = κ ĝ (1 − s)²/2 near s = 1: value and slope go to zero there."""
    for closeness in (1e-2, 1e-3):
        energy = barrier(0.1 * (1 - closeness))
        assert energy == pytest.approx(2.0 * 0.1 * closeness**2 / 2, rel=1e-9)


@pytest.mark.parametrize(
    ("facet", "degree", "nodes", "integrals"),
    [
        ("triangle", 1, 3, [1 / 2, 1 / 6, 1 / 6]),
        ("triangle", 2, 6, [1 / 2, 1 / 6, 1 / 6]),
        ("quadrilateral", 1, 4, [1, 1 / 2, 1 / 2]),
        ("quadrilateral", 2, 8, [1, 1 / 2, 1 / 2]),
    ],
)
def test_nodal_rule(facet: str, degree: int, nodes: int, integrals: list[float]) -> None:
    """The weights are positive and integrate 1, x and y over the reference facet exactly."""
    rule = plate.nodal_rule(facet, degree)
    points, weights = np.array(rule["quadrature_points"]), np.array(rule["quadrature_weights"])
    assert points.shape == (nodes, 2)
    assert (weights > 0).all()
    np.testing.assert_allclose(
        weights @ np.column_stack([np.ones(len(points)), points]), integrals, rtol=1e-14
    )


@pytest.mark.parametrize("share", [0.003, 0.02])
def test_gents_series_is_its_closed_form(share: float) -> None:
    """ψ = −μ/2 [Jₘ ln(1 − x) + Ī₁ − 3] on both sides of where the series gives way to it."""
    strain = ufl.as_matrix(random_strain(0.2).tolist())
    first = number(invariants.isochoric(strain)[0])
    inverse = share / first
    expected = -MU / 2 * (np.log1p(-share) / inverse + first)
    assert number(gent.energy(strain, MU, inverse)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("part", [2e-4, 9.9e-4, 1.1e-3, 0.3])
def test_a_step_much_shorter_than_the_relaxation(part: float) -> None:
    """r + s = (1 − exp(−x))/x, whose digits the series keeps."""
    r, s = (number(ufl.as_ufl(each)) for each in transient_network.weights(part, 1.0))
    assert r == pytest.approx(np.exp(-part), rel=1e-15)
    assert r + s == pytest.approx(-np.expm1(-part) / part, rel=1e-13)


def test_a_networks_energy_where_it_yields() -> None:
    """m/2 q below the limit, m/2 (2 √(q_y q) − q_y) above it, and no jump between."""
    strain, rest = ufl.as_matrix(random_strain(0.2).tolist()), ufl.Identity(3)

    def energy(limit: float) -> float:
        return number(yielding_network.energy(strain, 2.0, rest, limit))

    q = energy(1e3)
    assert energy(q * (1 - 1e-9)) == pytest.approx(q, rel=1e-12)
    assert energy(q / 4) == pytest.approx(0.75 * q, rel=1e-12)
