"""The Taylor series of a load path at its start, before any step along it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.path.policy import SeriesPolicy

Solve = Callable[[np.ndarray], np.ndarray]
"""The map K⁻¹ of an array of residuals; both are owned values in the order of a vector."""


def terms(
    model: Model,
    tangent: Callable[[], Solve],
    controls: Mapping[str, float],
    rates: Mapping[str, float],
    policy: SeriesPolicy,
) -> list[np.ndarray]:
    """Taylor terms of the states on a straight path through a model's present solution.

    If the terms of u(s) below sⁿ are known, the residual along them starts with r sⁿ, and the next
    term is −K⁻¹r sⁿ. One tangent serves all orders (the asymptotic numerical method: Cochelin,
    Damil & Potier-Ferry, Int. J. Numer. Methods Eng. 37, 1994). r is a central difference here, so
    that it is valid for every energy, contact and extension.

    Where the last term does not fall, the terms are taken from a longer difference, too, and those
    with the smaller last term are kept. Rounding enlarges the last term of the shorter difference,
    as with a stiff, thin layer; higher orders enlarge that of the longer one.

    Args:
        model: model at a solution; its state does not change.
        tangent: returns K⁻¹ at the model's state; not called if the state does not depend on s.
        controls: controls of the solution.
        rates: rates of the controls, for each unit of s.
        policy: numbers with which the series is made and judged.

    Returns:
        The factors of s, s², … of the unknowns, local arrays. The list is empty if the path does
        not move.
    """
    start = model.unknowns.local()
    found: list[np.ndarray] = []
    equations = model.unknowns.create_vector()

    def residual(s: float) -> np.ndarray:
        model.unknowns.set_local(along(start, found, s))
        model.prescribe({name: controls[name] + s * rate for name, rate in rates.items()})
        model.assemble_equations(equations)
        return equations.array_r.copy()

    def difference(order: int, near: float) -> np.ndarray:
        ahead, back = residual(near), residual(-near)
        both = ahead - back if order % 2 else ahead + back - 2 * residual(0.0)
        return both / (2 * near**order)

    try:
        change = difference(1, policy.near)
        if not model.comm.allreduce(bool(change.any()), MPI.LOR):
            return []
        model.unknowns.set_local(start)
        model.prescribe(controls)
        solve = tangent()
        first = model.unknowns.to_local(-solve(change))
        kept: list[np.ndarray] = []
        for near in (policy.near, policy.farther):
            found = [first]  # what ``residual`` follows
            for order in range(2, policy.order + 1):
                found.append(model.unknowns.to_local(-solve(difference(order, near))))
            if not kept or _length(model, found[-1]) < _length(model, kept[-1]):
                kept = found
            model.unknowns.set_local(start)
            if reach(model, kept, policy.falling) == 1.0 or not _admits(model, kept, policy):
                break
    finally:
        model.unknowns.set_local(start)
        model.prescribe(controls)
        equations.destroy()
    return kept


def reach(model: Model, terms: Sequence[np.ndarray], falling: float) -> float:
    """The largest s, up to 1, at which the last term is no more than ``falling`` of the first.

    Beyond it the series does not hold: in contact, which is not smooth, from nearly 0 on.
    """
    first, last = (_length(model, term) for term in (terms[0], terms[-1]))
    if last < falling * first:
        return 1.0
    return float((falling * first / last) ** (1 / (len(terms) - 1)))


def _admits(model: Model, terms: Sequence[np.ndarray], policy: SeriesPolicy) -> bool:
    """Whether the states of the longer difference are admissible, as they are not near contact."""
    zero = np.zeros_like(terms[0])
    ways = (along(zero, terms, s) for s in (-policy.farther, policy.farther))
    return all(model.admissible_step(way)[0] == 1.0 for way in ways)


def along(start: np.ndarray, terms: Sequence[np.ndarray], s: float) -> np.ndarray:
    """Start + Σ terms[k − 1] sᵏ."""
    return sum((s**order * term for order, term in enumerate(terms, 1)), start=start)


def _length(model: Model, term: np.ndarray) -> float:
    """Norm of a term's displacement (mm)."""
    owned = model.unknowns.owned_part(term)[: model.u.x.index_map.size_local * model.u.x.block_size]
    return float(np.sqrt(model.comm.allreduce(owned @ owned, MPI.SUM)))
