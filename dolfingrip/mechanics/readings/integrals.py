"""Readings that are functions of integrals over a model."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.mechanics.model.assembly import integral, owned_vector
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading


class OfIntegrals(Reading):
    """g = f(I₁, I₂, …); the integrals I are UFL forms of the meshed part.

    Its derivatives are those of the one form Σ wₖ Iₖ with wₖ = ∂f/∂Iₖ. Forms are compiled when they
    are asked for.

    Args:
        model: model that is read.
        column: name in the table, with the unit.
        integrals: forms in the displacement, the coordinates and constants.
    """

    def __init__(self, model: Model, column: str, integrals: Sequence[ufl.Form]) -> None:
        super().__init__(model, column)
        self._integrals = integrals
        self._weights = [fem.Constant(model.domain.mesh, 0.0) for _ in integrals]
        parts = [weight * form for weight, form in zip(self._weights, integrals, strict=True)]
        self._weighed = sum(parts[1:], start=parts[0])
        test = ufl.TestFunction(model.u.function_space)
        self._by_displacement = ufl.derivative(self._weighed, model.u, test)
        self._by_constant: dict[fem.Constant, ufl.Form] = {}

    @abstractmethod
    def _function(self, integrals: np.ndarray) -> float:
        """The reading as a function of the integrals."""

    @abstractmethod
    def _slopes(self, integrals: np.ndarray) -> np.ndarray:
        """Derivatives of the reading by each integral."""

    def value(self) -> float:
        return float(self._function(self._values()))

    def _values(self) -> np.ndarray:
        return np.array([integral(form) for form in self._integrals])

    # -- derivatives -----------------------------------------------------------------------------

    def add_gradient(self, gradient: Gradient) -> None:
        self._weigh()
        gradient.fields[0][:] = owned_vector(self._by_displacement)
        for unknown in self.model.unknowns.global_unknowns:
            gradient.add(unknown, self._to_constant(unknown.constant))

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        self._weigh()
        gradient.add_form(self._weighed)

    def _weigh(self) -> None:
        for weight, slope in zip(self._weights, self._slopes(self._values()), strict=True):
            weight.value = slope

    def _to_constant(self, constant: fem.Constant) -> float:
        """Derivative by a constant; 0 if the integrals do not contain it."""
        if constant not in self._weighed.constants():
            return 0.0
        if constant not in self._by_constant:
            mark = ufl.variable(constant)
            marked = ufl.replace(self._weighed, {constant: mark})
            self._by_constant[constant] = ufl.diff(marked, mark)
        return integral(self._by_constant[constant])


class Integral(OfIntegrals):
    """An integral over the whole solid, such as a cavity's volume or a plate's force.

    Args:
        model: model that is read.
        column: name in the table, with the unit.
        integral: form over the meshed part.
    """

    def __init__(self, model: Model, column: str, integral: ufl.Form) -> None:
        super().__init__(model, column, [integral])

    def _function(self, integrals: np.ndarray) -> float:
        return float(self.model.domain.copies * integrals[0])

    def _slopes(self, integrals: np.ndarray) -> np.ndarray:
        return np.array([float(self.model.domain.copies)])


class Reaction(Integral):
    """Sum of the supports' forces on some nodes along an axis (N), for the whole solid.

    It is the residual R(u; w) with the test function w = 1 at these nodes, and so it has that
    form's derivatives; further terms of Π must not act on these nodes.

    Args:
        model: model that is read.
        column: name in the table.
        nodes: this rank's owned displacement nodes.
        axis: 0, 1 or 2.
    """

    def __init__(self, model: Model, column: str, nodes: np.ndarray, axis: int) -> None:
        chosen = fem.Function(model.u.function_space)
        chosen.x.array[3 * nodes + axis] = 1.0
        chosen.x.scatter_forward()
        super().__init__(model, column, ufl.action(model.potential.gradient, chosen))
        self._nodes, self._axis = nodes, axis

    def value(self) -> float:
        local = float(self.model.reactions()[self._nodes, self._axis].sum())
        return float(self.model.domain.copies * self.model.comm.allreduce(local, MPI.SUM))
