"""Readings that need nothing but the model, found by their channels."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from dolfingrip.channels import Part, read_of
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.readings.reading import FromRest, Reading
from dolfingrip.sections.lookup import only_class


def of_model(model: Model, *parts: Part) -> list[Reading]:
    """Readings that need the model alone.

    Args:
        model: model that is read.
        parts: parts of a set-up whose channels are read.

    Returns:
        One reading for each of these channels that names a file of this package.
    """
    found = []
    for channel in read_of(*parts):
        if channel.reading:
            kind = only_class(f"dolfingrip.mechanics.readings.{channel.reading}", Reading)
            reading = cast(Callable[[Model], Reading], kind)(model)
            found.append(FromRest(reading) if channel.from_rest else reading)
    return found
