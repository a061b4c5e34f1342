"""The index of the kinds of quantities: files of this folder, and plugins."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from dolfingrip import plugins
from dolfingrip.channels import CHANNELS
from dolfingrip.config import ConfigError
from dolfingrip.design.quantities.quantity import UNITS, Places, Quantity, QuantitySource
from dolfingrip.experiments.index import find
from dolfingrip.sections.lookup import classes

FILES: Final = (
    "shape",
    "readings",
    "grasp",
)

SOURCES: Final[tuple[QuantitySource, ...]] = tuple(
    kind()
    for kind in classes(
        "quantities", "dolfingrip.design.quantities", FILES, QuantitySource
    ).values()
)


def source(name: str, said: str) -> QuantitySource:
    """Return what computes the quantity of a name.

    Args:
        name: of a quantity, without a place.
        said: option with the name, for messages.

    Returns:
        Its source.

    Raises:
        ConfigError: one line that lists the allowed names.
    """
    for candidate in SOURCES:
        if name in candidate.names:
            return candidate
    allowed = ", ".join(name for candidate in SOURCES for name in candidate.names)
    raise ConfigError(f"{said}: allowed: {allowed}; {plugins.hint('')}")


def quantity(said: str, name: str, places: Places, experiment: str | None = None) -> Quantity:
    """Return the quantity of a name at a place.

    Args:
        said: option with the name, for messages.
        name: of the quantity.
        places: for each column the values at which it is read.
        experiment: that is run instead of the usual one.

    Returns:
        The quantity.

    Raises:
        ConfigError: one line, where there is no such quantity.
    """
    return source(name, said).quantity(said, name, places, experiment)


def parse(text: str, option: str = "--quantity") -> Quantity:
    """Read a quantity from its text.

    >>> str(parse("force_N at 250 kPa")), parse("mass_g").experiment
    ('force_N at 250 kPa', None)
    >>> parse("angle_deg at 100, 200 kPa in blocked_force").values
    (100.0, 200.0)

    Args:
        text: a name; then, where it is read: ``at`` values, and the unit of a pressure, a force or
            an angle; then ``in`` an experiment, if it is not the usual one.
        option: that it is given by, for messages.

    Returns:
        The quantity.

    Raises:
        ConfigError: one line, where there is no such quantity.
    """
    said = f"{option} {text}"
    placed, _, experiment = text.partition(" in ")
    name, at, place = placed.partition(" at ")
    places: dict[str, tuple[float, ...]] = {}
    if at:
        *values, unit = place.replace(",", " ").split() or [""]
        try:
            places[UNITS[unit]] = tuple(map(float, values))
        except (KeyError, ValueError):
            places = {}
        if not any(places.values()):
            raise ConfigError(f"{said}: allowed: a place as in force_N at 250 kPa, 3 N or 30 deg")
    return quantity(said, name.strip(), places, experiment.strip() or None)


def plugins_of(texts: Iterable[str]) -> dict[str, str]:
    """Return the digests of the plugins that quantities are computed by, by module.

    Args:
        texts: of quantities; others than those of the index are passed over.
    """
    used: list[Any] = []
    for text in texts:
        placed, _, experiment = text.partition(" in ")
        name = placed.partition(" at ")[0].strip()
        used += [type(candidate) for candidate in SOURCES if name in candidate.names]
        used += [CHANNELS[name].reading] if name in CHANNELS else []
        used += [type(find(experiment.strip()))] if experiment else []
    return plugins.digests(*used)
