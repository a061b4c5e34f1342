"""Numbers of the unloaded shape; they take no simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from dolfingrip.design.quantities.quantity import AskedDesign, Outcome, Quantity, QuantitySource

COG, MASS = "cog_offset_mm", "mass_g"


class ShapeNumbers(QuantitySource):
    """Offset of the centre of gravity, and mass."""

    names: ClassVar = (COG, MASS)

    def add(self, outcome: Outcome, wanted: Sequence[Quantity], asked: AskedDesign) -> None:
        from dolfingrip.experiments.derivatives.gradients import shape_number
        from dolfingrip.experiments.derivatives.sensitivities import choices, chosen

        keys = asked.keys
        parameters = None if keys is None else chosen(asked.config, keys)
        assert outcome.gradients is not None
        for each in wanted:
            value, slopes = shape_number(each.name, asked.config, parameters)
            for choice in choices(asked.config, keys):
                other, _ = shape_number(each.name, choice.other, ())
                slopes[choice.label] = choice.difference(value, other)
            outcome.outputs[str(each)], outcome.gradients[str(each)] = value, slopes
