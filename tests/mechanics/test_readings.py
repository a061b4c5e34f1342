"""Each reading's derivatives against Taylor series: along a displacement, and by the plate."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from mpi4py import MPI
from support import small, taylor

from dolfingrip import config
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.rigs import bar_rig
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.mechanics.readings.reading import NotDifferentiable, Reading
from dolfingrip.mechanics.readings.tip import TipDisplacement
from dolfingrip.sections.tables import assignments

SEED = 11
COLUMNS = ("angle_deg", "chord_angle_deg", "tip_x_mm", "tip_z_mm", "cavity_volume_mm3", "force_N")
FLAT = ("time_s", "pressure_kPa", "cavity_pressure_kPa")
"""Controls and time do not depend on the state."""


@pytest.fixture(scope="module", params=["true", "false"], ids=["half", "whole"])
def finger(request: pytest.FixtureRequest) -> FingerModel:
    """Irregularly displaced, and touching the plate."""
    print("seed", SEED)
    found = small.model(small.short(f"mesh.half={request.param}"), plate=True)
    model, plate = found.model, found.plate
    assert plate is not None
    rng = np.random.default_rng(SEED)
    nodes = model.u.function_space.tabulate_dof_coordinates()
    moved = nodes @ (0.1 * rng.uniform(-1, 1, (3, 3))) + 0.05 * np.sin(nodes)
    model.u.x.array[:] = moved.ravel()
    plate.put()
    plate.put(float(plate.offset.value) + 0.6 * plate.width_mm)  # some points pass s = 1/2
    return found


def readings(finger: FingerModel) -> dict[str, Reading]:
    return Observation(finger).readings


def along_state(model: Model, size: float) -> np.ndarray:
    """An irregular direction of the displacement."""
    rng = np.random.default_rng(SEED + 1)
    nodes = model.u.function_space.tabulate_dof_coordinates()
    return np.asarray(size * (nodes @ rng.uniform(-1, 1, (3, 3)) / 10 + np.cos(nodes)).ravel())


def at_state(model: Model, direction: np.ndarray, value: Callable[[], float]) -> Callable:
    start = model.u.x.array.copy()

    def at(step: float) -> float:
        model.u.x.array[:] = start + step * direction
        found = value()
        model.u.x.array[:] = start
        return found

    return at


def exact(function: Callable[[float], float], slope: float) -> bool:
    """Whether a linear function has this slope, to rounding."""
    change = function(1.0) - function(0.0)
    return change == pytest.approx(slope, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("column", COLUMNS)
def test_by_state(finger: FingerModel, column: str) -> None:
    model, reading = finger.model, readings(finger)[column]
    direction = along_state(model, 0.02 if column == "force_N" else 1.0)
    owned = model.unknowns.owned_part(direction)
    slope = float(reading.gradient() @ owned)
    assert slope != 0
    at = at_state(model, direction, reading.value)
    assert exact(at, slope) or taylor.rates(at, slope, 0.1).min() > 1.9


def test_force_by_the_plates_place(finger: FingerModel) -> None:
    plate, force = finger.plate, readings(finger)["force_N"]
    assert plate is not None
    curvature = plate.pose_curvature(finger.model.u.x.array)
    own = plate.motion @ curvature @ plate.pose.rate(plate.offset)
    slope = finger.model.domain.copies * float(own)
    start = float(plate.offset.value)

    def at(step: float) -> float:
        plate.offset.value = start + step
        found = force.value()
        plate.offset.value = start
        return found

    assert slope > 0.1
    assert taylor.rates(at, slope, 0.01).min() > 1.9


@pytest.mark.parametrize("column", FLAT)
def test_controls_do_not_depend_on_the_state(finger: FingerModel, column: str) -> None:
    assert not readings(finger)[column].gradient().any()


def test_a_pressure_that_is_solved_for_is_an_unknown() -> None:
    finger = small.model(small.short("experiment.control=volume"), plate=False)
    (unknown,) = finger.model.unknowns.global_unknowns
    step = finger.model.unknowns.local()
    step[:] = 0.0
    step[unknown.place] = 1.0
    for column in ("pressure_kPa", "cavity_pressure_kPa"):
        reading = readings(finger)[column]
        slope = float(reading.gradient() @ finger.model.unknowns.owned_part(step))
        assert slope == pytest.approx(1e3 * unknown.scale, rel=1e-12)


def test_smallest_distances_have_no_derivative(finger: FingerModel) -> None:
    for column in ("contact_gap_mm", "plate_gap_mm"):
        reading = readings(finger)[column]
        assert not reading.differentiable
        with pytest.raises(NotDifferentiable, match=f"^{column} has no derivative"):
            reading.gradient()


def test_readings_count_from_rest_and_keep_their_derivatives(finger: FingerModel) -> None:
    observation = Observation(finger)
    observation.tare()
    angle, raw = (observation.readings[name] for name in ("angle_deg", "tip_x_mm"))
    assert angle.value() == raw.value() == 0
    plain = TipDisplacement(finger.model, "x")
    assert raw.zero == plain.value()  # type: ignore[attr-defined]
    np.testing.assert_array_equal(raw.gradient(), plain.gradient())


def test_tension() -> None:
    """The bar's force and width by a displacement of its nodes."""
    settings = config.load(None, assignments(["coupon.grip=clamped", "coupon.gauge_length_mm=6"]))
    rig = bar_rig.BarRig.built(settings, MPI.COMM_SELF, Profile())
    path = LoadPath(rig.newton, rig.longest())
    stop = Stop(1.5, 0.6, "loading")
    assert path.advance(rig.controls(stop)).failure is None
    model = rig.newton.model
    time, travel, force, width = rig.readings.values()
    assert (time.value(), travel.value()) == (0.6, 1.5)
    assert not time.gradient().any()
    assert not travel.gradient().any()
    direction = along_state(model, 0.2)
    slope = float(force.gradient() @ direction)
    assert taylor.rates(at_state(model, direction, force.value), slope, 0.1).min() > 1.9
    assert exact(at_state(model, direction, width.value), float(width.gradient() @ direction))
