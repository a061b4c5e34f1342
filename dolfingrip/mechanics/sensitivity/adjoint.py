"""Derivatives of a solved model's reading by its parameters: the adjoint method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.shape_gradient import Coordinates, ShapeGradient
from dolfingrip.mechanics.model.term import NoShapeGradient
from dolfingrip.mechanics.readings.reading import Reading
from dolfingrip.mechanics.sensitivity.repeated_step import Perturbation, RepeatedStep

CHANGE: Final = 1e-5
"""Part of a parameter's scale by which it is changed. Differences are of second order, and of two
points on one side, since some parameters allow smaller values only."""

ALONG_MM: Final = 1e-5
"""Largest motion of a node along the adjoint state for the derivative by all coordinates, a central
difference. It is small against the distances of contact; ten times smaller, rounding of the
contact's part is 1e-5 of a force's derivative."""


class HasHistory(Exception):
    """The adjoint was asked for at a state that remembers earlier ones."""


@dataclass(frozen=True, slots=True)
class ShapeDerivative:
    """Derivatives of a number by all coordinates of a mesh.

    Attributes:
        coordinates: of the mesh.
        owned: (k, 3) by the points that this rank owns, in the number's unit for each mm.
    """

    coordinates: Coordinates
    owned: np.ndarray

    def along(self, velocity: np.ndarray) -> float:
        """Derivative for a velocity (m, 3) of all points that this rank knows."""
        local = float(np.vdot(self.owned, self.coordinates.owned_part(velocity)))
        return float(self.coordinates.comm.allreduce(local, MPI.SUM))

    def plus(self, other: ShapeDerivative, factor: float = 1.0) -> ShapeDerivative:
        """The sum with ``factor`` times another number's derivatives."""
        return ShapeDerivative(self.coordinates, self.owned + factor * other.owned)


class Adjoint:
    """Derivatives of one reading of a model at its present state, which must be a solution.

    With R(x, m) = 0 and a reading g(x, m) the derivative by any parameter m is

        dg/dm = ∂g/∂m − λ·∂R/∂m,    K λ = ∂g/∂x

    one linear solve with the tangent, however many parameters. The partial derivatives by a single
    m are those of forward mode: differences of R and of g under the same perturbations, so that
    every term and control takes part and none is named here. Those by all coordinates of the mesh
    are one assembled vector, :meth:`by_coordinates`. A state with a history would need the adjoints
    of all steps before.

    Args:
        model: at a solution.
        linear: makes K⁻¹ at the model's present state, for owned arrays in the order of a vector.
        reading: g.

    Raises:
        HasHistory: one line, where internal variables or lagged quantities remember earlier states.
    """

    def __init__(
        self,
        model: Model,
        linear: Callable[[], Callable[[np.ndarray], np.ndarray]],
        reading: Reading,
    ) -> None:
        self._model = model
        self._reading = reading
        self._state = model.state()
        if self._state.history:
            names = ", ".join(self._state.history)
            raise HasHistory(f"{reading.column}: no adjoint with what the state remembers: {names}")
        self._step = RepeatedStep(model, self._state, self._state, model.unknowns.local(), None)
        slope = reading.gradient()
        solved = model.free
        solved[model.dependent_dofs] = 1.0
        self._adjoint = linear()(solved * slope)
        self._start = self._step.at_end(self._both)
        model.restore(self._state)

    def _both(self) -> tuple[np.ndarray, float]:
        """Residual (N) and reading at the model's state."""
        return self._model.gradient(), self._reading.value()

    def derivative(self, perturbation: Perturbation) -> float:
        """dg/dm, in the reading's unit for each unit of the parameter."""
        amount = CHANGE * perturbation.scale * perturbation.direction
        once, twice = (self._change(perturbation, size) for size in (amount, 2 * amount))
        return (4 * once - twice) / (2 * amount)

    def by_coordinates(self, coordinates: Coordinates) -> ShapeDerivative:
        """dg/dX by all coordinates of the reference mesh, while all other parameters stay.

        R = ∂Π/∂x, so λ·∂R/∂X is the derivative of ∂Π/∂X along λ. It is a central difference of
        vectors that each term assembles once.

        Args:
            coordinates: of the model's mesh.

        Raises:
            NoShapeGradient: one line, where a term or the reading has no such derivative.
        """
        model = self._model
        if model.constraint is not None:
            raise NoShapeGradient("a clamp that moves: no derivative by coordinates")
        explicit = ShapeGradient(coordinates)
        self._reading.add_shape_gradient(explicit)
        here, along = model.unknowns.local(), model.unknowns.to_local(self._adjoint)
        largest = model.comm.allreduce(float(np.abs(along).max(initial=0.0)), MPI.MAX)
        if largest == 0:
            return ShapeDerivative(coordinates, explicit.owned)
        amount = ALONG_MM / largest
        ends = []
        for sign in (1, -1):
            model.unknowns.set_local(here + sign * amount * along)
            gradient = ShapeGradient(coordinates)
            for term in model.all_terms:
                term.add_shape_gradient(model.u.x.array, gradient)
            ends.append(gradient.owned)
        model.restore(self._state)
        return ShapeDerivative(coordinates, explicit.owned - (ends[0] - ends[1]) / (2 * amount))

    def _change(self, perturbation: Perturbation, amount: float) -> float:
        """Change of g − λ·R as the parameter changes by ``amount`` and the unknowns do not."""
        residual, value = self._step.at_end(self._both, perturbation, None, amount)
        self._model.restore(self._state)
        local = float(self._adjoint @ (residual - self._start[0]))
        return value - self._start[1] - float(self._model.comm.allreduce(local, MPI.SUM))
