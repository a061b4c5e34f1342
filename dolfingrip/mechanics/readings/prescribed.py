"""Readings of controls, and of time."""

from __future__ import annotations

from typing import ClassVar

from dolfingrip.channels import TIME
from dolfingrip.mechanics.model.model import Control, Model, Prescribed
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient
from dolfingrip.mechanics.readings.reading import Reading


class ControlValue(Reading):
    """The value of a control, or of the unknown that takes its place, such as a multiplier.

    Args:
        model: model that is read.
        column: name in the table, with the control's unit.
        control: a control of the model, or one that another control has replaced.
    """

    def __init__(self, model: Model, column: str, control: Prescribed) -> None:
        super().__init__(model, column)
        self._control = control

    @property
    def derived(self) -> bool:
        return self._unknown() is not None

    def _unknown(self) -> GlobalUnknown | None:
        """The unknown that the control's value is, where another control has replaced it."""
        if not isinstance(self._control, Control):
            return None
        constant = self._control.constant
        matches = (one for one in self.model.unknowns.global_unknowns if one.constant is constant)
        return next(matches, None)

    def value(self) -> float:
        return float(self._control.value)

    def add_gradient(self, gradient: Gradient) -> None:
        unknown = self._unknown()
        if unknown is not None:
            assert isinstance(self._control, Control)
            gradient.add(unknown, 1 / self._control.factor)

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        """Add nothing."""


class Time(Reading):
    """Time since the first stop (s); it does not depend on state or parameters."""

    derived: ClassVar = False

    def __init__(self, model: Model) -> None:
        super().__init__(model, TIME.name)

    def value(self) -> float:
        return self.model.time_s

    def add_gradient(self, gradient: Gradient) -> None:
        """It depends on none."""

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        """Add nothing."""
