"""The length of a Newton step, and when to stop."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from enum import Enum

import numpy as np
from petsc4py import PETSc

from dolfingrip.mechanics.model import compatibility
from dolfingrip.mechanics.model.model import INVERTED, Model
from dolfingrip.mechanics.newton.policy import StepPolicy
from dolfingrip.sections.numerics import Solver


class IterationVerdict(Enum):
    """The verdicts on a residual norm, each with SNES' reason for it."""

    GO_ON = PETSc.SNES.ConvergedReason.CONVERGED_ITERATING
    CONVERGED = PETSc.SNES.ConvergedReason.CONVERGED_FNORM_RELATIVE
    NOT_A_NUMBER = compatibility.NOT_A_NUMBER
    STUCK = PETSc.SNES.ConvergedReason.DIVERGED_LINE_SEARCH
    HOPELESS = PETSc.SNES.ConvergedReason.DIVERGED_DTOL


class Globalisation:
    """Bounds and judges the steps of one solve.

    The model bounds a step (contact, plate, inversion). Within the bound the first steps are full
    steps, because the carried stress makes the residual rise before it falls. Later, a residual
    that stagnates (pairs of contact that change from step to step) calls a search along the step,
    and a residual that exceeds its early peak ends the solve.

    Args:
        model: model whose steps are bounded.
        settings: tolerances.
        residual_along: product of the residual at the model's present displacement with a step
            (mJ).
        policy: how long steps are, and when a solve stops.
        scale_N: force (N) that the relative tolerance refers to; default: the first residual.
        elsewhere: whether the start is another state than that at the end of the last solve.
        damped: whether each step is searched along, and a residual may rise.

    Attributes:
        bound: name of the bound that cut the last step; "" if none did.
        changed_much: whether the tangent is probably far from the one before.
        overshot: whether the last step was one of the first of a model that is singular at rest,
            and far too long; a membrane has no stiffness across it until it is deflected.
    """

    def __init__(
        self,
        model: Model,
        settings: Solver,
        residual_along: Callable[[np.ndarray], float],
        policy: StepPolicy,
        *,
        scale_N: float | None = None,
        elsewhere: bool = False,
        damped: bool = False,
    ) -> None:
        self._model = model
        self._settings = settings
        self._residual_along = residual_along
        self._policy = policy
        self._search_first, self._crowded = model.singular_at_rest, model.crowded
        self.bound = ""
        self.overshot = False
        self.changed_much = elsewhere
        self._damped = damped
        self._short = 0
        self._inverted = 0
        self._cut = False
        self._scale_N = scale_N
        self._peak = 0.0
        self._recent: deque[float] = deque(maxlen=self._policy.recent)
        self._before: list[float] = []
        self._settled = False
        self._stagnates = False

    @property
    def first_N(self) -> float:
        """Force that the relative tolerance refers to: the residual at the load step's start."""
        return self._scale_N or 0.0

    def tolerance_N(self, scale: float = 0.0) -> float:
        """Norm of the residual (N) that counts as none; for ``scale`` see :meth:`judge`."""
        relative = self._settings.rtol * max(self.first_N, scale)
        return max(self._settings.atol_N, relative)

    @property
    def _folds(self) -> bool:
        """True if elements would have inverted in too many steps in a row."""
        return self._inverted > self._policy.folded

    @property
    def stuck(self) -> bool:
        """True if the last step made no progress, or elements would invert again and again."""
        return self._short > 0 or self._folds

    @property
    def convex(self) -> bool:
        """True from a step that crowded contact has cut on, until the residual is small."""
        return self._cut and self._recent[-1] > self._policy.near * self._peak

    def judge(self, iteration: int, norm: float, scale: float = 0.0) -> IterationVerdict:
        """The verdict on the residual norm (N) at the start of ``iteration``.

        Args:
            iteration: 0 before the first step.
            norm: norm of the residual (N).
            scale: force (N) that the relative tolerance refers to, if it is larger than the
                first residual.
        """
        policy, late = self._policy, iteration > self._policy.early
        if not np.isfinite(norm):
            return IterationVerdict.NOT_A_NUMBER
        if self._scale_N is None:
            self._scale_N = norm
        self._before = []
        if not late:
            self._peak = max(self._peak, norm)
        if self._short > policy.patience or self._folds:
            return IterationVerdict.STUCK
        if norm <= self.tolerance_N(scale) and not self.bound:
            return IterationVerdict.CONVERGED
        self._before = list(self._recent)
        if self._recent:
            self.changed_much = norm > policy.changed_much * self._recent[-1]
        self._settled = iteration >= policy.settled
        # not only with the last one: pairs that touch and part in turn make the residual jump
        self._stagnates = self._damped or (
            late and norm > policy.stagnant * min(self._recent, default=np.inf)
        )
        self._recent.append(norm)
        if late and norm > policy.hopeless * self._peak and not self._damped:
            return IterationVerdict.HOPELESS
        return IterationVerdict.GO_ON

    def judge_anew(self, iteration: int, norm: float, scale: float = 0.0) -> IterationVerdict:
        """The verdict of :meth:`judge` at this iterate after the potential has changed.

        The earlier residuals still tell whether the solve stagnates, because the lagged quantities
        followed the steps. Residuals before a state that converged for fixed quantities do not.
        """
        self._recent = deque(self._before, maxlen=self._policy.recent)
        return self.judge(iteration, norm, scale)

    def fraction(self, step: np.ndarray) -> float:
        """The fraction of ``step`` (a local array of the unknowns) to take."""
        fraction, self.bound = self._model.admissible_step(step)
        self._cut |= self.bound in self._crowded
        self.overshot = False
        if self._stagnates or ((self.convex or self.bound) and self._settled):
            fraction = self._search(step, fraction)
        elif self._search_first and not self._settled:
            fraction = self._search(step, fraction)
            self.overshot = abs(fraction) < self._policy.overshot
        self._short = self._short + 1 if abs(fraction) < self._policy.shortest else 0
        self._inverted = self._inverted + 1 if self.bound == INVERTED else 0
        return fraction

    def _search(self, step: np.ndarray, longest: float) -> float:
        """The fraction of ``step``, up to the longest, at which the forces do no more work.

        Regula falsi on the residual's product with the step (Matthies & Strang, Int. J. Numer.
        Methods Eng. 14, 1979): Π has its minimum along the step there, even if pairs that touch
        and part make the residual jump. If a step is no descent direction, the search goes
        backwards. Such a step leads to a saddle, for example as a bellow slides over an edge.
        """
        unknowns = self._model.unknowns
        start = unknowns.local()

        def work(fraction: float) -> float:
            unknowns.set_local(start + fraction * step)
            return self._residual_along(step)

        try:
            first = work(0.0)
            if first <= 0:
                return _root(work, first, longest, self._policy)
            back, self.bound = self._model.admissible_step(-step)
            return -_root(lambda fraction: -work(-fraction), -first, back, self._policy)
        finally:
            unknowns.set_local(start)


def _root(work: Callable[[float], float], first: float, end: float, policy: StepPolicy) -> float:
    """The place up to ``end`` at which ``work``, ``first`` at 0, is nearly 0; else ``end``."""
    lower, upper = (0.0, first), (end, work(end))
    if upper[1] <= policy.remaining * abs(first):
        return end
    place = end
    for _ in range(policy.searched):
        place = lower[0] - lower[1] * (upper[0] - lower[0]) / (upper[1] - lower[1])
        if upper[1] > policy.steep * abs(first):
            place = lower[0] + policy.closer * (upper[0] - lower[0])
        value = work(place)
        if abs(value) <= policy.remaining * abs(first):
            break
        if value > 0:
            upper = (place, value)
            lower = (lower[0], lower[1] / 2)  # as Illinois does, lest one end stays for ever
        else:
            lower = (place, value)
            upper = (upper[0], upper[1] / 2)
    return place
