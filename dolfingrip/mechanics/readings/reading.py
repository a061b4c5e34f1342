"""Readings of a model at its present state."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from dolfingrip.mechanics.model.direction import Direction
from dolfingrip.mechanics.model.model import Model


class NotDifferentiable(Exception):
    """A derivative was asked for of a reading that has none."""


class Reading(ABC):
    """A number that is read off a model, g(x, m) of its unknowns x and its parameters m.

    Args:
        model: what is read.
        column: name in the table, with the unit.

    Attributes:
        model, column: as given.
        differentiable: whether it has derivatives.
    """

    differentiable: ClassVar[bool] = True

    def __init__(self, model: Model, column: str) -> None:
        self.model = model
        self.column = column

    @abstractmethod
    def value(self) -> float:
        """At the present state, in the column's unit, the same on all ranks."""

    def gradient(self) -> np.ndarray:
        """∂g/∂x: derivatives by this rank's owned unknowns, in the order of a vector of them.

        Rows of supported unknowns are included; who solves with the tangent leaves them out.

        Raises:
            NotDifferentiable: the reading has no derivative.
        """
        raise NotDifferentiable(f"{self.column} has no derivative: it is a smallest distance")

    def by_direction(self, direction: Direction) -> float:
        """∂g/∂m: as a parameter changes and the unknowns do not, the same on all ranks.

        Raises:
            NotDifferentiable: the reading has no derivative.
        """
        raise NotDifferentiable(f"{self.column} has no derivative: it is a smallest distance")
