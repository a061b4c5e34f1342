"""Which linear solver a model's tangent has, and the memory that it will need."""

from __future__ import annotations

from functools import cached_property
from typing import Final

import scipy.sparse as sp

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.bordered import factors, has_cholesky
from dolfingrip.mechanics.newton.cholmod import elimination
from dolfingrip.mechanics.newton.inverse import (
    AUTOMATIC,
    Exact,
    Factorisation,
    Inverse,
    Order,
    cheapest,
)
from dolfingrip.mechanics.newton.memory import MB, refuse_too_large
from dolfingrip.mechanics.newton.multigrid import Multigrid
from dolfingrip.mechanics.newton.tangent import Tangent
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.numerics import Solver

ITERATIVE_FROM: Final = 120_000
"""Unknowns of quadratic tetrahedra from which on multigrid takes less time."""

ITERATIVE_FROM_HEXAHEDRA: Final = 400_000
"""The same of hexahedra of 20 nodes. In walls of one element linear ones cannot bend, so that the
linear level says less."""

WORKSPACE: Final = 1.4
"""Memory of a factorisation by that of the factors' entries."""

TANGENT_KB: Final = 2.0
"""Memory for each unknown of a tangent, its assembly and the carried stress."""

MULTIGRID_KB: Final = 4.0
"""Memory for each unknown of multigrid with its linear level."""


class LinearSolver:
    """Makes the inverses of one model's tangents.

    A factorisation is quick for small models, but its time and memory grow faster than the
    unknowns. Multigrid needs a linear element below a quadratic one. The saddle points of a
    pressure field are factorised.

    Args:
        model: model whose tangent is inverted.
        tangent: the tangent.
        settings: which solver is asked for, and the memory that it may take.

    Attributes:
        iterative: whether inverses are approximate.
        forecast_MB: largest memory that the run will need on all ranks.

    Raises:
        ConfigError: one line, if the element has no multigrid, or the model will not fit.
    """

    def __init__(self, model: Model, tangent: Tangent, settings: Solver) -> None:
        self._model, self._tangent = model, tangent
        self._mixed = len(model.unknowns.fields) > 1
        element = model.u.function_space.ufl_element()
        quadratic = element.degree == 2 and not self._mixed
        if settings.linear == "iterative" and not quadratic:
            raise ConfigError('solver.linear = "iterative": allowed: with elements P2 and S2')
        large = {
            "tetrahedron": ITERATIVE_FROM,
            "hexahedron": ITERATIVE_FROM_HEXAHEDRA,
        }[str(model.domain.mesh.ufl_cell())]
        wanted = settings.linear == "iterative" or model.dofs >= large
        self.iterative = settings.linear != "direct" and quadratic and wanted
        self.forecast_MB = refuse_too_large(
            model.dofs,
            self._needed_MB(),
            settings.memory_GB,
            model.comm,
            "iterative" if self.iterative else "direct",
            "" if self.iterative or not quadratic else ', or solver.linear = "iterative"',
        )

    @cached_property
    def _order(self) -> Order:
        # a saddle point's zero diagonal is left to MUMPS' own order, as others fail on three ranks
        if self._mixed:
            return Order(AUTOMATIC)
        return cheapest(self._tangent.graph, self._model.comm)

    def _needed_MB(self) -> float:
        """Memory of the solver on all ranks (10⁶ bytes)."""
        thousands = self._model.dofs / 1e3
        if self.iterative:
            return (TANGENT_KB + MULTIGRID_KB) * thousands
        factors_MB = 8 * 9 * self._entries() / MB  # 9 numbers for each pair of nodes
        return TANGENT_KB * thousands + WORKSPACE * factors_MB

    def _entries(self) -> float:
        """Entries of the factors, one for each pair of nodes."""
        if not has_cholesky(self._model):
            return self._order.entries
        upper = sp.triu(self._tangent.graph, format="csr").sorted_indices()
        return elimination(upper.indptr, upper.indices).entries

    def inverse(self, prefix: str) -> Inverse:
        """The inverse for solves of Newton's method."""
        return Multigrid(prefix, self._model) if self.iterative else self.factors(prefix)

    def factors(self, prefix: str) -> Exact:
        """A factorisation, whatever the choice is."""
        return factors(prefix, self._model, lambda: self._order.number)

    def with_inertia(self, prefix: str) -> Inverse:
        """An inverse that tells the tangent's negative eigenvalues.

        Multigrid tells those of the linear level, which has the slow motions of a body that loses
        its equilibrium.
        """
        if self.iterative:
            return Multigrid(prefix, self._model)
        return Factorisation(prefix, self._model.comm, counts_pivots=True)
