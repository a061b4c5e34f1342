"""Which linear solver a model's tangent has."""

from __future__ import annotations

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.inverse import Factorisation, Inverse
from dolfingrip.mechanics.newton.multigrid import Multigrid
from dolfingrip.mechanics.newton.policy import LINEAR
from dolfingrip.mechanics.newton.tangent import Tangent
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.numerics import Solver


class LinearSolver:
    """Makes the inverses of one model's tangents.

    A factorisation is quick for small models, but its time and memory grow faster than the
    unknowns. Multigrid needs a linear element below a quadratic one. The saddle points of a
    pressure field and of a volume that is prescribed are factorised.

    Args:
        model: model whose tangent is inverted.
        tangent: the tangent.
        settings: which solver is asked for.

    Attributes:
        iterative: whether inverses are approximate.

    Raises:
        ConfigError: one line, if the element has no multigrid.
    """

    def __init__(self, model: Model, tangent: Tangent, settings: Solver) -> None:
        self._model, self._tangent = model, tangent
        self._mixed = len(model.unknowns.fields) > 1
        quadratic = model.u.function_space.ufl_element().degree == 2
        if settings.linear == "iterative" and (self._mixed or not quadratic):
            raise ConfigError('solver.linear = "iterative": allowed: with elements P2 and S2')
        saddle = self._mixed or any(each.multiplier for each in model.unknowns.global_unknowns)
        large = settings.linear == "iterative" or model.dofs >= LINEAR.iterative_from
        self.iterative = settings.linear != "direct" and quadratic and not saddle and large

    def inverse(self, prefix: str) -> Inverse:
        """The inverse for solves of Newton's method."""
        return Multigrid(prefix, self._model) if self.iterative else self.factors(prefix)

    def factors(self, prefix: str) -> Factorisation:
        """A factorisation, whatever the choice is."""
        # a saddle point's zero diagonal is left to MUMPS' own order, as others fail on three ranks
        graph = None if self._mixed else self._tangent.graph
        return Factorisation(prefix, graph, self._model.comm)

    def with_inertia(self, prefix: str) -> Inverse:
        """An inverse that tells the tangent's negative eigenvalues.

        Multigrid tells those of the linear level, which has the slow motions of a body that loses
        its equilibrium.
        """
        if self.iterative:
            return Multigrid(prefix, self._model)
        return Factorisation(prefix, None, self._model.comm, counts_pivots=True)
