"""Derivatives of a finger's motion, against further runs with the same steps in time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support import differences, small, taylor

from dolfingrip import config
from dolfingrip.channels import of_band
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.request import Place, Request
from dolfingrip.parameter import find
from dolfingrip.sections.tables import assignments

KEYS = (
    "material.mu_MPa", "material.density_kg_m3", "extensions.loss_factor.loss_factor",
    "extensions.tip_mass.mass_g",
)  # fmt: skip
SHAPED = (*KEYS, "finger.base_layer_mm")
COLUMNS = ("angle_deg", "tip_x_mm", "tip_z_mm", "cavity_volume_mm3")


def short(*more: str) -> Config:
    """A finger of two bellows in motion, solved to rounding."""
    sizes = ("mesh.size_mm=10", "mesh.edge_size_mm=10")
    return config.load(None, assignments([*differences.SHORT, *sizes, *differences.MOTION, *more]))


@pytest.fixture(scope="module")
def derived() -> tuple[list[dict[str, float]], list[dict[str, int | float | str]]]:
    """Readings at all stops, and their derivatives."""
    at = short()
    return differences.derivatives("bending", at, find(at, list(SHAPED)))


@pytest.mark.slow
@pytest.mark.parametrize("key", SHAPED)
def test_what_a_derivative_leaves_is_of_second_order(key: str, derived: Any) -> None:
    """Taylor's remainders of readings over time, in parts of their largest values."""
    at, (base, slopes) = short(), derived
    (parameter,) = find(at, [key])
    sizes = {name: max(abs(row[name]) for row in base) for name in COLUMNS}

    def table(rows: list[dict[str, float]]) -> np.ndarray:
        return np.array([[row[name] / sizes[name] for name in COLUMNS] for row in rows])

    def moved(part: float) -> np.ndarray:
        return table(differences.shifted("bending", at, {parameter: parameter.scale}, part))

    slope = table(differences.by_parameter(slopes, key, parameter.scale))
    assert taylor.rates(moved, slope, 0.1, halvings=4) == pytest.approx(2.0, abs=0.1)


def test_derivatives_in_time_take_no_factorisations() -> None:
    """Four of them: the run is the same, and the factors are those of Newton's iterations."""
    at = small.short(
        *differences.MOTION, "mesh.size_mm=10", "mesh.edge_size_mm=10", "solver.rtol=1e-6",
    )  # fmt: skip
    plain, derived = (
        run("bending", at, comm=small.SELF, gradients=keys) for keys in (None, list(KEYS))
    )
    for name in COLUMNS:
        np.testing.assert_allclose(plain.column(name), derived.column(name), rtol=1e-6, atol=1e-6)
    newton = [result.facts.newton for result in (plain, derived)]
    assert newton[0].load_steps == newton[1].load_steps >= 12
    assert newton[0].iterations == newton[1].iterations
    assert newton[1].factorisations <= newton[0].factorisations + 2
    last = {row["parameter"] for row in derived.sensitivities if row["row"] == 6}
    assert last == set(KEYS)


def test_bands_in_motion_are_linear() -> None:
    """A softer body is not the same body under more pressure, once it has mass."""
    at = small.short(*differences.MOTION, "mesh.size_mm=10", "mesh.edge_size_mm=10")
    loss = "extensions.loss_factor.loss_factor"
    certain = ("specimen_scale", "pressure_gain", "pressure_offset_kPa", "wall", "angle_deg")
    spreads = {"modulus": 0.2, loss: 0.05, **dict.fromkeys(certain, 0.0)}
    result = run("bending", at, comm=small.SELF, bands=spreads, gradients=[KEYS[0], loss])
    row = result.rows[-1]
    slopes = {
        entry["parameter"]: float(entry["derivative"])
        for entry in result.sensitivities
        if entry["row"] == len(result.rows) - 1 and entry["column"] == "angle_deg"
    }
    spread = np.hypot(0.2 * at.material.mu_MPa * slopes[KEYS[0]], 0.05 * slopes[loss])
    low, high = (row[end] - row["angle_deg"] for end in of_band("angle_deg"))
    assert [low, high] == pytest.approx([-1.96 * spread, 1.96 * spread], rel=1e-3)


def test_refusals() -> None:
    with pytest.raises(ConfigError, match="dynamic = true: readings at a place: allowed: false"):
        Request.of("bend", short(), places=(Place("angle_deg", 5.0),))
