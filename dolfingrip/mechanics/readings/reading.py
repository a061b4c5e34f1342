"""Readings of a model at its present state, and those that are found by their channels.

Some count from the state at rest.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from dolfingrip.channels import Part, read_of
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.term import NoShapeGradient
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.sections.lookup import only_class


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
        gradient = Gradient(self.model.unknowns)
        self.add_gradient(gradient)
        return gradient.array

    def add_gradient(self, gradient: Gradient) -> None:
        """Add ∂g/∂x to the derivatives by this rank's owned unknowns.

        Raises:
            NotDifferentiable: the reading has no derivative.
        """
        raise NotDifferentiable(f"{self.column} has no derivative: it is a smallest distance")

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        """Add ∂g/∂X: derivatives by the reference coordinates at fixed unknowns, for each mm.

        Raises:
            NoShapeGradient: one line, where the reading has none.
        """
        raise NoShapeGradient(f"{self.column}: no derivative by coordinates")


class FromRest(Reading):
    """g(x) − g(x at rest); an angle g may be larger than half a turn.

    :meth:`gradient` is the derivative of g at the present state. Its zero also changes with a
    parameter. A total derivative is therefore that of g here less that of g at rest; the caller
    derives ``raw`` with the model in its state at rest.

    Args:
        raw: g.
        turned_deg: for an angle, returns the rotation within half a turn, and that with whole
            turns; None for another reading.

    Attributes:
        raw: the reading g.
        zero: value of ``raw`` at rest; 0 until :meth:`tare` is called.
    """

    def __init__(self, raw: Reading, turned_deg: Callable[[], float] | None = None) -> None:
        super().__init__(raw.model, raw.column)
        self.raw = raw
        self.zero = 0.0
        self._turned_deg = turned_deg
        self._turned_at_rest_deg = 0.0

    def tare(self) -> None:
        """Make the present state the state at rest."""
        self.zero = self.raw.value()
        if self._turned_deg is not None:
            self._turned_at_rest_deg = self._turned_deg()

    def value(self) -> float:
        change = self.raw.value() - self.zero
        if self._turned_deg is not None:
            turned_deg = self._turned_deg() - self._turned_at_rest_deg
            change += 360.0 * round((turned_deg - change) / 360.0)
        return change

    def gradient(self) -> np.ndarray:
        return self.raw.gradient()

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        self.raw.add_shape_gradient(gradient)


def of_model(model: Model, *parts: Part) -> list[Reading]:
    """Readings that need the model alone.

    Args:
        model: model that is read.
        parts: parts of a set-up whose channels are read.

    Returns:
        One reading for each of these channels that names a file of this package.
    """
    readings = []
    for channel in read_of(*parts):
        if channel.reading:
            kind: Any = channel.reading
            if isinstance(kind, str):
                kind = only_class(f"dolfingrip.mechanics.readings.{kind}", Reading)
            reading: Reading = kind(model)
            readings.append(FromRest(reading) if channel.from_rest else reading)
    return readings
