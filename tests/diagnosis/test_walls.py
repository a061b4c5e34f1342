"""Walls that are not as drawn: the base model with others, fits, and where a derivative serves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import small
from support.delivered import delivered
from support.here import Here, simulated
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.errors import errors_of
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.finger.model import FingerSimulation, baseline_problem
from dolfingrip.diagnosis.policy import MODEL
from dolfingrip.diagnosis.simulation.simulated import (
    ModelVariant,
    scaled_moduli,
    simulate,
)
from dolfingrip.parameter.nuisances import WALL

PRESSURES_kPa = (0, 15, 30, 45, 60)
TOLD = """experiment = ["bending", "blocked_force"]
[noise]
angle_deg = 0.003
force_N = 0.002
[noise.correlated]
angle_deg = 0.0005
force_N = 0.0004
[plate]
gap_mm = 0.1
"""


def finger() -> Config:
    """Two bellows."""
    return small.short("solver.rtol=1e-9")


def written_with(
    folder: Path, readings: np.ndarray | None = None, told: str = TOLD, names: str = "both"
) -> Measurement:
    """Angles and blocked forces, or ones where no readings are given."""
    return read([written(folder, _table(readings, names), told)], finger())


def _table(readings: np.ndarray | None, names: str) -> str:
    lines = ["experiment,branch,time_s,pressure_kPa,angle_deg,force_N"]
    for name in ("bending", "blocked_force") if names == "both" else (names,):
        for i, pressure in enumerate(PRESSURES_kPa):
            at = i + len(PRESSURES_kPa) * (name == "blocked_force" and names == "both")
            value = 1.0 if readings is None else readings[at]
            entry = f"{value:.7f}," if name == "bending" else f",{value:.7f}"
            lines.append(f"{name},loading,{i},{pressure},{entry}")
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    return written_with(tmp_path_factory.mktemp("walls"))


@pytest.fixture(scope="module")
def simulation(measurement: Measurement, store: Path) -> FingerSimulation:
    return simulated(measurement, finger(), Here(store))


def with_walls(measurement: Measurement, store: Path, walls: float, factor: float = 1.0):
    """Readings, simulated at other walls and moduli."""
    config = finger()
    overrides = {
        "finger.wall_mm": config.finger.wall_mm * walls,
        **scaled_moduli(config, factor),
    }
    return simulate(measurement, config, [ModelVariant(overrides)], Here(store))[0].readings


@pytest.mark.slow
def test_the_model_leads_through_what_was_simulated(
    simulation: FingerSimulation, store: Path
) -> None:
    """At ±δ nearly exactly, between them far nearer to a simulation than along the derivative."""
    measurement, base = simulation.measurement, simulation.base
    model = baseline_problem(simulation, errors_of(simulation))
    std = simulation.wall_std

    def told(walls: float) -> np.ndarray:
        return model.predicted((), np.array([0.0, (walls - 1) / std]))

    for walls in (1 - MODEL.walls_by, 1 + MODEL.walls_by):
        there = with_walls(measurement, store, walls)
        size = np.abs(there - base.readings).max()
        np.testing.assert_allclose(told(walls), there, atol=1e-3 * size)
    there = with_walls(measurement, store, 0.95) - base.readings
    by_derivative = -0.05 * finger().finger.wall_mm * base.slopes["finger.wall_mm"]
    for name in ("angle_deg", "force_N"):
        at = (measurement.listed["column"] == name).to_numpy()
        off = np.abs(told(0.95) - base.readings - there)[at].max()
        print(name, "off by", off, "derivative by", np.abs(by_derivative - there)[at].max(),
              "of", np.abs(there[at]).max())  # fmt: skip
        assert off < 0.01 * np.abs(there[at]).max()
        assert off < 0.5 * np.abs(by_derivative - there)[at].max()


@pytest.mark.slow
def test_it_scales_with_the_modulus(simulation: FingerSimulation, store: Path) -> None:
    """Against a simulation with thinner, softer walls, to what interpolation leaves."""
    measurement = simulation.measurement
    there = with_walls(measurement, store, 1 - MODEL.walls_by, 0.8)
    found = simulation.read(simulation.walls[1 - MODEL.walls_by], 0.8)
    for name, allowed in (("angle_deg", 1e-4), ("force_N", 1e-2)):
        at = (measurement.listed["column"] == name).to_numpy()
        assert np.abs(found - there)[at].max() < allowed * there[at].max()


def test_a_fit_finds_the_walls(measurement: Measurement, store: Path, tmp_path: Path) -> None:
    """The readings were simulated with walls 8 % thinner of a material 10 % softer."""
    true = with_walls(measurement, store, 0.92, 0.9)
    measured = written_with(tmp_path, true)
    found = diagnose_measurement(
        measured, finger(), Here(store), DiagnosisSettings(quick=True, effects=("angle_gain",))
    )
    files = delivered(found, tmp_path / "out")
    assert files.verdict.answer == "none"
    numbers = files.numbers
    print(numbers)
    modulus_MPa, wall_mm = numbers["material.mu_MPa"], numbers["finger.wall_mm"]
    assert wall_mm.low < 0.92 * finger().finger.wall_mm < wall_mm.high
    assert modulus_MPa.low < 0.9 * finger().material.mu_MPa < modulus_MPa.high
    assert np.abs(files.left).max() < 1.0
    assert files.extended.finger.wall_mm == pytest.approx(wall_mm.value)
    assert files.extended.material.mu_MPa == pytest.approx(modulus_MPa.value)


@pytest.mark.parametrize(
    ("names", "more"), [("bending", ""), ("both", "[nuisance]\nwall = 0.005\n")]
)
def test_else_a_derivative_serves(names: str, more: str, tmp_path: Path, store: Path) -> None:
    """Where nothing is blocked, or where the walls are known; nothing is simulated."""
    told = TOLD.replace("force_N = 0.002\n", "").replace("force_N = 0.0004\n", "")
    measured = written_with(tmp_path, None, (told if names == "bending" else TOLD) + more, names)
    own = simulated(measured, finger(), Here(store))
    assert WALL in [each.name for each in own.nuisances]
    own.workers = Here(tmp_path / "none")
    assert own.walls == {}
    assert not (tmp_path / "none").exists()


@pytest.mark.slow
def test_walls_far_from_those_configured_are_simulated(
    measurement: Measurement, store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Readings of walls four standard deviations too thick: these are the cause, and fitted.

    The truth is simulated on the same mesh, whose error is so no part of the readings.
    """
    monkeypatch.setattr("dolfingrip.diagnosis.finger.model.MESH", "not there")
    true = with_walls(measurement, store, 1.2, 0.9)
    measured = written_with(tmp_path, true)
    found = diagnose_measurement(
        measured, finger(), Here(store), DiagnosisSettings(quick=True, effects=("angle_gain",))
    )
    assert found.analysis.simulation.walls.keys() >= {0.9, 1.0, 1.1, 1.2}
    files = delivered(found, tmp_path / "out")
    assert (files.verdict.answer, files.verdict.effects) == ("cause", ("wall_offset",))
    numbers = files.numbers
    print(numbers)
    assert numbers["finger.wall_mm"].low < 1.2 * finger().finger.wall_mm
    assert 1.2 * finger().finger.wall_mm < numbers["finger.wall_mm"].high
