"""Laws in numbers against their UFL energies and closed forms; fits to coupons."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import ufl
from support import compressible
from support.example import EXAMPLES

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.experiments.material_fit import choice, coupons
from dolfingrip.experiments.material_fit.coupons import CouponSeries
from dolfingrip.experiments.material_fit.first_loading import is_hollow
from dolfingrip.experiments.material_fit.fit import fit, of_use, write
from dolfingrip.experiments.material_fit.law import (
    EXPONENTS,
    LAWS,
    Mode,
    limit_points,
    stress,
    unstable_from,
)
from dolfingrip.forms import chain_rule, invariants, neo_hookean, ogden_terms, polynomial
from dolfingrip.forms.evaluate import number
from dolfingrip.sections.laws.polynomial import POWERS

COUPONS = EXAMPLES / "coupons"
VALUES = {
    "neo-hooke": [1.3],
    "mooney-rivlin": [0.5, 0.2],
    "yeoh": [0.5, -0.02, 0.004],
    "gent": [1.3, 50.0],
    "gent-gent": [1.0, 30.0, 0.4],
    "arruda-boyce": [1.0, 3.0],
    "extended-tube": [0.8, 0.4, 0.1, 0.5],
    "ogden-1": [1.2, -2.5],
    "ogden-2": [1.2, 0.3, 1.3, -2.5],
    "ogden-3": [1.2, 0.3, 0.01, 1.3, -2.5, 6.0],
    "polynomial": [0.5, 0.2, -0.02, 0.004],
}
"""Numbers of the laws whose energies are written here a second time, in UFL."""


def density(name: str, strain: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
    """The law's energy in UFL, with VALUES."""
    values = VALUES[name]
    if name == "neo-hooke":
        return neo_hookean.energy(strain, *values, 0.0)
    first, second = invariants.isochoric(strain)
    if name.startswith("gent"):
        mu, limit, entangled = [*values, 0.0][:3]
        chains = -mu * limit / 2 * ufl.ln(1 - first / limit)
        return chains + entangled * ufl.ln((second + 3) / 3)
    if name == "arruda-boyce":
        mu, lock = values
        factors = enumerate((1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750), start=1)
        return sum(mu * a * ((first + 3) ** k - 3**k) / lock ** (2 * k - 2) for k, a in factors)
    if name == "extended-tube":
        links, tubes, delta, beta = values
        rest = 1 - delta**2 * first
        linked = links / 2 * ((1 - delta**2) * first / rest + ufl.ln(rest))
        return linked + ogden_terms.energy(strain, [tubes], [-beta])
    if name.startswith("ogden"):
        half = len(values) // 2
        return ogden_terms.energy(strain, values[:half], values[half:])
    powers = [POWERS[key.rpartition(".")[2]] for key in LAWS[name].keys]
    return polynomial.energy(strain, dict(zip(powers, values, strict=True)))


@pytest.mark.parametrize("mode", EXPONENTS)
@pytest.mark.parametrize("name", VALUES)
def test_numbers_are_the_ufl_energys(name: str, mode: Mode) -> None:
    """dψ/dλ along a path of constant volume is the work of P on one side, or on two."""
    sides = 2 if mode == "equibiaxial" else 1
    for at in (0.7, 1.3, 2.5):
        along = ufl.variable(ufl.as_ufl(at))
        stretches = [along ** float(power) for power in EXPONENTS[mode]]
        strain = ufl.as_matrix(
            [[(stretches[i] ** 2 - 1) / 2 if i == j else 0 for j in range(3)] for i in range(3)]
        )
        expected = number(chain_rule.by_variable(density(name, strain), along)) / sides
        found = float(stress(LAWS[name], mode, np.array([at]), VALUES[name])[0])
        assert found == pytest.approx(expected, rel=1e-6)


def test_compressible_stress_tends_to_the_incompressible() -> None:
    """The difference falls with μ/K; at small strain it is Young's modulus 9Kμ/(3K + μ)."""
    law, values, stretch = LAWS["ogden-2"], VALUES["ogden-2"], np.array([0.8, 1.5, 2.5])
    for mode in EXPONENTS:
        limit = stress(law, mode, stretch, values)
        apart = [
            np.abs(compressible.stress(law, mode, stretch, values, bulk) / limit - 1).max()
            for bulk in (1e3, 1e5)
        ]
        assert apart[1] == pytest.approx(apart[0] / 100, rel=0.1)
    bulk, mu, strain = 4.0, 1.5, 1e-6
    found = compressible.stress(law, "uniaxial", np.array([1 + strain]), values, bulk)[0] / strain
    assert found == pytest.approx(9 * bulk * mu / (3 * bulk + mu), rel=1e-5)


def test_limit_points_of_balloons() -> None:
    """Neo-Hooke's pressure is greatest at 7^(1/6) (Ogden 1984, section 5.2.3); Mooney–Rivlin's with
    C01/C10 = 0.1 has a maximum and a minimum, which meet at C01/C10 = 0.21446."""
    (found,) = limit_points(partial(LAWS["neo-hooke"].energy, [2.0]), 8.0)
    assert found == (pytest.approx(7 ** (1 / 6), abs=1e-6), True)
    both = limit_points(partial(LAWS["mooney-rivlin"].energy, [1.0, 0.1]), 8.0)
    assert [greatest for _, greatest in both] == [True, False]
    assert not limit_points(partial(LAWS["mooney-rivlin"].energy, [1.0, 0.2148]), 8.0)
    assert limit_points(partial(LAWS["mooney-rivlin"].energy, [1.0, 0.2140]), 8.0)


def test_stability() -> None:
    """Mooney–Rivlin with a negative factor loses stability, neo-Hooke does not, however far."""
    for highest in (2.0, 8.0, 20.0):
        assert unstable_from(LAWS["neo-hooke"], "uniaxial", [1.0], highest) is None
    end = unstable_from(LAWS["mooney-rivlin"], "equibiaxial", [1.0, -0.2], 8.0)
    assert end is not None
    assert 1.05 < end < 3
    before = 0.99 * end
    law = LAWS["mooney-rivlin"]
    assert unstable_from(law, "equibiaxial", [1.0, -0.2], before) is None


@pytest.mark.parametrize("top", [7.8, 8.2, 12.0])
def test_the_law_that_is_chosen_does_not_depend_on_the_end_of_a_search(top: float) -> None:
    """One Ogden rubber that is pulled to three stretches, with deviations that no law has."""
    stretch = np.linspace(1.05, top, 60)
    exact = stress(LAWS["ogden-1"], "uniaxial", stretch, VALUES["ogden-1"])
    odd = exact * (1 + 0.02 * np.sin(3 * stretch))
    data = [coupons.CouponSeries("rubber", "uniaxial", stretch, odd, None)]
    chosen = choice.choose([fit(law, data) for law in LAWS.values()], data).best
    assert chosen.law.name == "ogden-1"
    assert not choice.unstable(chosen, dict.fromkeys(coupons.MODES, top))


def made(mode: Mode, name: str, noise: float = 0.0) -> coupons.CouponSeries:
    """A coupon of the law with VALUES."""
    stretch = np.linspace(1.05, 3.0, 40)
    exact = stress(LAWS[name], mode, stretch, VALUES[name])
    print("seed", 5)
    disturbed = exact + np.random.default_rng(5).normal(0, noise, 40) if noise else exact
    return coupons.CouponSeries(name, mode, stretch, disturbed, noise or None)


@pytest.mark.parametrize(
    "name",
    [
        "mooney-rivlin", "yeoh", "gent", "gent-gent", "arruda-boyce", "extended-tube", "ogden-1",
        "ogden-2", "polynomial",
    ],
)  # fmt: skip
def test_a_law_is_found_again(name: str) -> None:
    """From three modes of tension without noise."""
    found = fit(LAWS[name], [made(mode, name) for mode in EXPONENTS])
    assert found.relative_rms < 1e-5
    np.testing.assert_allclose(found.values, VALUES[name], rtol=2e-3)


def test_intervals_hold_the_truth() -> None:
    """Of 40 draws of noise 90 % should; 30 to 40 are within 2.7 standard deviations of that."""
    law, values, inside = LAWS["mooney-rivlin"], np.array(VALUES["mooney-rivlin"]), 0
    exact = made("uniaxial", law.name)
    print("seeds 0 to 39")
    for seed in range(40):
        noise = np.random.default_rng(seed).normal(0, 0.02, 40)
        data = coupons.CouponSeries("", "uniaxial", exact.stretch, exact.stress_MPa + noise, 0.02)
        found = fit(law, [data])
        inside += bool(abs(found.values - values)[1] < found.half_width[1])
    assert 30 <= inside <= 40


def test_an_equibiaxial_coupon_fixes_what_a_uniaxial_one_leaves_open() -> None:
    law = LAWS["polynomial"]
    one, two = made("uniaxial", law.name, 0.05), made("equibiaxial", law.name, 0.05)
    alone, both = fit(law, [one]), fit(law, [one, two])
    assert both.half_width[1] < 0.2 * alone.half_width[1]
    assert any(
        "does not fix the equibiaxial response" in line for line in choice.doubts(alone, [one])
    )
    assert not any("equibiaxial response" in line for line in choice.doubts(both, [one, two]))


def test_ecoflex() -> None:
    """Neo-Hooke's modulus to a stretch of 2.5, 0.0204 MPa ± 2 %, and what the coupon leaves open:
    C01/C10 from 0.1 to 0.6 (both from an independent fit of the same readings)."""
    data = coupons.read(COUPONS / "ecoflex30_uniaxial.csv", 2.5)
    simple = fit(LAWS["neo-hooke"], data)
    assert simple.values[0] == pytest.approx(0.0204, rel=0.02)
    assert 0.02 < simple.relative_rms < 0.03
    biderman = fit(LAWS["polynomial"], data)
    low, high = choice.accepted(biderman, data, np.linspace(0, 2, 201))
    assert low is not None
    assert high is not None
    assert low <= 0.1
    assert high >= 0.6


def test_the_stable_law_with_fewer_constants_is_chosen() -> None:
    """Biderman's fits the printed coupons as Mooney and Rivlin's does, with C10 < 0: it is unstable
    in equibiaxial tension within the measured stretches."""
    data = coupons.read(COUPONS / "ninjaflex_uniaxial.csv")
    fits = {name: fit(LAWS[name], data) for name in ("polynomial", "mooney-rivlin", "ogden-2")}
    assert fits["polynomial"].criterion < fits["mooney-rivlin"].criterion
    found = choice.choose(list(fits.values()), data)
    assert found.best is fits["mooney-rivlin"]
    why, left = found.reasons
    assert "stable (Drucker) in all modes of tension up to a stretch of 1.61" in why
    assert "2 constants, no more than laws that fit as well: Ogden, 2 terms" in why
    assert "polynomial (Biderman) is not chosen: not stable (Drucker) in equibiaxial" in left
    alone = choice.choose([fits["polynomial"]], data)
    assert alone.best is fits["polynomial"]
    assert "which no law is in all modes of tension" in alone.reasons[0]


def test_ninjaflex() -> None:
    """2 C01/μ = 0.93 by the mean curve of all readings; every tenth reading has 0.90."""
    data = coupons.read(COUPONS / "ninjaflex_large_strain.csv")
    assert len(data) == 8
    c10, c01 = fit(LAWS["mooney-rivlin"], data).values
    assert c01 / (c10 + c01) == pytest.approx(0.93, abs=0.04)


@pytest.mark.parametrize("name", ["gent", "yeoh", "ogden-2"])
def test_a_written_law_is_a_configuration(name: str, tmp_path: Path) -> None:
    data = [made(mode, name) for mode in EXPONENTS]
    found = fit(LAWS[name], data)
    write(found, data, tmp_path / "material.toml")
    read = config.load(tmp_path / "material.toml")
    shear = {"gent": 1.3, "yeoh": 1.0, "ogden-2": 1.5}[name]
    assert read.material.shear_MPa == pytest.approx(shear, rel=1e-3)
    if name == "gent":
        assert read.material.gent_limit == pytest.approx(50.0, rel=1e-3)


HEADER = "displacement_mm,force_N,mode\n"
ROWS = "1,1,planar\n2,2,planar\n3,3,planar\n"
SETUP = "gauge_length_mm = 10.0\narea_mm2 = 2.0\n"


@pytest.mark.parametrize(
    ("table", "setup", "said"),
    [
        (
            "force_N\n1\n",
            SETUP,
            "a.csv: missing column; allowed: one of displacement_mm, strain, stretch",
        ),
        (HEADER + "1,x,planar\n", SETUP, "column force_N: allowed: numbers"),
        (HEADER + ROWS, "area_mm2 = 2.0\n", "gauge_length_mm = None: allowed: above 0 mm"),
        (HEADER + ROWS, None, "a.toml: No such file"),
        (
            HEADER + ROWS.replace("planar", "shear"),
            SETUP,
            "mode = shear: allowed: uniaxial, planar",
        ),
        (HEADER + "1,1,planar\n", SETUP, "allowed: at least 3 readings"),
    ],
)
def test_bad_tables_are_one_line(tmp_path: Path, table: str, setup: str | None, said: str) -> None:
    (tmp_path / "a.csv").write_text(table, encoding="utf-8")
    if setup is not None:
        (tmp_path / "a.toml").write_text(setup, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        coupons.read(tmp_path / "a.csv")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_table_tells_its_mode(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(HEADER + ROWS, encoding="utf-8")
    (tmp_path / "a.toml").write_text(SETUP, encoding="utf-8")
    (series,) = coupons.read(tmp_path / "a.csv")
    assert series.mode == "planar"
    np.testing.assert_allclose(series.stretch, [1.1, 1.2, 1.3])
    np.testing.assert_allclose(series.stress_MPa, [0.5, 1.0, 1.5])


def test_nominal_strain_and_stress_are_read(tmp_path: Path) -> None:
    """A table of strains and stresses, as data bases of rubber have it, needs no dimensions."""
    rows = [(0.2, 0.1517), (0.4, 0.2669), (0.6, 0.3628)]
    file = tmp_path / "nominal.csv"
    file.write_text("strain,stress_MPa\n" + "".join(f"{e},{s}\n" for e, s in rows))
    (series,) = coupons.read(file)
    assert series.mode == "uniaxial"
    np.testing.assert_allclose(series.stretch, [1.2, 1.4, 1.6])
    np.testing.assert_allclose(series.stress_MPa, [0.1517, 0.2669, 0.3628])
    assert series.noise_MPa is None
    file.with_suffix(".toml").write_text(
        'mode = "equibiaxial"\n[noise]\nstress_MPa = 0.003\nstrain = 0.01\n'
    )
    (series,) = coupons.read(file)
    steepness = np.polyfit(series.stretch, series.stress_MPa, 1)[0]
    assert series.mode == "equibiaxial"
    assert series.noise_MPa == pytest.approx(np.hypot(0.003, 0.01 * steepness))


def test_a_simpler_law_with_a_smaller_criterion_is_chosen() -> None:
    """Its scatter is twice that of a law with more constants, and both are within the noise."""
    data = [made("uniaxial", "gent", 0.01)]
    simple, rich = (fit(LAWS[name], data) for name in ("gent", "ogden-2"))
    simple = replace(simple, relative_rms=0.02, misfit=2.0)
    rich = replace(rich, relative_rms=0.01, misfit=1.0)
    assert simple.criterion < rich.criterion
    assert choice.choose([rich, simple], data).best is simple
    assert choice.choose([rich, replace(simple, misfit=50.0)], data).best is rich


TWO_TERMS = ([0.15, 0.002, 1.0, -7.0], [0.05, 0.3, 8.0, -1.5], [0.2, 0.001, 1.3, 9.0])
"""Moduli (MPa) and exponents of Ogden's law, the second modulus up to 75 times smaller."""


@pytest.mark.parametrize("values", TWO_TERMS)
def test_a_second_term_of_ogden_s_is_found_wherever_it_is(values: list[float]) -> None:
    stretch = np.linspace(1, 4, 40)
    series = CouponSeries("", "uniaxial", stretch,
                          stress(LAWS["ogden-2"], "uniaxial", stretch, values), None)  # fmt: skip
    found = fit(LAWS["ogden-2"], [series])
    assert found.relative_rms < 1e-6
    assert sorted(found.values) == pytest.approx(sorted(values), rel=1e-3)
    assert of_use(found, [series]) is found


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_term_that_improves_nothing_is_left_out(noise: float) -> None:
    """Neo-Hooke's readings need no second term, whatever law has one."""
    stretch = np.linspace(1.02, 2.5, 60)
    draw = np.random.default_rng(3).standard_normal(60)
    exact = stress(LAWS["neo-hooke"], "uniaxial", stretch, [0.3])
    data = [CouponSeries("", "uniaxial", stretch, exact * (1 + noise * draw), None)]
    for name, simple in (("mooney-rivlin", "neo-hooke"), ("yeoh", "neo-hooke"),
                         ("ogden-2", "ogden-1"), ("ogden-3", "ogden-1")):  # fmt: skip
        assert of_use(fit(LAWS[name], data), data).law.name == simple
    assert of_use(fit(LAWS["ogden-1"], data), data).law.name == "ogden-1"


def test_a_pulled_silicone_is_not_taken_for_a_pressed_one() -> None:
    """Its tangent rises nearly from the start: it stiffens up to a stretch of 7."""
    (series,) = coupons.read(EXAMPLES / "coupons" / "ecoflex30_uniaxial.csv")
    for end in (1.3, 1.6, 1.9, 2.5, 4, 8):
        own = series.stretch <= end
        assert not is_hollow(series.stretch[own] - 1, series.stress_MPa[own])
