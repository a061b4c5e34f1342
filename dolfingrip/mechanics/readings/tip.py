"""Camera readings of the tip: its face's angle, its displacement, the chord from the clamp."""

from __future__ import annotations

import math

import numpy as np
import ufl
from dolfinx import fem

from dolfingrip.channels import ANGLE, CHORD_ANGLE
from dolfingrip.forms import tip_face
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.readings.integrals import OfIntegrals

AXIS = {"x": 0, "y": 1, "z": 2}


def _face(model: Model) -> ufl.Measure:
    return model.domain.surface(
        "tip", quadrature_degree=2 * model.u.function_space.ufl_element().degree
    )


def _one(model: Model) -> fem.Constant:
    return fem.Constant(model.domain.mesh, 1.0)


def angle_deg(x: float, z: float) -> float:
    """Angle (deg) from z towards −x, which is towards a finger's base layer."""
    return math.degrees(math.atan2(-x, z))


def angle_slopes(x: float, z: float) -> np.ndarray:
    """Derivatives of the angle (deg) by x and z."""
    return math.degrees(1.0) / (x**2 + z**2) * np.array([-z, x])


class FaceAngle(OfIntegrals):
    """Rotation of the tip face's area vector about y (deg), positive towards −x."""

    def __init__(self, model: Model) -> None:
        vector, tip = tip_face.area_vector(model.u, model.domain.mesh), _face(model)
        super().__init__(model, ANGLE.name, [vector[0] * tip, vector[2] * tip])

    def _function(self, integrals: np.ndarray) -> float:
        return angle_deg(*integrals)

    def _slopes(self, integrals: np.ndarray) -> np.ndarray:
        return angle_slopes(*integrals)


class TipDisplacement(OfIntegrals):
    """Mean displacement of the tip face along an axis from the undeformed mesh (mm).

    Args:
        model: model that is read.
        axis: ``x``, ``y`` or ``z``.
    """

    def __init__(self, model: Model, axis: str) -> None:
        tip = _face(model)
        integrals = [model.u[AXIS[axis]] * tip, _one(model) * tip]
        super().__init__(model, f"tip_{axis}_mm", integrals)

    def _function(self, integrals: np.ndarray) -> float:
        moved, area = integrals
        return float(moved / area)

    def _slopes(self, integrals: np.ndarray) -> np.ndarray:
        moved, area = integrals
        return np.array([1 / area, -moved / area**2])


class ChordAngle(OfIntegrals):
    """Rotation about y of the line from the clamp's undeformed centre to the tip face's (deg)."""

    def __init__(self, model: Model, column: str = CHORD_ANGLE.name) -> None:
        u, x = model.u, ufl.SpatialCoordinate(model.domain.mesh)
        tip, clamp = _face(model), model.domain.surface("clamp", quadrature_degree=1)
        integrals = [form for i in (0, 2) for form in (u[i] * tip, x[i] * tip, x[i] * clamp)]
        integrals += [_one(model) * tip, _one(model) * clamp]
        super().__init__(model, column, integrals)

    def _arm(self, integrals: np.ndarray) -> np.ndarray:
        moved_x, tip_x, clamp_x, moved_z, tip_z, clamp_z, tip, clamp = integrals
        return np.array(
            [
                tip_x / tip - clamp_x / clamp + moved_x / tip,
                tip_z / tip - clamp_z / clamp + moved_z / tip,
            ]
        )

    def _function(self, integrals: np.ndarray) -> float:
        return angle_deg(*self._arm(integrals))

    def _slopes(self, integrals: np.ndarray) -> np.ndarray:
        moved_x, tip_x, clamp_x, moved_z, tip_z, clamp_z, tip, clamp = integrals
        by_x, by_z = angle_slopes(*self._arm(integrals))
        by_tip = -(by_x * (moved_x + tip_x) + by_z * (moved_z + tip_z)) / tip**2
        by_clamp = (by_x * clamp_x + by_z * clamp_z) / clamp**2
        per_axis = np.array([1 / tip, 1 / tip, -1 / clamp])
        return np.array([*(by_x * per_axis), *(by_z * per_axis), by_tip, by_clamp])
