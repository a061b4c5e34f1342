"""Readings of a model at its present state."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.term import NoShapeGradient


class NotDifferentiable(Exception):
    """A derivative was asked for of a reading that has none."""


class Reading(ABC):
    """A number g(x, m) that is read off a model with the unknowns x and the parameters m.

    Args:
        model: model that is read.
        column: name in the table, with the unit.

    Attributes:
        model, column: the model and the name.
        differentiable: whether it has derivatives.
    """

    differentiable: ClassVar[bool] = True

    @property
    def derived(self) -> bool:
        """True if it depends on the state and has derivatives; a prescribed number has none."""
        return self.differentiable

    def __init__(self, model: Model, column: str) -> None:
        self.model = model
        self.column = column

    @abstractmethod
    def value(self) -> float:
        """Value at the present state in the column's unit, equal on all ranks."""

    def gradient(self) -> np.ndarray:
        """∂g/∂x: derivatives by this rank's owned unknowns, in the order of their vector.

        Rows of supported unknowns are included; callers that solve with the tangent leave them out.

        Raises:
            NotDifferentiable: the reading has no derivative.
        """
        raise NotDifferentiable(f"{self.column} has no derivative: it is a smallest distance")

    def add_shape_gradient(self, found: ShapeGradient) -> None:
        """Add ∂g/∂X: derivatives by the reference coordinates at fixed unknowns, for each mm.

        Raises:
            NoShapeGradient: one line, where the reading has none.
        """
        raise NoShapeGradient(f"{self.column}: no derivative by coordinates")
