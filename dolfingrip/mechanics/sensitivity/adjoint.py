"""Derivatives of a solved model's reading by its parameters: the adjoint method."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.direction import Direction
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.tangent import Tangent
from dolfingrip.mechanics.readings.reading import Reading


class Adjoint:
    """Derivatives of one reading of a model at its present state, which must be a solution.

    With R(u, m) = ∂Π/∂u = 0 and a reading g(u, m) the derivative by any parameter m is
    ∂g/∂m − λ·∂R/∂m, Kλ = ∂g/∂u: one linear solve with the tangent, however many parameters.
    Partial derivatives by the shape move the mesh and keep the nodal displacements (Ham,
    Mitchell, Paganini & Wechsung, Struct. Multidisc. Optim. 60, 2019).

    Args:
        model: model whose controls are constants of the potential: the pressure, not the volume.
        reading: the reading g.
    """

    def __init__(self, model: Model, reading: Reading) -> None:
        self._model = model
        self._reading = reading
        space = model.u.function_space
        self._adjoint = fem.Function(space)
        self._work = ufl.action(model.potential.gradient, self._adjoint)
        self._solve(reading.gradient())
        self._moving: tuple[fem.Function, fem.Form] | None = None

    def _solve(self, right: np.ndarray) -> None:
        model = self._model
        model.carried.reset()
        tangent = Tangent(model)  # not Newton's, which must not change
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
        """dg/dm along a direction, in the reading's unit for each unit of the parameter."""
        model = self._model
        local, rates = 0.0, Gradient(model.unknowns)
        if direction.velocity is not None:
            local += self._to_shape(direction.velocity)
            moving = fem.Function(model.u.function_space)
            moving.interpolate(direction.velocity)
            for term in model.terms:
                term.add_gradient_rate(model.u.x.array, moving.x.array, rates)
        for constant, rate in direction.rates:
            local += rate * self._to_constant(constant)
            by_constant = Gradient(model.unknowns)
            for term in model.terms:
                term.add_constant_rate(model.u.x.array, constant, by_constant)
            rates.array += rate * by_constant.array
        local += float(self._adjoint.x.array[: rates.fields[0].size] @ rates.fields[0])
        return self._reading.by_direction(direction) - float(model.comm.allreduce(local, MPI.SUM))

    def _to_shape(self, velocity: fem.Function) -> float:
        """This rank's part of λ·∂R/∂m of the forms for a motion of the mesh."""
        if self._moving is None:
            field = fem.Function(velocity.function_space)
            x = ufl.SpatialCoordinate(self._model.domain.mesh)
            form = ufl.derivative(self._work, x, field)
            self._moving = field, fem.form(form, jit_options=jit.options())
        field, compiled = self._moving
        field.x.array[:] = velocity.x.array
        return float(fem.assemble_scalar(compiled))

    def _to_constant(self, constant: fem.Constant) -> float:
        """This rank's part of λ·∂R/∂m of the forms; 0 for a constant that they do not contain."""
        if constant not in self._work.constants():
            return 0.0
        # UFL derives only by functions, so a piecewise constant one replaces the constant
        space = fem.functionspace(self._model.domain.mesh, ("DG", 0))
        value, change = fem.Function(space), fem.Function(space)
        value.x.array[:], change.x.array[:] = constant.value, 1.0
        form = ufl.derivative(ufl.replace(self._work, {constant: value}), value, change)
        return float(fem.assemble_scalar(fem.form(form, jit_options=jit.options())))
