"""A made-up quantity of a design: the time that it takes to print the finger."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final

from dolfingrip.design.quantities.quantity import (
    AskedDesign,
    Outcome,
    Quantity,
    QuantitySource,
)

G_PER_S: Final = 0.004
"""Mass that a printer lays in a second."""


class PrintTime(QuantitySource):
    """The mass by the printer's speed."""

    names: ClassVar = ("print_time_s",)

    def add(self, outcome: Outcome, wanted: Sequence[Quantity], design: AskedDesign) -> None:
        from dolfingrip.experiments.derivatives.gradients import MASS, shape_number

        outcome.outputs["print_time_s"] = shape_number(MASS, design.config, ())[0] / G_PER_S
