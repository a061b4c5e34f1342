"""The state from which Newton's method starts a load step."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.state import Guess, State
from dolfingrip.mechanics.path.policy import PathPolicy, SeriesPolicy


class Predictor:
    """Continues the polynomial through the last states of a straight load path.

    At the start of the path the states are those of its series. Displacement *and* carried stress
    are extrapolated. The extrapolated displacement stretches parts that should only turn, but this
    hardly affects the extrapolated stress, with which the first tangent is nearly that of the
    solution. Extrapolating the displacement alone costs more iterations than it saves.

    Args:
        model: model whose states are kept; nothing is predicted if its tangent carries nothing.
        tangent: returns K⁻¹ at the model's state, for :func:`taylor_terms`.
        policy: policy of the path.
    """

    def __init__(self, model: Model, tangent: Callable[[], InverseMap], policy: PathPolicy) -> None:
        self._model = model
        self._tangent = tangent
        self._series = policy.series
        self._policy = policy.predictor
        self._kept: deque[tuple[float, Guess]] = deque(maxlen=self._policy.most)
        self._noted: dict[frozenset[tuple[str, float]], np.ndarray] = {}

    def restart(self, place: float) -> None:
        """Forget all states except the present, converged one at ``place`` on the path."""
        self._kept.clear()
        self._model.carried.reset()
        self.keep(place)

    def turn(self, place: float, rates: Mapping[str, float]) -> float:
        """Start a new straight path at the present, converged state.

        Args:
            place: place of the state on the path.
            rates: rates of the controls, for each unit of place.

        Returns:
            The length of a first step that is easy, at most 1.
        """
        self.restart(place)
        state = self._model.state()
        if not self._model.carried or state.history:
            return 1.0  # if internal variables evolve, half a step ends in another state
        terms = taylor_terms(self._model, self._tangent, state.controls, rates, self._series)
        if not terms:
            return 1.0
        reach = taylor_reach(self._model, terms, self._series.falling)
        if reach < 1.0:
            reach = taylor_reach(self._model, terms, self._series.easy)
        here = self._model.unknowns.local()
        farthest = taylor_sum(here, terms, self._policy.ahead[0] * reach)
        if reach < self._series.nearest or self._model.admissible_step(farthest - here)[0] < 1.0:
            return 1.0
        self._kept.clear()
        for ahead in (*self._policy.ahead, 0.0):
            self._model.unknowns.set_local(taylor_sum(here, terms, ahead * reach))
            self._model.carried.reset()
            self.keep(place + ahead * reach)
        return reach

    def keep(self, place: float) -> None:
        """Store the state that Newton's method has found at ``place``."""
        carried = self._model.carried
        if carried:
            guess = Guess(self._model.unknowns.local(), carried.values)
            self._kept.append((place, guess))

    def note(self, state: State) -> None:
        """Note the present, converged ``state``, if nothing remembers the way to it."""
        if not state.history:
            self._noted[_loads(state.controls)] = self._model.unknowns.local()

    def forget(self) -> None:
        """Forget the noted states, to which a path does not return after a jump."""
        self._noted.clear()

    def noted(self, controls: Mapping[str, float]) -> Guess | None:
        """The state that was noted at ``controls``, at whatever time; None if there is none."""
        unknowns = self._noted.get(_loads(controls))
        if unknowns is None:
            return None
        here = self._model.unknowns.local()
        self._model.unknowns.set_local(unknowns)
        self._model.carried.reset()
        guess = Guess(unknowns, self._model.carried.values)
        self._model.unknowns.set_local(here)
        return guess

    def guess(self, place: float) -> Guess | None:
        """The state at ``place``, or as near to it as bounds allow; None if that is not far."""
        if len(self._kept) < self._policy.fewest:
            return None
        places = np.array([kept for kept, _ in self._kept])
        weights = lagrange(places, place)
        states = [state for _, state in self._kept]
        last = states[-1]
        step = np.tensordot(weights, [state.unknowns for state in states], 1) - last.unknowns
        part, _ = self._model.admissible_step(step)
        if part < 1.0:
            part *= self._policy.clear
        if part < self._policy.worth:
            return None
        carried = np.tensordot(weights, [state.carried for state in states], 1)
        return Guess(last.unknowns + part * step, last.carried + part * (carried - last.carried))


def _loads(controls: Mapping[str, float]) -> frozenset[tuple[str, float]]:
    """Controls without the time."""
    return frozenset(item for item in controls.items() if item[0] != "time_s")


def lagrange(places: np.ndarray, place: float) -> np.ndarray:
    """Weights of values at ``places`` (n,) in the interpolating polynomial at ``place``, (n,)."""
    apart = places[:, None] - places + np.eye(len(places))
    ratios = (place - places) / apart
    np.fill_diagonal(ratios, 1.0)
    return np.asarray(ratios.prod(axis=1))


InverseMap = Callable[[np.ndarray], np.ndarray]
"""The map K⁻¹ of an array of residuals; both are owned values in the order of a vector."""


def taylor_terms(
    model: Model,
    tangent: Callable[[], InverseMap],
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
    terms: list[np.ndarray] = []
    equations = model.unknowns.create_vector()

    def residual(s: float) -> np.ndarray:
        model.unknowns.set_local(taylor_sum(start, terms, s))
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
            terms = [first]  # what ``residual`` follows
            for order in range(2, policy.order + 1):
                terms.append(model.unknowns.to_local(-solve(difference(order, near))))
            if not kept or _length(model, terms[-1]) < _length(model, kept[-1]):
                kept = terms
            model.unknowns.set_local(start)
            if taylor_reach(model, kept, policy.falling) == 1.0 or not _admits(model, kept, policy):
                break
    finally:
        model.unknowns.set_local(start)
        model.prescribe(controls)
        equations.destroy()
    return kept


def taylor_reach(model: Model, terms: Sequence[np.ndarray], falling: float) -> float:
    """The largest s, up to 1, at which the last term is no more than ``falling`` of the first.

    Beyond it the series does not hold: in contact, which is not smooth, from nearly 0 on.
    """
    first, last = (_length(model, term) for term in (terms[0], terms[-1]))
    if last < falling * first:
        return 1.0
    return float((falling * first / last) ** (1 / (len(terms) - 1)))


def _admits(model: Model, terms: Sequence[np.ndarray], policy: SeriesPolicy) -> bool:
    """Return whether states of the longer difference are admissible; they are not near contact."""
    zero = np.zeros_like(terms[0])
    ways = (taylor_sum(zero, terms, s) for s in (-policy.farther, policy.farther))
    return all(model.admissible_step(way)[0] == 1.0 for way in ways)


def taylor_sum(start: np.ndarray, terms: Sequence[np.ndarray], s: float) -> np.ndarray:
    """Sum of a start and the series: start + Σ terms[k − 1] sᵏ."""
    return sum((s**order * term for order, term in enumerate(terms, 1)), start=start)


def _length(model: Model, term: np.ndarray) -> float:
    """Norm of a term's displacement (mm)."""
    owned = model.unknowns.owned_part(term)[: model.u.x.index_map.size_local * model.u.x.block_size]
    return float(np.sqrt(model.comm.allreduce(owned @ owned, MPI.SUM)))
