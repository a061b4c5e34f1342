"""The numbers behind decisions along a load path, in one policy for each decision."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class PredictorPolicy:
    """The state from which a load step starts; see :class:`~.predictor.Predictor`.

    Attributes:
        fewest, most: smallest and largest number of states that the polynomial interpolates (four:
            a cubic).
        clear: fraction of the step to a bound that is taken; nearer, the barrier's force would be
            too large.
        worth: smallest fraction of the step to the predicted state that saves iterations.
        ahead: places at which the Taylor series is sampled, in the unit of the path. Those that are
            used longest come last. They lie near enough for the series to hold, and far enough
            apart for rounding not to matter.
    """

    fewest: int = 3
    most: int = 4
    clear: float = 0.9
    worth: float = 0.3
    ahead: tuple[float, ...] = (0.25, -0.125, 0.125)


@dataclass(frozen=True, slots=True)
class SeriesPolicy:
    """The Taylor series of a path at its start; see :func:`~.predictor.taylor_terms`.

    Attributes:
        order: order of the series, like that of the polynomials that continue the path.
        near: distance of the states in differences that give derivatives, in the path's unit.
            Membranes are so stiff that at a hundredth the third term is 1.7 times too large;
            rounding stays below 1e-5 of the first term.
        farther: that distance where the last term is too large by ``near``. There rounding is a
            thousandth: by ``near`` it makes the third term of a stiff, thin layer 1.4 times the
            first one.
        falling: largest ratio of the last and the first term over the longest step; where it is
            larger, the path starts with a shorter step.
        easy: that ratio over the shorter step.
        nearest: shortest such step, in the path's unit; where the series holds no farther, as in
            contact, it is not used, and the path starts with the longest step.
    """

    order: int = 3
    near: float = 1e-3
    farther: float = 1e-2
    falling: float = 0.3
    easy: float = 0.06
    nearest: float = 0.044


@dataclass(frozen=True, slots=True)
class PathPolicy:
    """How a path is divided into steps; see :class:`~.path.LoadPath`.

    Attributes:
        soft: part of the largest stiffness on the path below which a failure is a limit point.
        away: part of the largest stiffness below which a motion past unstable states runs away.
        creeping: length of a step, in longest steps, below which a failure asks whether the load
            turns, where a damped solve has not helped. Halving on would take minutes.
        foreseen: Newton iterations of a step beyond which the load is forecast to turn.
        comfortable: Newton iterations up to which the next step may be longer.
        sliver: part of a step that is too small for a last step of its own.
        small_jump: iterations of a damped solve over a small jump, at most. Jumps of folds of the
            reference finger take up to 41; where there is no state near by, it ends the sooner.
        from_equilibrium: whether a step that starts without a predicted state has its first tangent
            with the controls of its start.
        halves_first: whether a step that fails is halved before it starts again in another way or
            is damped, except the last one tried: with inertia, short steps are easy.
    """

    soft: float = 0.2
    away: float = 0.1
    creeping: float = 0.12
    foreseen: int = 10
    comfortable: int = 8
    sliver: float = 0.01
    small_jump: int = 45
    from_equilibrium: bool = False
    halves_first: bool = False
    predictor: PredictorPolicy = field(default_factory=PredictorPolicy)
    series: SeriesPolicy = field(default_factory=SeriesPolicy)
