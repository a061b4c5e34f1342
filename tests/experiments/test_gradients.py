"""Derivatives by the adjoint against central differences of whole simulations.

The differences of solutions converged to 1e-12 have an error of some 1e-8: their step is 1e-4,
and the outputs bend by about themselves over ξ = 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from experiments.small import model, pressurise, short

from dolfingrip.experiments import run
from dolfingrip.experiments.derivatives import gradients
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.mechanics.model.direction import Direction
from dolfingrip.mechanics.readings.plate import PlateForce
from dolfingrip.mechanics.sensitivity.adjoint import Adjoint
from dolfingrip.meshes.measures import centroid_rate

STEP = 1e-4
AT = {"xi1": 0.1, "xi2": -0.1}
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


def force_N(finger: FingerModel) -> float:
    assert finger.plate is not None
    return finger.plate.force_N()


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
    found = gradients.to_morph(finger)
    for name, value in AT.items():

        def force(xi: float, name: str = name) -> float:
            return force_N(solved(pressure_kPa, *overrides, plate=True, **{name: xi}))

        expected = slope(force, value)
        print(name, "adjoint", found[f"morph.{name}"], "differences", expected)
        assert found[f"morph.{name}"] == pytest.approx(expected, rel=1e-6)


def test_constants_of_the_potential() -> None:
    """The force's derivative to the pressure, and to the place of the plate."""

    def force(pressure_kPa: float, gap_mm: float) -> float:
        return force_N(solved(pressure_kPa, f"plate.gap_mm={gap_mm!r}", plate=True))

    finger = solved(25.0, "plate.gap_mm=0.5", plate=True)
    assert finger.plate is not None
    adjoint = Adjoint(finger.model, PlateForce(finger.model, finger.plate))
    pressure = finger.model.controls["pressure_kPa"].constant  # type: ignore[attr-defined]
    by_pressure = adjoint.derivative(Direction(rates=[(pressure, 1e-3)]))
    by_gap = adjoint.derivative(Direction(rates=[(finger.plate.offset, -1.0)]))
    assert by_pressure == pytest.approx(slope(lambda p: force(p, 0.5), 25.0, 1e-2), rel=1e-6)
    assert by_gap == pytest.approx(slope(lambda g: force(25.0, g), 0.5), rel=1e-6)
    both = Direction(rates=[(pressure, 1e-3), (finger.plate.offset, -2.0)])
    assert adjoint.derivative(both) == pytest.approx(by_pressure + 2 * by_gap, rel=1e-12)


def test_angle_of_the_free_tip() -> None:
    def angle_deg(xi2: float) -> float:
        finger = unpressurised(plate=False, xi2=xi2)
        observation = Observation(finger)  # which takes its zero from rest
        list(pressurise(finger, [25.0]))
        return observation.read()["angle_deg"]

    found = gradients.to_morph(solved(25.0, plate=False))
    assert found["morph.xi2"] == pytest.approx(slope(angle_deg, AT["xi2"]), rel=1e-6)


@pytest.mark.parametrize("name", ["xi1", "xi2"])
def test_centre_of_gravity(name: str) -> None:
    """The centroid is a quotient of cubics in ξ, so these differences are good to 1e-7."""

    def offset(xi: float) -> float:
        return gradients.cog_offset_mm(short(f"morph.{name}={xi!r}"))[0]

    found = gradients.cog_offset_mm(short(f"morph.{name}=0.2"))[1]
    assert found[f"morph.{name}"] == pytest.approx(slope(offset, 0.2), rel=1e-6)


def test_centroid_follows_a_translation() -> None:
    mesh = gradients.solid(short())
    rate = centroid_rate(mesh, np.tile([1.0, 2.0, 3.0], (len(mesh.points), 1)))
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
        visit = gradients.at_highest({} if found is None else found)
        result = run(kind, short(*moved, *heavy), visit=visit)
        return float(result.column(column)[-1])

    found: dict[str, float] = {}
    reading(AT["xi2"], found)
    assert found["morph.xi2"] == pytest.approx(slope(reading, AT["xi2"]), rel=1e-6)
