"""Slips of units, signs and columns, against a stand-in for the simulation that is itself wrong."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.lab_setup import LabSetup
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.suspicion import reversed_signs, suspicions
from dolfingrip.diagnosis.data.table import MEASURED
from dolfingrip.files.diagnosis import Slip

pd = pytest.importorskip("pandas")

PRESSURE = np.linspace(0.0, 250.0, 11)


def angle_deg(pressure_kPa: np.ndarray) -> np.ndarray:
    """The reference finger's angle, roughly (invented to be of its character)."""
    return 0.5 * pressure_kPa + 4e-4 * pressure_kPa**2


def force_N(pressure_kPa: np.ndarray) -> np.ndarray:
    """Its blocked force, likewise."""
    return 0.0119 * pressure_kPa + 0.008 * np.maximum(pressure_kPa - 150, 0)


def tip_mm(pressure_kPa: np.ndarray) -> np.ndarray:
    """How far its tip moves, likewise."""
    return 0.2 * pressure_kPa - 3e-4 * pressure_kPa**2


SIMULATED = {"angle_deg": angle_deg, "force_N": force_N, "tip_z_mm": tip_mm}


def pulled_N(travel_mm: np.ndarray) -> np.ndarray:
    """Tensile force of an incompressible neo-Hookean bar of 33 mm and 9 mm², μ = 2.93 MPa."""
    stretch = 1 + travel_mm / 33
    return 9 * 2.93 * (stretch - stretch**-2)


def found(columns: dict[str, np.ndarray], pressure: np.ndarray, wrong: float) -> list[Slip]:
    """Suspicions of readings, where the simulation is ``wrong`` times the truth."""
    test = SpecimenTest(0, Path("lab.csv"), "blocked_force", "A", LabSetup())
    table = pd.DataFrame(np.nan, index=range(len(pressure)), columns=list(MEASURED))
    table = table.astype({"experiment": object, "specimen": object, "branch": object})
    table[["experiment", "specimen", "branch"]] = ["blocked_force", "A", "loading"]
    table["cycle"], table["pressure_kPa"], table["test"] = 1, pressure, 0
    for name, values in columns.items():
        table[name] = values
    measurement = Measurement(table, [test])
    simulated = {name: wrong * truth(pressure) for name, truth in SIMULATED.items()}
    listed = measurement.listed
    y0 = np.array([simulated[c][r] for r, c in zip(listed["row"], listed["column"], strict=True)])
    return suspicions(measurement, y0)


@pytest.mark.parametrize("wrong", [0.75, 1.0, 1.3])
@pytest.mark.parametrize(
    ("column", "factor", "meaning"),
    [
        ("angle_deg", 180 / math.pi, "radians"),
        ("angle_deg", -1.0, "sign"),
        ("force_N", 1 / 101.97, "grams"),
        ("force_N", -1.0, "sign"),
        ("force_N", 9.81, "in kg"),
        ("force_N", 1 / 1000, "in mN"),
        ("force_N", 1 / 9.81, "multiplied by g"),
        ("angle_deg", math.pi / 180, "degrees turned twice"),
        ("tip_z_mm", 10.0, "a length in cm"),
        ("tip_z_mm", 1000.0, "a length in m"),
    ],
)
def test_a_column_in_another_unit(wrong: float, column: str, factor: float, meaning: str) -> None:
    true = {name: truth(PRESSURE) for name, truth in SIMULATED.items()}
    true[column] = true[column] / factor
    (said,) = found(true, PRESSURE, wrong)
    assert said.column == column
    assert said.factor == pytest.approx(factor, rel=1e-3)
    assert meaning in said.meaning


@pytest.mark.parametrize("wrong", [0.4, 2.0, 3.0])
def test_an_angle_in_radians_of_another_material(wrong: float) -> None:
    """No modulus makes up for a ratio of 23 to 172."""
    (said,) = found({"angle_deg": np.radians(angle_deg(PRESSURE))}, PRESSURE, wrong)
    assert said.meaning == "an angle in radians"
    assert found({"angle_deg": angle_deg(PRESSURE)}, PRESSURE, 3.9) == []


@pytest.mark.parametrize("wrong", [0.8, 1.0, 1.25])
@pytest.mark.parametrize(("factor", "unit"), [(100, "bar"), (1000, "MPa"), (6.895, "psi")])
def test_pressure_in_another_unit(wrong: float, factor: float, unit: str) -> None:
    true = {"angle_deg": angle_deg(PRESSURE), "force_N": force_N(PRESSURE)}
    said = found(true, PRESSURE / factor, wrong)
    of_pressure = [each for each in said if each.column == "pressure_kPa"]
    assert [each.factor for each in of_pressure] == [factor]
    assert unit in of_pressure[0].meaning


def test_swapped_columns() -> None:
    (said,) = found({"angle_deg": force_N(PRESSURE), "force_N": angle_deg(PRESSURE)}, PRESSURE, 0.9)
    assert "swapped with force_N" in said.meaning


@pytest.mark.parametrize(
    ("curved", "told"), [(0.00045, "rises by equal steps"), (0.0, "cannot tell from a unit")]
)
def test_pressure_exchanged_with_angle(curved: float, told: str) -> None:
    """A curve's set points tell; where it is a line, no material does, and a unit is named, too."""
    turned_deg = curved * PRESSURE**2 + 0.19 * PRESSURE
    columns = {"pressure_kPa": turned_deg, "angle_deg": PRESSURE}
    simulated = curved * turned_deg**2 + 0.19 * turned_deg
    for modulus in (0.7, 1.0, 1.5):
        doubts = suspicions(lab(columns, "bending"), simulated / modulus)
        print(doubts)
        assert any("swapped" in doubt.meaning and told in doubt.meaning for doubt in doubts)
        assert curved or len(doubts) > 1
        right = {"pressure_kPa": PRESSURE, "angle_deg": turned_deg}
        assert not suspicions(lab(right, "bending"), turned_deg / modulus)


@pytest.mark.parametrize("wrong", [0.5, 0.8, 1.0, 1.5, 2.0])
def test_a_poor_simulation_is_no_slip(wrong: float) -> None:
    assert (
        found({"angle_deg": angle_deg(PRESSURE), "force_N": force_N(PRESSURE)}, PRESSURE, wrong)
        == []
    )


@pytest.mark.parametrize("wrong", [0.8, 1.25])
@pytest.mark.parametrize(("factor", "unit"), [(1000, "m"), (10, "cm")])
def test_travel_in_another_unit(wrong: float, factor: float, unit: str) -> None:
    """Where a force in mN, or one multiplied by g, would do as well, both are said."""
    test = SpecimenTest(0, Path("lab.csv"), "coupon", "A", LabSetup())
    travel_mm = np.linspace(0, 16, 9)
    table = pd.DataFrame(np.nan, index=range(9), columns=list(MEASURED))
    table = table.astype({"experiment": object, "specimen": object, "branch": object})
    table[["experiment", "specimen", "branch"]] = ["coupon", "A", "loading"]
    table["test"], table["displacement_mm"] = 0, travel_mm / factor
    table["force_N"] = pulled_N(travel_mm)
    said = suspicions(Measurement(table, [test]), wrong * pulled_N(travel_mm / factor))
    assert {each.column for each in said} == {"displacement_mm", "force_N"}
    assert (f"a displacement in {unit}", factor) in [(each.meaning, each.factor) for each in said]


@pytest.mark.parametrize(
    ("factor", "meaning"), [(-1.0, "the sign is reversed"), (0.01, "a strain in percent")]
)
def test_a_width_in_percent_or_with_its_sign_reversed(factor: float, meaning: str) -> None:
    """Of a bar at constant volume, up to 2 % of strain: percents are below 1 there, too."""
    test = SpecimenTest(0, Path("lab.csv"), "coupon", "A", LabSetup())
    strain = np.linspace(0, 0.02, 9)
    table = pd.DataFrame(np.nan, index=range(9), columns=list(MEASURED))
    table = table.astype({"experiment": object, "specimen": object, "branch": object})
    table[["experiment", "specimen", "branch"]] = ["coupon", "A", "loading"]
    table["test"], table["displacement_mm"] = 0, 33 * strain
    narrowed = (1 + strain) ** -0.5 - 1
    table["transverse_strain"] = narrowed / factor
    (said,) = suspicions(Measurement(table, [test]), 0.92 * narrowed)
    assert (said.column, said.factor) == ("transverse_strain", factor)
    assert meaning in said.meaning


def test_noise_is_no_small_unit() -> None:
    """Readings that do not follow the model, though a fifty-seventh of it is the nearest scale."""
    true = angle_deg(PRESSURE)
    noise = np.cos(PRESSURE)
    noise -= true * (noise @ true) / (true @ true)
    size = np.linalg.norm(np.radians(true)) / np.linalg.norm(noise)
    assert found({"angle_deg": np.radians(true) + 0.5 * size * noise}, PRESSURE, 1.0)
    assert not found({"angle_deg": np.radians(true) + 1.5 * size * noise}, PRESSURE, 1.0)


def coupons(travel: np.ndarray, force: np.ndarray) -> list[Slip]:
    """Doubts about two coupons of 33 mm and 9 mm², pulled at 2.5 mm/s."""
    tests = [SpecimenTest(i, Path("lab.csv"), "coupon", f"S{i}", LabSetup()) for i in range(2)]
    table = pd.DataFrame(np.nan, index=range(2 * len(travel)), columns=list(MEASURED))
    table = table.astype({"experiment": object, "specimen": object, "branch": object})
    table[["experiment", "branch", "cycle"]] = ["coupon", "loading", 1]
    table["test"] = np.repeat([0, 1], len(travel))
    table["specimen"] = np.repeat(["S0", "S1"], len(travel))
    table["time_s"] = np.tile(np.linspace(0.5, 6.5, len(travel)), 2)
    table["displacement_mm"], table["force_N"] = np.tile(travel, 2), np.tile(force, 2)
    measurement = Measurement(table, tests)
    listed = measurement.listed
    simulated = pulled_N(table["displacement_mm"].to_numpy(dtype=float))[listed["row"]]
    return suspicions(measurement, simulated)


TRAVEL = np.linspace(1.0, 16.0, 12)


def test_coupons_that_are_right_raise_no_doubt() -> None:
    assert coupons(TRAVEL, 1.3 * pulled_N(TRAVEL)) == []


@pytest.mark.parametrize(
    ("travel", "force", "told"),
    [
        (TRAVEL / 10, pulled_N(TRAVEL), "a displacement in cm"),
        (TRAVEL, pulled_N(TRAVEL) / 1000, "a force in kN"),
        (pulled_N(TRAVEL), TRAVEL, "swapped with force_N, which rises evenly in time"),
    ],
)
def test_slips_of_coupons_are_told_once(travel: np.ndarray, force: np.ndarray, told: str) -> None:
    found = coupons(travel, force)
    assert any(told in each.meaning for each in found)
    assert {each.where for each in found} == {"coupon, 2 specimens (lab.csv)"}


def lab(columns: dict[str, np.ndarray], experiment: str = "blocked_force") -> Measurement:
    """A measurement of one test, without a simulation."""
    table = pd.DataFrame(np.nan, index=range(len(columns["angle_deg"])), columns=list(MEASURED))
    table = table.astype({"experiment": object, "specimen": object, "branch": object})
    table[["experiment", "specimen", "branch"]] = [experiment, "A", "loading"]
    table["cycle"], table["test"] = 1, 0
    for name, values in columns.items():
        table[name] = values
    return Measurement(table, [SpecimenTest(0, Path("lab.csv"), experiment, "A", LabSetup())])


@pytest.mark.parametrize("rows", [[0, 3, 6, 10], list(range(11))])
@pytest.mark.parametrize("towards", [1.0, -0.3])
def test_a_reversed_sign_is_seen_without_a_simulation(rows: list[int], towards: float) -> None:
    """Under pressure or suction, by four readings or eleven, of whatever size the angle is."""
    pressure = towards * PRESSURE[rows]
    for size in (0.02, 1.0, 13.0):
        angle = size * towards * angle_deg(PRESSURE[rows])
        force = force_N(PRESSURE[rows])
        columns = {"pressure_kPa": pressure, "angle_deg": -angle}
        (said,) = reversed_signs(lab(columns), Config())
        assert (said.column, said.meaning, said.factor) == (
            "angle_deg", "the sign is reversed", -1.0
        )  # fmt: skip
        told = {**columns, "angle_deg": angle, "force_N": towards * force}
        assert reversed_signs(lab(told), Config()) == []
    noise = np.random.default_rng(7).normal(0.0, 0.3, len(rows))
    if len(rows) > 4:  # noise falls with no pressure
        assert reversed_signs(lab({**columns, "angle_deg": noise}), Config()) == []


def test_a_mesh_of_one_s_own_may_bend_to_either_side() -> None:
    columns = {"pressure_kPa": PRESSURE, "angle_deg": -angle_deg(PRESSURE)}
    own = Config().changed(mesh={"file": "own.msh"})
    assert reversed_signs(lab(columns), own) == []


@pytest.mark.parametrize("wrong", [4.0, 0.08])
def test_a_reversed_sign_is_seen_beside_a_modulus_that_is_far_off(wrong: float) -> None:
    """No unit explains such a factor: the sign is what the readings tell."""
    true = {"angle_deg": angle_deg(PRESSURE), "tip_z_mm": -tip_mm(PRESSURE)}
    (said,) = found(true, PRESSURE, wrong)
    assert (said.column, said.factor, said.meaning) == ("tip_z_mm", -1.0, "the sign is reversed")
