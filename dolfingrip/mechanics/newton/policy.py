"""The numbers behind decisions of Newton's method, in one policy for each decision."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, slots=True)
class StepPolicy:
    """How long a step is, and when a solve stops; see :class:`~.globalisation.Globalisation`.

    Attributes:
        recent: how many of the last residuals are compared with one another.
        changed_much: a residual that has not fallen to this part of the one before belongs to a
            tangent that has changed much.
        stagnant: once the first iterations are over, a residual that has not fallen to this part of
            the least recent one calls a line search.
        settled: iterations after which a step that a bound cuts is searched: a new touch must not
            undo them.
        hopeless: a residual above this multiple of its early peak ends the solve.
        early: iterations in which the residual may rise, as the carried stress makes it do.
        shortest: a step shortened below this fraction makes no progress any more.
        patience: number of such steps in a row that are allowed.
        folded: number of steps in a row in which elements would invert; the next one would, too.
        searched: residuals that a search evaluates beyond the first two.
        remaining: part of the work at the start of a step that may be left where a search ends.
        overshot: part of a first step, as searched, below which what is carried along it linearly
            means nothing.
        near: after contact has cut a step where walls may lie on one another, Hessians of pairs are
            convex until the residual has fallen to this part of its early peak. Pairs that meet at
            edges have directions of negative curvature, along which Newton's method leads to
            saddles.
        steep, closer: where the work is so many times that of the start, the search goes on at this
            part of the way: a membrane's force grows as the cube of its deflection, of which regula
            falsi hardly takes note.
    """

    recent: int = 3
    changed_much: float = 0.5
    stagnant: float = 0.7
    settled: int = 2
    hopeless: float = 3.0
    early: int = 4
    shortest: float = 1e-3
    patience: int = 2
    folded: int = 5
    searched: int = 8
    remaining: float = 0.3
    overshot: float = 0.5
    near: float = 1e-2
    steep: float = 100.0
    closer: float = 0.1


@dataclass(frozen=True, slots=True)
class LagPolicy:
    """When terms update lagged quantities; see :class:`~.lagging.LagRules`.

    Attributes:
        fallen: part of the residual after the last update to which it falls before the next.
        close: part of its peak below which lagged quantities are kept, unless they lag too far:
            then Newton's method converges.
        tolerance: relative lag error above which they are outdated, and a converged state is none.
        overshot: growth of the residual since the last update in a corrected step, from which on
            steps are corrected no more: a contact force may then be a hundred times too large. A
            solve's first step may be as large as it likes.
        longest: corrected steps of one solve. Where more are needed they go astray, and an update
            whenever the residual has fallen to half is the safer way.
        again: how often one solve goes on after it has converged for outdated quantities.
    """

    fallen: float = 0.5
    close: float = 1e-3
    tolerance: float = 0.01
    overshot: float = 5.0
    longest: int = 8
    again: int = 5


@dataclass(frozen=True, slots=True)
class CorrectionPolicy:
    """How a corrected step is solved for; see :class:`~.lagging.CorrectedStep`.

    Attributes:
        tolerance: part of the residual that the step's equations may be off by.
        solves: for a step, beyond the first.
        falling: part of the one before that an error is to fall to, or the next solve is a careful
            one.
    """

    tolerance: float = 1e-4
    solves: int = 8
    falling: float = 0.5


@dataclass(frozen=True, slots=True)
class FactorPolicy:
    """How long the inverse of one tangent serves the next ones; see :class:`~.factors.Factors`.

    Attributes:
        rtol: preconditioned residual of an iterative solve, relative to its first: a step as good
            as an exact one. Thirty times looser leaves errors of 1e-6 in a run's figures, this of
            1e-13.
        last: part of the residual that ends a solve which the last step may leave.
        ends: how often a last step is improved.
        close: part of a solve's first residual below which a step may be the last one.
        iterations: number of GMRES' iterations that cost as much as a factorisation.
        worn: iterations after which the next matrix is factorised at once.
        fresh: iterations with an approximate inverse of the matrix itself, beyond which factors
            take its place.
        restart: iterations whose vectors GMRES keeps.
        exact_rtol: as ``rtol``, where solutions are differentiated, of two solves: the second one
            is for what the first one left.
        exact_left: residual that these may leave, relative to the right-hand side, or factors take
            the inverse's place.
        near_rtol: error of solutions by factors of an earlier matrix, in the norm of the energy,
            where solutions are differentiated.
        near_iterations: conjugate gradients' iterations for these, beyond which the matrix is
            factorised.
        operator_rtol: as ``rtol``, for an operator that the matrix is a part of: what is left is
            solved for again.
        operator_iterations: for such an operator, by factors of an earlier matrix.
        operator_iterations_at_most: for such an operator, by the matrix' own factors.
    """

    rtol: float = 3e-5
    last: float = 0.1
    ends: int = 3
    close: float = 1e-2
    iterations: int = 8
    worn: int = 5
    fresh: int = 200
    restart: int = 60
    exact_rtol: float = 1e-8
    exact_left: float = 1e-6
    near_rtol: float = 1e-7
    near_iterations: int = 12
    operator_rtol: float = 1e-2
    operator_iterations: int = 12
    operator_iterations_at_most: int = 40


@dataclass(frozen=True, slots=True)
class NewtonPolicy:
    """All decisions of one solver.

    Attributes:
        factors: of a tangent.
        multigrid: of a tangent. Its own takes seven to ten of GMRES' iterations.
        guess_residual_ratio: a guess is left out whose residual is more than so many times the
            start's, as in contact, which an extrapolation may press together or take apart.
    """

    steps: StepPolicy = field(default_factory=StepPolicy)
    lag: LagPolicy = field(default_factory=LagPolicy)
    correction: CorrectionPolicy = field(default_factory=CorrectionPolicy)
    factors: FactorPolicy = field(default_factory=FactorPolicy)
    multigrid: FactorPolicy = FactorPolicy(rtol=1e-7, iterations=30, worn=25)
    guess_residual_ratio: float = np.inf
