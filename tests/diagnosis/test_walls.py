"""Walls that are not as drawn: the base model with others, fits, and where a derivative serves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import small
from support.delivered import delivered
from support.here import Here
from support.measured_files import written

from dolfingrip import config as configuration
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.simulation.point import scaled_moduli
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, simulate
from dolfingrip.diagnosis.simulation.unknowns import unknowns

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
    """Two bellows of few elements, which do not touch."""
    return small.short(
        "solver.rtol=1e-9", "mesh.size_mm=8", "mesh.edge_size_mm=8", "contact.self_contact=false"
    )


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


def with_walls(measurement: Measurement, store: Path, walls: float, factor: float = 1.0):
    """Readings, simulated at other walls and moduli."""
    config = finger()
    overrides = {
        "finger.wall_mm": config.finger.wall_mm * walls,
        **scaled_moduli(config, factor),
    }
    return simulate(measurement, config, [ModelVariant(overrides)], Here(store))[0].readings


@pytest.mark.slow
def test_a_fit_finds_the_walls(measurement: Measurement, store: Path, tmp_path: Path) -> None:
    """The readings were simulated with walls 8 % thinner of a material 10 % softer."""
    true = with_walls(measurement, store, 0.92, 0.9)
    measured = written_with(tmp_path, true)
    workers = Here(store)
    found = diagnose_measurement(
        measured, finger(), workers, DiagnosisSettings(quick=True, effects=("angle_gain",))
    )
    assert len(workers.spent_s) <= 16  # a first answer, free and blocked, of sharp readings
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


@pytest.mark.slow
def test_walls_far_from_those_configured_are_simulated(
    measurement: Measurement, store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Readings of walls four standard deviations too thick: these are the cause, and fitted.

    The truth is simulated on the same mesh, whose error is so no part of the readings.
    """
    monkeypatch.setattr("dolfingrip.diagnosis.finger.MESH", "not there")
    true = with_walls(measurement, store, 1.2, 0.9)
    measured = written_with(tmp_path, true)
    found = diagnose_measurement(
        measured, finger(), Here(store), DiagnosisSettings(quick=True, effects=("angle_gain",))
    )
    files = delivered(found, tmp_path / "out")
    assert (files.verdict.answer, files.verdict.effects) == ("cause", ("wall_offset",))
    numbers = files.numbers
    print(numbers)
    assert numbers["finger.wall_mm"].low < 1.2 * finger().finger.wall_mm
    assert 1.2 * finger().finger.wall_mm < numbers["finger.wall_mm"].high


def test_a_mesh_file_has_no_dimension_that_may_be_off(tmp_path: Path) -> None:
    """Its other causes are simulated in one go, which such a cause would end."""
    part = configuration.load(None, {"mesh.file": "none.msh", "finger.kind": "adopted"})
    rows = "pressure_kPa,angle_deg\n0,0\n25,2\n50,4\n"
    measurement = read([written(tmp_path, rows, 'experiment = "bending"\n')], part)
    names = {cause.name for cause in unknowns(measurement, part)}
    assert names.isdisjoint({"base_layer_offset", "wall_offset"})
    assert "mooney_rivlin" in names
    with pytest.raises(ConfigError, match=r"^--effects base_layer_offset: allowed: with a body"):
        unknowns(measurement, part, ["base_layer_offset"])
