"""Which linear solver a model's tangent has, the memory that it will need, and what there is."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import scipy.sparse as sp
from mpi4py import MPI

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
from dolfingrip.mechanics.newton.multigrid import Multigrid
from dolfingrip.mechanics.newton.policy import LinearPolicy
from dolfingrip.mechanics.newton.tangent import Tangent
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.numerics import Solver

MB = 1e6


def refuse_too_large(
    unknowns: int,
    needed_MB: float,
    allowed_GB: float | None,
    comm: MPI.Comm,
    how: str,
    also: str = "",
) -> float:
    """Raise an error if a model will not fit, before its solver takes the memory.

    Args:
        unknowns: number of unknowns.
        needed_MB: by the solver on all ranks, beyond what the processes have now.
        allowed_GB: by the configuration; None: what is free.
        comm: ranks, on one machine.
        how: name of the solver, for the error.
        also: what else is allowed, for the error.

    Returns:
        The forecast of the largest memory on all ranks (MB).

    Raises:
        ConfigError: on every rank, one line.
    """
    now_MB = comm.allreduce(_resident_MB(), MPI.SUM)
    forecast = now_MB + needed_MB
    allowed = now_MB + free_MB() if allowed_GB is None else 1e3 * allowed_GB
    allowed = comm.bcast(allowed)
    if forecast > allowed:
        key = "what is free" if allowed_GB is None else "solver.memory_GB"
        raise ConfigError(
            f"mesh: {unknowns:,} unknowns take about {forecast / 1e3:.2g} GB with the {how} solver;"
            f" allowed: up to {allowed / 1e3:.2g} GB ({key}){also}"
        )
    return float(forecast)


def free_MB() -> float:
    """Memory that new work may take (10⁶ bytes): of the machine, or of this process' group."""
    found = [float("inf")]
    found += _entry_MB("/proc/meminfo", "MemAvailable")
    limit, used = (_read(f"/sys/fs/cgroup/memory.{name}").strip() for name in ("max", "current"))
    if limit.isdigit() and used.isdigit():
        found.append((int(limit) - int(used)) / MB)
    return min(found)


def of_factors_MB(entries: float, workspace: float) -> float:
    """Memory of a factorisation (10⁶ bytes) by the entries of its factors, one for each node.

    Args:
        entries: number of entries.
        workspace: memory of the factorisation by that of the entries.
    """
    return workspace * 8 * 9 * entries / MB


def peak_MB() -> float:
    """Largest memory of this process so far (10⁶ bytes).

    ``getrusage`` has that of the process which started this one, where that was larger.
    """
    return sum(_entry_MB("/proc/self/status", "VmHWM"))


def _entry_MB(path: str, name: str) -> list[float]:
    """The entry of this name in a file of the kernel, which tells KiB; none if there is none."""
    lines = [line.split() for line in _read(path).splitlines() if line.startswith(f"{name}:")]
    return [float(words[1]) * 1024 / MB for words in lines]


def _resident_MB() -> float:
    return sum(_entry_MB("/proc/self/status", "VmRSS"))


def _read(path: str) -> str:
    try:
        return Path(path).read_text(encoding="ascii", errors="ignore")
    except OSError:
        return ""


class LinearSolver:
    """Makes the inverses of one model's tangents.

    A factorisation is quick for small models, but its time and memory grow faster than the
    unknowns. Multigrid needs a linear element below a quadratic one. The saddle points of a
    pressure field are factorised.

    Args:
        model: model whose tangent is inverted.
        tangent: the tangent.
        settings: which solver is asked for, and the memory that it may take.
        policy: from which size on multigrid is used, and the memory that solvers need.

    Attributes:
        iterative: whether inverses are approximate.
        forecast_MB: largest memory that the run will need on all ranks.

    Raises:
        ConfigError: one line, if the element has no multigrid, or the model will not fit.
    """

    def __init__(
        self,
        model: Model,
        tangent: Tangent,
        settings: Solver,
        policy: LinearPolicy = LinearPolicy(),
    ) -> None:
        self._policy = policy
        self._model, self._tangent = model, tangent
        self._mixed = len(model.unknowns.fields) > 1
        element = model.u.function_space.ufl_element()
        quadratic = element.degree == 2 and not self._mixed
        if settings.linear == "iterative" and not quadratic:
            raise ConfigError('solver.linear = "iterative": allowed: with elements P2 and S2')
        large = {
            "tetrahedron": policy.iterative_from,
            "hexahedron": policy.iterative_from_hexahedra,
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
        thousands, policy = self._model.dofs / 1e3, self._policy
        if self.iterative:
            return (policy.tangent_kB + policy.multigrid_kB) * thousands
        return policy.tangent_kB * thousands + of_factors_MB(self._entries(), policy.workspace)

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
