"""How an output of a solved model changes with its parameters: the adjoint method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import ufl
from dolfinx import fem, la
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.tangent import Tangent


@dataclass(frozen=True, slots=True)
class Direction:
    """What changes with a parameter, and how fast.

    Attributes:
        velocity: of the points of the reference configuration (mm for each unit of the
            parameter), a piecewise linear vector; None where they stay.
        rates: constants of the potential with their rates.
    """

    velocity: fem.Function | None = None
    rates: Sequence[tuple[fem.Constant, float]] = ()


class Output(Protocol):
    """What is read off a model and is no form; of all derivatives this rank's part."""

    def by_displacement(self, dofs: np.ndarray) -> np.ndarray:
        """By the owned displacements, in the order of a vector."""
        ...

    def by_shape(self, dofs: np.ndarray, velocity: np.ndarray) -> float:
        """As reference points move with a velocity of the displacement's nodes."""
        ...

    def by_constant(self, dofs: np.ndarray, constant: fem.Constant) -> float:
        """By a constant; 0 where it has none such."""
        ...


class Adjoint:
    """Derivatives of one output of a model at its present state, which must be a solution.

    With R(u, m) = ∂Π/∂u = 0 and an output g(u, m) the derivative to any parameter m is
    ∂g/∂m − λ·∂R/∂m, Kλ = ∂g/∂u: one linear solve with the tangent, however many parameters.
    Partial derivatives to the shape move the mesh and keep the nodal displacements (Ham,
    Mitchell, Paganini & Wechsung, Struct. Multidisc. Optim. 60, 2019).

    Args:
        model: led by its constants (pressure rather than volume).
        output: the meshed part's share of g, as a UFL form or with its own derivatives.
    """

    def __init__(self, model: Model, output: ufl.Form | Output) -> None:
        self._model = model
        space = model.u.function_space
        self._adjoint = fem.Function(space)
        self._lagrangian = -ufl.action(model.potential.gradient, self._adjoint)
        self._output: Output | None = None
        if isinstance(output, ufl.Form):
            self._lagrangian = output + self._lagrangian
            slope = ufl.derivative(output, model.u, ufl.TestFunction(space))
            vector = fem.assemble_vector(fem.form(slope, jit_options=jit.options()))
            vector.scatter_reverse(la.InsertMode.add)
            right = vector.array[: space.dofmap.index_map.size_local * space.dofmap.index_map_bs]
        else:
            self._output = output
            right = output.by_displacement(model.u.x.array)
        self._solve(right)
        self._moving: tuple[fem.Function, fem.Form] | None = None

    def _solve(self, right: np.ndarray) -> None:
        """λ from ∂g/∂u, the owned dofs'."""
        model = self._model
        if model.potential.carried is not None:
            model.potential.carried.reset()
        tangent = Tangent(model)  # of its own: Newton's may not change under it
        tangent.assemble()
        load = model.unknowns.create_vector()
        load.array[:] = right
        for bc in model.supports:
            dofs, owned = bc.dof_indices()
            load.array[dofs[:owned]] = 0.0
        ksp = PETSc.KSP().create(model.comm)
        ksp.setOperators(tangent.matrix)
        ksp.setType(PETSc.KSP.Type.PREONLY)
        ksp.getPC().setType(PETSc.PC.Type.CHOLESKY)
        ksp.getPC().setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        solution = load.duplicate()
        ksp.solve(load, solution)
        self._adjoint.x.array[: solution.getLocalSize()] = solution.array_r
        self._adjoint.x.scatter_forward()
        for each in (ksp, load, solution, tangent.matrix):
            each.destroy()

    def derivative(self, direction: Direction) -> float:
        """dg/dm along a direction, in the output's unit for each unit of the parameter."""
        local = 0.0
        if direction.velocity is not None:
            local += self._to_shape(direction.velocity)
        for constant, rate in direction.rates:
            local += rate * self._to_constant(constant)
        found = self._model.comm.allreduce(local, MPI.SUM)
        return float(self._model.domain.copies * found)

    def _to_shape(self, velocity: fem.Function) -> float:
        if self._moving is None:
            field = fem.Function(velocity.function_space)
            x = ufl.SpatialCoordinate(self._model.domain.mesh)
            form = ufl.derivative(self._lagrangian, x, field)
            self._moving = field, fem.form(form, jit_options=jit.options())
        field, compiled = self._moving
        field.x.array[:] = velocity.x.array
        model = self._model
        dofs, moving = model.u.x.array, fem.Function(model.u.function_space)
        moving.interpolate(velocity)
        rates = Gradient(model.unknowns)
        for term in model.terms:
            term.add_gradient_rate(dofs, moving.x.array, rates)
        found = float(fem.assemble_scalar(compiled)) - self._through(rates)
        return found + (self._output.by_shape(dofs, moving.x.array) if self._output else 0.0)

    def _to_constant(self, constant: fem.Constant) -> float:
        dofs = self._model.u.x.array
        rates = Gradient(self._model.unknowns)
        for term in self._model.terms:
            term.add_constant_rate(dofs, constant, rates)
        found = self._form_to_constant(constant) - self._through(rates)
        return found + (self._output.by_constant(dofs, constant) if self._output else 0.0)

    def _form_to_constant(self, constant: fem.Constant) -> float:
        if constant not in self._lagrangian.constants():
            return 0.0
        # UFL derives by functions only: a piecewise constant one takes the constant's place
        space = fem.functionspace(self._model.domain.mesh, ("DG", 0))
        value, change = fem.Function(space), fem.Function(space)
        value.x.array[:], change.x.array[:] = constant.value, 1.0
        form = ufl.derivative(ufl.replace(self._lagrangian, {constant: value}), value, change)
        return float(fem.assemble_scalar(fem.form(form, jit_options=jit.options())))

    def _through(self, rates: Gradient) -> float:
        """λ·∂R/∂m of the terms beside the potential, this rank's part."""
        return float(self._adjoint.x.array[: rates.fields[0].size] @ rates.fields[0])
