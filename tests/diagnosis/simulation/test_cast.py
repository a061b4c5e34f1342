"""The base simulation of cast blocks: two specimens of silicone with a film, law of Ogden.

Nothing was measured: what is simulated matters here.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.here import Here, simulated
from support.measured_files import written

from dolfingrip import config as configuration
from dolfingrip.config import Change, Config, ConfigError
from dolfingrip.diagnosis import diagnose as diagnosing
from dolfingrip.diagnosis.core.blend import Tangents
from dolfingrip.diagnosis.core.unknown import factor_of_moduli
from dolfingrip.diagnosis.data.measurement import Measurement, read, selected
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.finger import FingerSimulation, coarser
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.screening import analyse, not_reached, simulator_of
from dolfingrip.diagnosis.simulation.nuisances import keys
from dolfingrip.diagnosis.simulation.point import Point, scaled_moduli
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, SimulatedReadings, simulate
from dolfingrip.diagnosis.simulation.unknowns import rig_numbers
from dolfingrip.sections.tables import assignments

TOLD = """experiment = "bending"
max_pressure_kPa = 8
[finger]
kind = "cast"
[specimen.A.cast]
chambers = 1
[specimen.B.cast]
chambers = 1
wall_mm = 6.0
[nuisance]
film.silk.Et_N_per_mm = 1.0
"""
FILM = "film.silk.Et_N_per_mm"


def block() -> Config:
    return configuration.load(
        None,
        assignments([
            "finger.kind=cast", "cast.chambers=1", "contact.self_contact=false",
            "mesh.size_mm=7", "mesh.edge_size_mm=2", "material.law=ogden",
            "material.ogden_mu_MPa=[0.015, 0.005]", "material.ogden_alpha=[2.0, -2.0]",
            "film.silk.model=layer", "film.silk.region=film", f"{FILM}=3.0", "solver.rtol=1e-9",
        ]),
    )  # fmt: skip


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    """Readings to 10 kPa, those up to 8 kPa compared."""
    lines = ["experiment,specimen,time_s,branch,pressure_kPa,chord_angle_deg"]
    lines += [
        f"bending,{who},{p},loading,{p},{angle}"
        for who, angle in (("A", 1.0), ("B", 1.1))
        for p in (2, 4, 6, 8, 10)
    ]
    folder = tmp_path_factory.mktemp("cast")
    found, notes = selected(
        read([written(folder, "\n".join(lines) + "\n", TOLD)], block()), block()
    )
    assert notes == ["readings above 8 kPa (max_pressure_kPa of lab.csv) are left out"]
    assert found.listed["control"].max() == 8
    return found


@pytest.fixture(scope="module")
def simulation(measurement: Measurement, store: Path) -> FingerSimulation:
    return simulated(measurement, block(), Here(store))


@pytest.fixture(scope="module")
def base(simulation: FingerSimulation) -> SimulatedReadings:
    return simulation.base


def with_all(measurement: Measurement, store: Path, overrides: Change) -> SimulatedReadings:
    return simulate(measurement, block(), [ModelVariant(overrides)], Here(store))[0]


def test_nuisances(simulation: FingerSimulation, measurement: Measurement, store: Path) -> None:
    """Against central differences, and dα/dln c = −p dα/dp; what a laboratory names is one."""
    base = simulation.base
    columns = {each.name: each.change for each in simulation.rig}
    assert list(columns) == [
        "modulus", "wall", "pressure_gain", "pressure_offset_kPa", FILM,
        "specimen_scale of A", "specimen_scale of B",
    ]  # fmt: skip
    pressure = measurement.listed["control"].to_numpy()
    exactly = -0.2 * pressure * base.by_control
    np.testing.assert_allclose(columns["modulus"], exactly, atol=0.02 * np.abs(exactly).max())
    ends = [
        with_all(measurement, store, {**simulation.flat, FILM: 3 + way}).readings
        for way in (0.05, -0.05)
    ]
    np.testing.assert_allclose(columns[FILM], 10 * (ends[0] - ends[1]), rtol=1e-3)
    walls = 0.05 * np.where(measurement.listed["specimen"] == "A", 7.0, 6.0)
    np.testing.assert_allclose(columns["wall"], walls * base.slopes["cast.wall_mm"])
    assert (columns["wall"] < 0).all()


def test_the_bodys_own_numbers_are_fitted_as_moduli_are(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against a simulation with a stiffer film and all moduli changed, to what is far below the
    noise; no film has no stiffness."""
    solid, _ = rig_numbers(measurement, block())
    (film,) = solid
    assert (film.key, film.prior.at(1.0), film.modulus) == (FILM, 4.0, True)
    factor = factor_of_moduli(0.2, -5.0, 5.0)
    where = Point(factor, factor.zeta(1.25), ((film, 0.2),))
    (found,) = simulation.at([where])
    assert found is not None
    there = scaled_moduli(block(), 1.25)
    assert there["material.ogden_mu_MPa"] == [0.01875, 0.00625]
    flat = {**simulation.flat, **there}
    plain, stiffer = (
        with_all(measurement, store, {**flat, FILM: 1.25 * et}).readings for et in (3.0, 3.2)
    )
    np.testing.assert_allclose(found.told[0, :, 0] - simulation.delta, stiffer, rtol=1e-4)
    by_u = (stiffer - plain) / 0.2
    np.testing.assert_allclose(found.told[0, :, 2], by_u, rtol=0.25)
    assert film.prior.at(film.low) > 0 >= film.prior.at(film.low - 0.1) - 1e-9
    assert film.high == pytest.approx(Policy().shape_reach)


def test_a_highest_pressure_below_all_readings_is_refused(tmp_path: Path) -> None:
    lines = "experiment,time_s,branch,pressure_kPa,chord_angle_deg\n"
    lines += "bending,9,loading,9,1\nbending,10,loading,10,2\n"
    file = written(tmp_path, lines, TOLD.partition("[specimen")[0])
    with pytest.raises(ConfigError, match=r"^max_pressure_kPa = 8 of lab.csv: below all readi"):
        selected(read([file], block()), block())


ROUGH = block().changed(
    solver={"min_step_kPa": 5.0, "max_iterations": 15}, mesh={"edge_size_mm": 7.0}
)
"""As near to the limit point as need be, on as few elements."""


@pytest.mark.slow
def test_readings_that_moduli_reach_which_follow_the_others_are_not_left_out(
    tmp_path: Path, store: Path
) -> None:
    """The finger as configured balloons at 36 kPa; readings to 45 kPa are of 1.5 times its moduli,
    which the readings to 30 kPa tell."""
    pressures_kPa = (5, 10, 15, 20, 25, 30, 45)
    lines = "experiment,specimen,time_s,branch,pressure_kPa,chord_angle_deg\n"
    lines += "".join(f"bending,A,{p},loading,{p},{p / 50}\n" for p in pressures_kPa)
    told = TOLD.replace("max_pressure_kPa = 8\n", "").partition("[specimen")[0]
    told += "[noise]\nchord_angle_deg = 0.005\n"
    balloons = ROUGH.changed(mesh={"edge_size_mm": 5.0})
    measurement = read([written(tmp_path, lines, told)], balloons)
    stiffer = ModelVariant({**coarser(balloons)[0], **scaled_moduli(balloons, 1.5)})
    (true,) = simulate(measurement, balloons, [stiffer], Here(store))
    configured = simulator_of(measurement.reading(true.readings), balloons, Here(store))
    (said,) = configured.not_reached
    assert "does not reach 1 of 7 readings" in said
    analysis = analyse(configured, [])
    assert list(analysis.simulation.not_reached) == []
    np.testing.assert_array_equal(analysis.problem.value, true.readings)
    np.testing.assert_array_equal(np.isfinite(analysis.configured), [True] * 6 + [False])
    assert analysis.simulation.start is not None
    assert analysis.simulation.start.moduli == pytest.approx(1.5, rel=0.05)


@pytest.mark.slow
def test_readings_beyond_the_end_of_a_path_are_said(tmp_path: Path, store: Path) -> None:
    """60 kPa is beyond the limit point; a test of which nothing is left is refused."""
    lines = "experiment,specimen,time_s,branch,pressure_kPa,chord_angle_deg\n"
    lines += "".join(f"bending,A,{p},loading,{p},1\n" for p in (2, 4, 60))
    told = TOLD.replace("max_pressure_kPa = 8\n", "").partition("[specimen")[0]
    ended = read([written(tmp_path, lines, told)], ROUGH)
    (run,) = simulate(ended, ROUGH, [ModelVariant()], Here(store))
    (said,) = not_reached(ended, np.isfinite(run.readings), run)
    assert said.startswith(
        "bending of A: the base simulation does not reach 1 of 3 readings, which are left out: "
        "stopped at "
    )
    lines += "".join(f"bending,B,{p},loading,{p},1\n" for p in (60, 70))
    nothing = read([written(tmp_path, lines, told)], ROUGH)
    with pytest.raises(ConfigError, match=r"^bending of B: the base simulation reaches no reading"):
        diagnose_measurement(nothing, ROUGH, Here(store), DiagnosisSettings(quick=True, effects=()))


def test_moduli_at_which_the_finger_ends_before_its_readings_are_left(
    simulation: FingerSimulation, measurement: Measurement, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The readings are of 0.6 times the moduli, where the simulation is made to reach nothing."""
    softer = {**simulation.flat, **scaled_moduli(block(), 0.6)}
    (there,) = simulate(measurement, block(), [ModelVariant(softer)], simulation.workers)
    soft = measurement.reading(there.readings)
    plain = FingerSimulation.plain

    def reached(self: FingerSimulation, point: Point) -> Tangents:
        found = plain(self, point)
        return found if point.moduli > 0.9 else replace(found, told=np.nan * found.told)

    monkeypatch.setattr(FingerSimulation, "plain", reached)
    found = analyse(simulator_of(soft, block(), simulation.workers), [])
    (runs,) = found.problem.runs.values()
    assert len(runs.u) == 1
    assert found.simulation.start is not None
    assert found.simulation.start.moduli == pytest.approx(1.0, rel=1e-6)


def test_a_wrong_unit_is_suspected_before_anything_is_fitted(
    simulation: FingerSimulation, measurement: Measurement, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the one simulation as configured, whose angles are read in radians."""
    (there,) = simulate(measurement, block(), [ModelVariant(simulation.flat)], simulation.workers)
    wrong = measurement.reading(np.radians(there.readings))
    told: list[str] = []

    class FittedError(Exception):
        """Ends the diagnosis."""

    def fitted(*_: object, **__: object) -> None:
        raise FittedError

    monkeypatch.setattr(diagnosing, "analyse", fitted)
    settings = DiagnosisSettings(say=told.append)
    with pytest.raises(FittedError):
        diagnose_measurement(wrong, block(), simulation.workers, settings)
    assert told[0] == "simulating the measurement as configured"
    assert "an angle in radians" in told[1]


def test_a_nuisance_that_nothing_feels_is_refused(tmp_path: Path) -> None:
    """A finger that bends freely meets no plate; it has walls."""
    lines = "pressure_kPa,angle_deg\n0,0\n5,1\n"
    told = 'experiment = "bending"\n[nuisance]\n'
    walls = read([written(tmp_path, lines, told + "wall = 0.1\n")], block())
    assert "cast.wall_mm" in keys(walls, block())
    plate = read([written(tmp_path, lines, told + "plate_gap_mm = 0.5\n")], block())
    with pytest.raises(ConfigError, match=r"^\[nuisance\] plate_gap_mm = 0.5: nothing in these"):
        keys(plate, block())
    twice = read([written(tmp_path, lines, told + "cast.wall_mm = 0.5\n")], block())
    with pytest.raises(ConfigError, match=r"^\[nuisance\] cast.wall_mm = 0.5: every hypothesis"):
        keys(twice, block())
    lone = Config().changed(mesh={"file": "finger.msh"})
    with pytest.raises(ConfigError, match=r"^\[nuisance\] wall = 0.1: nothing .*; allowed: modu"):
        keys(walls, lone)


def test_a_nuisance_of_no_test_is_refused(tmp_path: Path) -> None:
    lines = "experiment,time_s,branch,pressure_kPa,chord_angle_deg\n"
    lines += "bending,1,loading,2,1\nbending,2,loading,4,2\n"
    told = TOLD.partition("[specimen")[0]
    other = written(tmp_path, lines, told + "[nuisance.finger]\ngap_mm=1\n")
    with pytest.raises(
        ConfigError, match=r"^\[nuisance\] finger.gap_mm = [0-9.]+: nothing in these tes"
    ):
        keys(read([other], block()), block())
    wrong = written(tmp_path, lines, told + "[nuisance.cast]\nwal_mm=1\n")
    with pytest.raises(ConfigError, match=r"\[nuisance\] cast.wal_mm: .*did you mean cast.wall_mm"):
        read([wrong], block())
