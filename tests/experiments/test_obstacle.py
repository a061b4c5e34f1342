"""Contact of a finger with what stands beside it: readings and derivatives.

References: sums by hand; differences of the same numbers, of order h².
"""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.channels import OBSTACLE
from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.recorder import columns
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.mechanics.readings.obstacle import FUNCTIONS
from dolfingrip.parameter import find

FORCE, AREA, MEAN, LIFT, SPREAD = (each.name for each in OBSTACLE)
PRESSED = changed(
    Config(),
    {
        **{"finger.bellows": 3, "finger.length_mm": 45.0, "solver.rtol": 1e-11},
        **{"mesh.size_mm": 11.0, "mesh.edge_size_mm": 11.0},
        **{"obstacle.kind": "sausage-short", "obstacle.z_mm": 36.0},
    },
)
KEYS = (
    *("finger.override.2.wall_mm", "finger.override.3.base_layer_mm"),
    *("obstacle.gap_mm", "obstacle.z_mm"),
)


def read(config: Config, *places: Place, keys: tuple[str, ...] = ()) -> object:
    names = (*(each.name for each in OBSTACLE), "pressure_kPa")
    return compute(
        Request.of("bending", config, keys, columns=names, places=places, made_for=PRESSED)
    )


def test_functions_of_a_few_pressures() -> None:
    """Pressures of 1 and 3 kPa on 2 and 2 mm²: mean 2 kPa, standard deviation 1 kPa."""
    sums = (4.0, 8e-3, 20e-6, 3e-3)
    expected = (8e-3, 4.0, 2.0, 3e-3, 0.5)
    for function, value in zip(FUNCTIONS, expected, strict=True):
        found, slopes = function(*sums)
        assert found == pytest.approx(value)
        for i, slope in enumerate(slopes):
            step = 1e-6 * np.eye(4)[i] * sums
            ends = [function(*(np.array(sums) + by * step))[0] for by in (1, -1)]
            assert slope == pytest.approx((ends[0] - ends[1]) / 2 / step[i], rel=1e-6, abs=1e-12)
        assert function(0.0, 0.0, 0.0, 0.0)[0] == 0.0


@pytest.mark.slow
def test_readings_have_derivatives_at_a_pressure_and_at_a_force() -> None:
    """Against differences on the moving mesh, where three places of seven touch in part."""
    at_pressure = Place("pressure_kPa", 60.0)
    found = read(PRESSED, at_pressure)
    force = found.columns[FORCE][0]  # type: ignore[attr-defined]
    assert force > 0.1
    # it presses below the sausage's middle, too; no direction bears more than the cone of friction
    assert 0.38 < found.columns[LIFT][0] / force < np.hypot(1, 0.38)  # type: ignore[attr-defined]
    assert found.columns[MEAN][0] == pytest.approx(1e3 * force / found.columns[AREA][0])  # type: ignore[attr-defined]
    step = 2.5e-4
    places = (at_pressure, Place(FORCE, 0.8 * force))
    found = read(PRESSED, *places, keys=KEYS)
    for each in find(PRESSED, list(KEYS)):
        value = each.value(PRESSED)
        up, down = (read(each.at(PRESSED, value + by), *places).columns for by in (step, -step))  # type: ignore[attr-defined]
        for i, held in enumerate(("pressure_kPa", FORCE)):
            for name in {MEAN, SPREAD, LIFT, FORCE, "pressure_kPa"} - {held}:
                expected = (up[name][i] - down[name][i]) / 2 / step
                slope = found.slopes[name, each.key][i]  # type: ignore[attr-defined]
                assert slope == pytest.approx(expected, rel=1e-5, abs=1e-6)


def test_columns_on_request() -> None:
    plain, asked = (set(columns(Bending(), (), each)) for each in (Config(), PRESSED))
    assert asked - plain == {each.name for each in OBSTACLE}


def test_half_a_finger_refuses_what_differs_from_its_mirror_image() -> None:
    potato = changed(PRESSED, {"obstacle.kind": "potato-small"})
    with pytest.raises(ConfigError, match=r"^obstacle: it differs from its mirror image by "):
        read(potato, Place("pressure_kPa", 1.0))
