"""Air through valves, tubes and leaks against closed forms and an independent integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from dolfingrip.mechanics.model.pneumatics import (
    CAVITY,
    REFERENCE_MPA,
    SOURCE,
    TUBE,
    Air,
    Line,
    Pump,
    Restriction,
)

VOLUME = 1e5
"""Volume of the rigid chamber (mm³)."""
VALVE = Restriction(1e5, 0.3)
WIDE = Restriction(1e7, 0.3)
"""A tube that hardly resists."""
AMBIENT = 0.101325


def pressure(air: Air, prescribed: float, step_s: float, volume: float = VOLUME) -> float:
    """Absolute pressure (MPa) in a rigid chamber at a step's end, which is accepted."""
    found = brentq(
        lambda p: air.volume_mm3(p, prescribed, step_s) - volume, 1e-3, 5, xtol=1e-15, rtol=1e-14
    )
    air.accept(air.ends(found, prescribed, step_s), step_s)
    return float(found)


def after(air: Air, prescribed: float, length_s: float, steps: int) -> float:
    """Absolute pressure (MPa) in the chamber after equal steps."""
    return [pressure(air, prescribed, length_s / steps) for _ in range(steps)][-1]


def compressed(exponent: float, leak: Restriction) -> Air:
    """A leaking chamber, closed before with five times the air that it has at rest."""
    air = Air(Line(VALVE, VALVE, WIDE, 1.0, leak, exponent=exponent), syringe=True)
    air.rest(5 * VOLUME)
    pressure(air, AMBIENT, 0.0)
    return air


def held(air: Air) -> float:
    """Air in all volumes less what has entered."""
    return float(air.now.amounts.sum()) - air.now.entered


def test_flow_is_choked_below_the_critical_ratio() -> None:
    """q = C p₁ up to b, the ellipse of ISO 6358 above, 0 at equal pressures, odd in the sides."""
    assert VALVE.flow(0.5, 0.1) == VALVE.flow(0.5, 0.15) == pytest.approx(0.5e5)
    at = VALVE.flow(0.5, 0.5 * 0.65)
    assert at == pytest.approx(0.5e5 * math.sqrt(1 - 0.25), rel=1e-12)
    assert VALVE.flow(0.5, 0.5) == 0
    assert VALVE.flow(0.2, 0.5) == -VALVE.flow(0.5, 0.2)
    assert VALVE.flow(0.5, 0.1, (4.0, 1.0)) == pytest.approx(0.25e5)


def test_an_orifice_has_the_choked_flow_of_a_nozzle() -> None:
    """ṁ = A p √(γ/(R T)) (2/(γ + 1))^((γ+1)/(2(γ−1))) of dry air, R = 287 J/(kg K), at 293.15 K."""
    orifice = Restriction.orifice(1.0, discharge=1.0)
    flux = math.sqrt(1.4 / (287 * 293.15)) * (2 / 2.4) ** 3  # kg/(s m² Pa)
    expected = math.pi / 4 * 1e-6 * 1e6 * flux / 1.185 * 1e9  # mm³/s of free air for each MPa
    assert orifice.conductance == pytest.approx(expected, rel=5e-3)
    assert orifice.critical == pytest.approx((2 / 2.4) ** 3.5, abs=1e-3)


@pytest.mark.parametrize(("exponent", "tolerance"), [(1.0, 1e-4), (1.4, 5e-3)])
def test_choked_filling_of_a_rigid_chamber(exponent: float, tolerance: float) -> None:
    """dp/dt = n p₀ C p₁/V: isothermal, and adiabatic by the balance of energy.

    The tube holds 1e-4 of the chamber's air; with n = 1.4 that of the tube is taken at the
    temperature that it had as the step began.
    """
    air = Air(Line(VALVE, VALVE, WIDE, 10.0, exponent=exponent))
    air.rest(VOLUME)
    found = after(air, 1.1, 0.2, 40)
    rise = exponent * REFERENCE_MPA * VALVE.conductance * 1.1 * 0.2 / VOLUME
    assert found - AMBIENT == pytest.approx(rise, rel=5 * tolerance)
    assert held(air) == pytest.approx(AMBIENT / REFERENCE_MPA * (VOLUME + 10), rel=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_choked_discharge(exponent: float) -> None:
    """Isothermal: exp(−t/τ). Adiabatic: (1 + (γ−1)/2 · t/τ)^(−2γ/(γ−1)), τ by the first state.

    The formula of second order: half the step, a fourth of the error.
    """
    leak = Restriction(1e5, 0.3)
    warm = 5 ** (exponent - 1)
    x = leak.conductance * REFERENCE_MPA * math.sqrt(warm) / VOLUME * 2.0
    g = exponent - 1
    part = math.exp(-x) if g == 0 else (1 + g / 2 * x) ** (-2 * exponent / g)
    expected = AMBIENT * 5**exponent * part
    assert expected > AMBIENT / leak.critical
    errors = []
    for steps in (20, 40):
        errors.append(after(compressed(exponent, leak), AMBIENT, 2.0, steps) - expected)
    print(f"n = {exponent}: errors {errors} of {expected} MPa")
    assert abs(errors[-1]) < 2e-4 * expected
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


def test_a_syringe_compresses_by_p_v_n() -> None:
    """p (V + dead)ⁿ stays, and the amount of air."""
    air = Air(Line(VALVE, VALVE, WIDE, 1.0, exponent=1.3), syringe=True, dead_mm3=2e4)
    air.rest(VOLUME)
    first = AMBIENT * (VOLUME + 2e4) ** 1.3
    air.dead_mm3 = 5e3
    assert pressure(air, AMBIENT, 0.1) * (VOLUME + 5e3) ** 1.3 == pytest.approx(first, rel=1e-12)
    assert held(air) == pytest.approx(AMBIENT / REFERENCE_MPA * (VOLUME + 2e4), rel=1e-14)


def test_tank_tube_and_leak_against_an_integration() -> None:
    """Three isothermal volumes from a full tank to a leaking chamber, by LSODA to 1e-10."""
    tube, leak = Restriction(2e5, 0.4), Restriction(1e4, 0.5)
    line = Line(VALVE, VALVE, tube, 5e3, leak, tank_mm3=5e4, tank_MPa=0.4, band_MPa=0.05)
    target = 0.2

    def rates(_: float, p: np.ndarray) -> list[float]:
        part = min(max((target - p[1]) / 0.05, 0), 1)
        entering = max(part * VALVE.flow(p[0], p[1]), 0)
        out = min(max((p[1] - target) / 0.05, 0), 1) * VALVE.flow(p[1], AMBIENT)
        through, lost = tube.flow(p[1], p[2]), leak.flow(p[2], AMBIENT)
        flows = (-entering, entering - out - through, through - lost)
        return [REFERENCE_MPA * q / v for q, v in zip(flows, (5e4, 5e3, VOLUME), strict=True)]

    solved = solve_ivp(rates, (0, 3), [0.4, AMBIENT, AMBIENT], method="LSODA", rtol=1e-10)
    expected = solved.y[:, -1]
    off = []
    for steps in (60, 120):
        air = Air(line)
        air.rest(VOLUME)
        after(air, target, 3.0, steps)
        off.append(float(np.abs(air.now.pressures[[SOURCE, TUBE, CAVITY]] - expected).max()))
    print(f"off by {off} MPa of {expected}")
    assert off[1] < 5e-5
    total = (0.4 * 5e4 + AMBIENT * (5e3 + VOLUME)) / REFERENCE_MPA
    assert held(air) == pytest.approx(total, rel=1e-12)


def test_a_pump_gives_what_its_curve_gives_at_its_pressure() -> None:
    """Behind a wide valve it has the chamber's pressure; it stops where its curve ends."""
    pump = Pump((AMBIENT, AMBIENT + 0.05), (2e5, 0.0))
    assert pump.through(Restriction(1e12, 0.3), AMBIENT + 0.025) == pytest.approx(1e5, rel=1e-3)
    assert pump.through(VALVE, AMBIENT + 0.06) == 0
    air = Air(Line(WIDE, VALVE, WIDE, 10.0, pump=pump))
    air.rest(VOLUME)
    assert after(air, AMBIENT + 1, 20.0, 200) == pytest.approx(AMBIENT + 0.05, abs=1e-4)


def test_what_is_stored_goes_on_in_the_same_way() -> None:
    air = Air(Line(VALVE, VALVE, WIDE, 10.0, Restriction(1e4, 0.5), exponent=1.2))
    air.rest(VOLUME)
    pressure(air, 0.3, 0.1)
    kept = air.values()
    ends = []
    for _ in range(2):
        ends.append(after(air, 0.3, 0.3, 3))
        air.restore(kept)
    assert ends[0] == ends[1]


def test_slope_is_the_derivative_where_the_air_fits_and_leads_there_elsewhere() -> None:
    air = Air(Line(VALVE, VALVE, WIDE, 10.0))
    air.rest(VOLUME)
    p = brentq(lambda p: air.volume_mm3(p, 0.3, 0.1) - VOLUME, 1e-3, 1, rtol=1e-14)
    d = 1e-4 * p
    by_difference = (air.volume_mm3(p + d, 0.3, 0.1) - air.volume_mm3(p - d, 0.3, 0.1)) / (2 * d)
    assert air.slope(p, 0.3, 0.1, VOLUME, 0.0) == pytest.approx(by_difference, rel=1e-3)
    start = air.volume_mm3(AMBIENT, 0.3, 0.1)
    secant = air.slope(AMBIENT, 0.3, 0.1, VOLUME, 0.0)
    assert AMBIENT + (VOLUME - start) / secant == pytest.approx(p, rel=1e-5)
