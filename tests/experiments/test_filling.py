"""A supply of air behind a chain: closed forms, finite elements, and its speed."""

from __future__ import annotations

import time

import numpy as np
import pytest
from mpi4py import MPI
from support import small

from dolfingrip.channels import AMBIENT_KPA
from dolfingrip.experiments import run
from dolfingrip.experiments.filling import RestingFinger, filled_kPa, step_response
from dolfingrip.experiments.rigs.pneumatics import line_of
from dolfingrip.sections.supply import AirLine

RIGID = RestingFinger(np.array([0.0, 100.0]), np.array([5e4, 5e4]), np.zeros(2))
"""A chamber of 50 cm³."""


def test_choked_filling_of_a_rigid_chamber() -> None:
    """p V rises by C p₁ 0.1 MPa in a second, through a valve much narrower than the tube."""
    supply = AirLine(
        source="tank", tank_cm3=1e6, tank_kPa=900.0, valve_dm3_per_s_bar=0.002,
        tube_dm3_per_s_bar=10.0, tube_cm3=0.01, band_kPa=1.0,
    )  # fmt: skip
    times = np.linspace(0.0, 2.0, 5)
    found = filled_kPa(RIGID, line_of(supply), times, np.full(5, 300.0))
    # 0.002 dm³/(s bar) of 10.01 bar are 2.0 cm³ of free air of 100 kPa in a second
    rate = 0.002 * (900 + AMBIENT_KPA) / 100 * 100 / 0.05
    np.testing.assert_allclose(found, rate * times, rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_it_comes_to_rest_at_the_set_point(exponent: float) -> None:
    """In a fraction of a sixtieth of the time, by the processor's clock."""
    supply = AirLine(board="programmable-air", exponent=exponent)
    times = np.arange(0.0, 60.0, 0.02)
    asked = np.where(times < 40, 30.0, 0.0)
    filled_kPa(RIGID, line_of(supply), times[:100], asked[:100])
    began = time.process_time()
    found = filled_kPa(RIGID, line_of(supply), times, asked)
    spent_s = time.process_time() - began
    print(spent_s)
    assert found[1] < 5
    assert found[1990] == pytest.approx(30, abs=0.1)
    assert found[-1] == pytest.approx(0, abs=0.1)
    assert 60 / spent_s > 60


@pytest.mark.slow
def test_a_finger_of_finite_elements() -> None:
    """Their pressure in the cavity, by their volume at rest."""
    short = ("mesh.size_mm=10", "mesh.edge_size_mm=10", "contact.self_contact=false",
             "experiment.step_kPa=10", "experiment.max_pressure_kPa=40")  # fmt: skip
    rest = run("bending", small.short(*short), comm=MPI.COMM_SELF)
    columns = [
        rest.column(f"{name}") for name in ("pressure_kPa", "cavity_volume_mm3", "angle_deg")
    ]
    times, asked = [0.0, 0.0, 0.05, 0.1, 0.2, 0.3], [0.0, 40.0, 40.0, 40.0, 0.0, 0.0]
    keys = {"source": "pump", "pump_kPa": [0.0, 100.0], "pump_l_per_min": [3.0, 0.0],
            "valve_dm3_per_s_bar": 0.02, "tube_cm3": 3.0}  # fmt: skip
    filling = small.short(*short, "supply.error_kPa=0.2").changed(
        supply=keys, protocol={"time_s": times, "pressure_kPa": asked}
    )
    expected = run("bending", filling, comm=MPI.COMM_SELF).column("cavity_pressure_kPa")
    found = filled_kPa(RestingFinger(*columns), line_of(AirLine(**keys)), times[1:], asked[1:])
    assert expected.max() > 10
    np.testing.assert_allclose(found, expected[1:], atol=0.5)


def test_a_step_goes_on_until_it_is_reached_or_stands() -> None:
    """The choked rate tells the time; a small tank shares its air with chamber and tube."""
    supply = AirLine(
        source="tank", tank_cm3=1e6, tank_kPa=900.0, valve_dm3_per_s_bar=0.002,
        tube_dm3_per_s_bar=10.0, tube_cm3=0.01, band_kPa=0.1,
    )  # fmt: skip
    rate = 0.002 * (900 + AMBIENT_KPA) / 100 * 100 / 0.05
    found = step_response(RIGID, line_of(supply), 80.0)
    assert found.reached_s == pytest.approx(0.95 * 80 / rate, rel=5e-3)
    small = AirLine(source="tank", tank_cm3=45.0, tank_kPa=90.0, tube_cm3=5.0)
    stands = step_response(RIGID, line_of(small), 80.0)
    assert np.isinf(stands.reached_s)
    assert stands.cavity_kPa[-1] == pytest.approx(45 / 100 * 90, rel=0.01)
    assert stands.sentence.startswith("the cavity never has 95 % of 80 kPa: 40.")
