"""Derivatives by the adjoint against central differences of whole simulations.

The differences of solutions converged to 1e-12 have an error of some 1e-8: their step is 1e-4,
and the outputs bend by about themselves over ξ = 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from mpi4py import MPI
from support.small import model, pressurise, short

from dolfingrip.config import KPA
from dolfingrip.experiments.derivatives import gradients
from dolfingrip.experiments.derivatives.adjoints import FingerAdjoints
from dolfingrip.experiments.loop import follow
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.perturbation import Movement, perturbations
from dolfingrip.mechanics.model.model import Control, Prescribed
from dolfingrip.mechanics.newton.ending import Ending
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.volume_control import CONTROL
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.mechanics.readings.plate import PlateForce, PlatePlace
from dolfingrip.mechanics.readings.reading import FromRest
from dolfingrip.mechanics.readings.tip import FaceAngle
from dolfingrip.mechanics.sensitivity.adjoint import Adjoint, HasHistory
from dolfingrip.mechanics.sensitivity.forward import ForwardSensitivity
from dolfingrip.meshes.measures import centroid_gradients
from dolfingrip.parameter import Entry, every, find

STEP = 1e-4
AT = {"xi1": 0.1, "xi2": -0.1}
NEAR_mm = 1e-6
"""Step of the differences by coordinates. Solutions to 1e-12 leave them 1e-7."""

TOUCHING = ("finger.gap_mm=0.3", "plate.tilt_deg=10")


def unpressurised(*overrides: str, plate: bool, **xi: float) -> FingerModel:
    """A short, morphed finger."""
    moved = [f"morph.{name}={value!r}" for name, value in {**AT, **xi}.items()]
    return model(short("solver.rtol=1e-12", *moved, *overrides), plate=plate)


def solved(pressure_kPa: float, *overrides: str, plate: bool, **xi: float) -> FingerModel:
    """The same, pressurised."""
    finger = unpressurised(*overrides, plate=plate, **xi)
    list(pressurise(finger, [pressure_kPa]))
    return finger


def slope(function: Callable[[float], float], at: float, step: float = STEP) -> float:
    return (function(at + step) - function(at - step)) / (2 * step)


def to_morph(finger: FingerModel) -> dict[str, float]:
    """Derivative of force (N) or angle (deg) by each ξ at the finger's present solution."""
    model, plate = finger.model, finger.plate
    reading = FromRest(FaceAngle(model)) if plate is None else PlateForce(model, plate)
    adjoints, parameters = FingerAdjoints(finger, [reading]), find(finger.config, gradients.XI)
    return adjoints.by_parameters(finger.config, parameters)[reading.column]


def force_N(finger: FingerModel) -> float:
    assert finger.plate is not None
    return finger.plate.force_N()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pressure_kPa", "overrides"),
    [(25.0, ["contact.self_contact=false"]), (150.0, TOUCHING)],
    ids=["free", "touching"],
)
def test_blocked_force(pressure_kPa: float, overrides: list[str]) -> None:
    finger = solved(pressure_kPa, *overrides, plate=True)
    contact = finger.contact
    if contact is not None:
        forces = contact.gradient(finger.model.u.x.array)
        assert np.linalg.norm(forces, axis=1).max() > 0.01  # N: the bellows do touch
    found = to_morph(finger)
    for name, value in AT.items():

        def force(xi: float, name: str = name) -> float:
            return force_N(solved(pressure_kPa, *overrides, plate=True, **{name: xi}))

        expected = slope(force, value)
        print(name, "adjoint", found[f"morph.{name}"], "differences", expected)
        assert found[f"morph.{name}"] == pytest.approx(expected, rel=1e-6)


class Raised:
    """The pressure as a parameter: all that is prescribed is this much more."""

    scale, direction = 1.0, 1.0

    def __init__(self, finger: FingerModel, pressure_kPa: float) -> None:
        self._controls: dict[str, Prescribed] = finger.model.controls
        self._pressure_kPa = pressure_kPa
        self._constant = finger.cavity.constant

    @contextmanager
    def applied(self, amount: float) -> Iterator[None]:
        kept = self._controls["pressure_kPa"]
        factor = KPA * (1 + amount / self._pressure_kPa)
        self._controls["pressure_kPa"] = Control(self._constant, factor)
        yield
        self._controls["pressure_kPa"] = kept


def test_the_plates_gap_and_the_pressure() -> None:
    def force(pressure_kPa: float, gap_mm: float) -> float:
        return force_N(solved(pressure_kPa, f"plate.gap_mm={gap_mm!r}", plate=True))

    finger = solved(25.0, "plate.gap_mm=0.5", plate=True)
    assert finger.plate is not None
    linear = Newton(finger.model, finger.config.solver).linear
    adjoint = Adjoint(finger.model, linear, PlateForce(finger.model, finger.plate))
    (gap,) = perturbations(find(finger.config, ["plate.gap_mm"]), finger.config, finger)
    by_pressure = adjoint.derivative(Raised(finger, 25.0))
    assert by_pressure == pytest.approx(slope(lambda p: force(p, 0.5), 25.0, 1e-2), rel=1e-6)
    expected = slope(lambda g: force(25.0, g), 0.5)
    assert adjoint.derivative(gap) == pytest.approx(expected, rel=1e-6)


def test_any_parameter_control_and_term_that_forward_mode_knows() -> None:
    """Under volume control, on a compliant clamp, against a compliant plate: a saddle point.

    Forward mode is good to 1e-5 of the parameters' scales.
    """
    finger = unpressurised(
        "experiment.control=volume", "extensions.clamp_compliance={}", "plate.gap_mm=0.1",
        "extensions.plate_compliance={}", "extensions.gent={}", plate=True,
    )  # fmt: skip
    model, plate = finger.model, finger.plate
    assert plate is not None
    control = model.controls[CONTROL]
    path = LoadPath(Newton(model, finger.config.solver), {CONTROL: 0.05 * control.value})
    assert path.advance({CONTROL: 1.1 * control.value}).failure is None
    parameters = [
        each for each in every(finger.config) if each.entry in (Entry.CONSTANT, Entry.SHAPE)
    ]
    reading = PlateForce(model, plate)
    assert reading.value() > 0.1
    each = perturbations(parameters, finger.config, finger)
    linear = Newton(model, finger.config.solver).linear
    forward = ForwardSensitivity(model, linear, each).readings(lambda: {"force": reading.value()})
    adjoint = Adjoint(model, linear, reading)
    found = [adjoint.derivative(one) for one in each]
    scales = [parameter.scale for parameter in parameters]
    expected = np.array([one["force"] for one in forward]) * scales
    assert len(expected) > 8
    np.testing.assert_allclose(
        found * np.array(scales), expected, rtol=0, atol=1e-5 * abs(expected).max()
    )


@pytest.mark.parametrize("control", ["pressure", "volume"])
def test_force_and_angle_by_all_coordinates(control: str) -> None:
    """In random directions, bellows and plate touching; the plate stays where it stands.

    Pairs of edges that come and go bend the solutions: with steps ten times as long, differences
    are off by 1e-4.
    """
    finger = unpressurised(
        *TOUCHING, "solver.atol_N=1e-11", f"experiment.control={control}", plate=True
    )
    model = finger.model
    observation = Observation(finger)
    if control == "pressure":
        list(pressurise(finger, [150.0]))
    else:
        _inflate(finger, 1.35)
    contact = finger.contact
    assert contact is not None
    forces = contact.gradient(model.u.x.array)
    assert np.linalg.norm(forces, axis=1).max() > 0.01  # N: the bellows do touch
    names = ("force_N", "angle_deg", "tip_x_mm", "chord_angle_deg", "cavity_volume_mm3")
    if control == "volume":
        names = (*names[:-1], "pressure_kPa")
    readings = [observation.readings[name] for name in names]
    found = FingerAdjoints(finger, readings).by_coordinates
    assert finger.plate is not None
    place = PlatePlace(model, finger.plate)
    points, start = model.domain.mesh.geometry.x, model.state()
    newton = Newton(model, finger.config.solver)
    random = np.random.default_rng(33)
    largest = 0.0
    for _ in range(20 if control == "pressure" else 3):
        moving = random.uniform(-1, 1, points.shape)
        moving[points[:, 1] < 1e-9, 1] = 0.0  # the plane of symmetry stays one
        # the edge nearest to the plate stays: its nodes are equally near
        moving[points[:, 0] < 1e-9] = 0.0
        movement = Movement(model, moving, finger.site.geometric)
        ends = []
        for step in (NEAR_mm, -NEAR_mm):
            model.restore(start)
            movement.move(step)
            model.u.x.array[:] = 0.0
            observation.tare()
            stands = place.value()
            model.restore(start)
            assert newton.solve().ending is Ending.CONVERGED
            ends.append([reading.value() for reading in readings])
            assert stands == pytest.approx(float(finger.plate.offset.value), abs=1e-12)
        movement.move(0.0)
        expected = np.subtract(*ends) / (2 * NEAR_mm)
        slopes = np.array([found[name].along(moving) for name in names])
        sizes = [np.linalg.norm(found[name].owned) for name in names]
        largest = max(largest, float(np.abs((slopes - expected) / sizes).max()))
    print("largest error, as part of the derivative's size", largest)
    assert largest < 1e-6


def _inflate(finger: FingerModel, ratio: float) -> None:
    control = finger.model.controls[CONTROL]
    path = LoadPath(Newton(finger.model, finger.config.solver), {CONTROL: 0.05 * control.value})
    assert path.advance({CONTROL: ratio * control.value}).failure is None


def test_every_dimension_by_the_chain_rule() -> None:
    """The vector by all coordinates along each parameter's motion, against its differences."""
    finger = solved(150.0, *TOUCHING, plate=True)
    parameters = [each for each in every(finger.config) if each.entry is Entry.SHAPE]
    assert len(parameters) > 6
    reading = Observation(finger).readings["force_N"]
    adjoints = FingerAdjoints(finger, [reading])
    found = adjoints.by_parameters(finger.config, parameters)["force_N"]
    linear = Newton(finger.model, finger.config.solver).linear
    alone = Adjoint(finger.model, linear, reading)
    expected = {
        each.parameter.key: alone.derivative(each)
        for each in perturbations(parameters, finger.config, finger)
    }
    scale = max(abs(found[each.key] * each.scale) for each in parameters)
    for each in parameters:
        apart = abs(found[each.key] - expected[each.key]) * each.scale
        assert apart < 1e-5 * scale, each.key


def test_a_state_that_remembers_has_no_adjoint() -> None:
    finger = unpressurised("extensions.plate_friction={}", plate=True)
    assert finger.plate is not None
    linear = Newton(finger.model, finger.config.solver).linear
    with pytest.raises(HasHistory, match=r"^force_N: no adjoint .*friction"):
        Adjoint(finger.model, linear, PlateForce(finger.model, finger.plate))


def test_angle_of_the_free_tip() -> None:
    def angle_deg(xi2: float) -> float:
        finger = unpressurised(plate=False, xi2=xi2)
        observation = Observation(finger)  # which takes its zero from rest
        list(pressurise(finger, [25.0]))
        return observation.read()["angle_deg"]

    found = to_morph(solved(25.0, plate=False))
    assert found["morph.xi2"] == pytest.approx(slope(angle_deg, AT["xi2"]), rel=1e-6)


@pytest.mark.parametrize("name", ["xi1", "xi2"])
def test_centre_of_gravity(name: str) -> None:
    """The centroid is a quotient of cubics in ξ, so these differences are good to 1e-7."""

    def offset(xi: float) -> float:
        return gradients.shape_number(gradients.COG, short(f"morph.{name}={xi!r}"))[0]

    found = gradients.shape_number(gradients.COG, short(f"morph.{name}=0.2"))[1]
    assert found[f"morph.{name}"] == pytest.approx(slope(offset, 0.2), rel=1e-6)


def test_centroid_follows_a_translation() -> None:
    mesh = gradients.solid(short())
    rate = centroid_gradients(mesh).sum(axis=1) @ [1.0, 2.0, 3.0]
    np.testing.assert_allclose(rate, [1.0, 2.0, 3.0], rtol=1e-12)


@pytest.mark.parametrize(
    ("kind", "column"), [("bending", "angle_deg"), ("blocked_force", "force_N")]
)
def test_under_gravity_the_zero_and_the_plate_follow_the_sag(kind: str, column: str) -> None:
    """Heavy enough for the sag to be seen: without it the derivatives are a fifth off, or more."""
    heavy = (
        "gravity.acceleration_m_s2=98.1", "gravity.direction=[-0.8, 0, 0.6]",
        "plate.gap_mm=0.1", "experiment.max_pressure_kPa=25", "experiment.step_kPa=25",
        "solver.rtol=1e-12", "contact.self_contact=false",
    )  # fmt: skip

    def reading(xi2: float, found: dict[str, float] | None = None) -> float:
        moved = [f"morph.xi1={AT['xi1']!r}", f"morph.xi2={xi2!r}"]
        asked = Request.of(
            kind, short(*moved, *heavy), gradients.XI, at_highest=True, columns=(column,)
        )
        result = follow(asked, MPI.COMM_WORLD)
        if found is not None:
            found |= {each["parameter"]: each["derivative"] for each in result.sensitivities}
        return float(result.column(column)[-1])

    found: dict[str, float] = {}
    reading(AT["xi2"], found)
    assert found["morph.xi2"] == pytest.approx(slope(reading, AT["xi2"]), rel=1e-6)
