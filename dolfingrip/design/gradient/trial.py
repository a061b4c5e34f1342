"""Designs that a descent simulated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from dolfingrip.design.gradient.problem import Constraint, Floats
from dolfingrip.design.gradient.shape import UnloadedShape


@dataclass(slots=True)
class Trial:
    """A design that was simulated.

    Attributes:
        scaled: shape (variables,), 0 to 1 over their ranges.
        values: of the variables.
        shape: of the unloaded finger.
        simulations: load paths so far, with this one's.
        objective: the worst condition's; NaN where it failed.
        excess: by how much the worst simulated limit is broken, as a part of its size; 0 if kept.
        limits: value of each limit's quantity in its worst condition.
        accepted: whether the next steps begin here.
        radius: of the box that the step was chosen in.
        expected: gain of the objective that the model promised, in its unit.
        failure: class and sentence; "" if it was simulated.
        signed: shape (conditions,), objectives, which count as minimised.
        signed_slopes: shape (conditions, variables), by the scaled variables.
        of_parts: shape (variables, variables), the curvature of the worst condition's objective
            where it is a sum of squares of linear parts; None: it is no sum of squares.
        above: shape (m,), by how much simulated limits are broken, as parts of their sizes, for
            each limit and condition.
        above_slopes: shape (m, variables), likewise.
    """

    scaled: Floats
    values: Floats
    shape: UnloadedShape
    simulations: int
    objective: float = float("nan")
    excess: float = 0.0
    limits: list[float] = field(default_factory=list)
    accepted: bool = False
    radius: float = 0.0
    expected: float = 0.0
    failure: str = ""
    signed: Floats = field(default_factory=lambda: np.empty(0), repr=False)
    signed_slopes: Floats = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    of_parts: Floats | None = field(default=None, repr=False)
    above: Floats = field(default_factory=lambda: np.empty(0), repr=False)
    above_slopes: Floats = field(default_factory=lambda: np.empty((0, 0)), repr=False)


@dataclass(slots=True)
class Descent:
    """The way that a descent took.

    Attributes:
        trials: every design that was simulated, in order; the first is the start.
        best: the last accepted one.
        ending: why it ended, in words.
        limits: the limits with their values.
        simulations: load paths that were followed.
        seconds: that they took in all.
    """

    trials: list[Trial]
    best: Trial
    ending: str
    limits: list[tuple[Constraint, float]]
    simulations: int
    seconds: float

    @property
    def start(self) -> Trial:
        """The design at which it began."""
        return self.trials[0]


Say = Callable[[Trial, Sequence[tuple[Constraint, float]]], None]
"""Called with each design that was simulated, and the limits with their values."""


def say_nothing(trial: Trial, limits: Sequence[tuple[Constraint, float]]) -> None:
    """Say nothing of a design."""
