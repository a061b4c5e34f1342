"""Numbers of the unloaded shape; they take no simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from dolfingrip.design.quantities.quantity import AskedDesign, Outcome, Quantity, QuantitySource

COG, MASS = "cog_offset_mm", "mass_g"


class ShapeNumbers(QuantitySource):
    """Offset of the centre of gravity, and mass."""

    names: ClassVar = (COG, MASS)

    def add(self, outcome: Outcome, wanted: Sequence[Quantity], design: AskedDesign) -> None:
        from dolfingrip.experiments.derivatives.gradients import shape_number
        from dolfingrip.experiments.derivatives.sensitivities import choices, chosen

        keys = design.keys
        parameters = None if keys is None else chosen(design.config, keys)
        assert outcome.gradients is not None
        for quantity in wanted:
            value, slopes = shape_number(quantity.name, design.config, parameters)
            for choice in choices(design.config, keys):
                other, _ = shape_number(quantity.name, choice.other, ())
                slopes[choice.label] = choice.difference(value, other)
            outcome.outputs[str(quantity)], outcome.gradients[str(quantity)] = value, slopes
