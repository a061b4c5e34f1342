"""The air line of a configuration, in the units of the mechanics, and what is read of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar, Final

from dolfingrip.channels import AIR_SUPPLY, AMBIENT_KPA
from dolfingrip.config import KPA
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.pneumatics import (
    CAVITY,
    LEAK,
    MG_PER_MM3,
    SOURCE,
    THROUGH,
    TUBE,
    Line,
    Pump,
    Restriction,
)
from dolfingrip.mechanics.newton.air_supply import AirSupply
from dolfingrip.mechanics.readings.reading import Reading
from dolfingrip.sections.supply import AirLine

MM3: Final = 1000.0
"""mm³ per cm³."""
MM3_PER_S: Final = 1e6 / 60
"""mm³/s per l/min."""
MM3_PER_S_MPA: Final = 1e7
"""mm³/(s MPa) per dm³/(s bar)."""


def line_of(supply: AirLine) -> Line:
    """Return the line of a configuration's supply.

    Args:
        supply: of the configuration.
    """
    ambient = AMBIENT_KPA * KPA
    valve = Restriction(MM3_PER_S_MPA * supply.valve_dm3_per_s_bar, supply.valve_b)
    exhaust = valve
    if supply.exhaust_dm3_per_s_bar is not None:
        exhaust = replace(valve, conductance=MM3_PER_S_MPA * supply.exhaust_dm3_per_s_bar)
    if supply.exhaust_b is not None:
        exhaust = replace(exhaust, critical=supply.exhaust_b)
    pump = None
    if supply.source == "pump":
        pressures = [kPa * KPA + ambient for kPa in supply.pump_kPa]
        pump = Pump(pressures, [MM3_PER_S * flow for flow in supply.pump_l_per_min])
    tank = supply.source == "tank"
    return Line(
        valve,
        exhaust,
        Restriction(MM3_PER_S_MPA * supply.tube_dm3_per_s_bar, supply.tube_b),
        MM3 * supply.tube_cm3,
        Restriction.orifice(supply.leak_mm) if supply.leak_mm or supply.leak_growth_mm2 else None,
        pump,
        MM3 * supply.tank_cm3 if tank else 0.0,
        supply.tank_kPa * KPA + ambient if tank else 0.0,
        supply.exponent,
        supply.duty,
        supply.band_kPa * KPA,
        supply.gauge_part,
        ambient,
        leak_growth=Restriction.orifice(
            2 * math.sqrt(supply.leak_growth_mm2 / math.pi)
        ).conductance,
    )


class OfSupply(Reading):
    """A number of the supply at the last load step's end.

    Args:
        model: model that is read.
        column: name in the table, with its unit.
        number: returns it, in this unit.
    """

    differentiable: ClassVar = False

    def __init__(self, model: Model, column: str, number: Callable[[], float]) -> None:
        super().__init__(model, column)
        self._number = number

    def value(self) -> float:
        return self._number()


FILLINGS: Final = 10.0
"""Longest step in time with a supply of air, by the time in which it fills the cavity once."""


def longest_step_s(supply: AirSupply) -> float:
    """Return the longest step in time of a model with a supply.

    Args:
        supply: at rest.
    """
    return FILLINGS * supply.filling_s()


def of_supply(model: Model, supply: AirSupply) -> list[Reading]:
    """Return the readings of a supply, one for each of :data:`~dolfingrip.channels.AIR_SUPPLY`.

    Args:
        model: model that is read.
        supply: a term of the model.
    """
    air = supply.air

    def gauge_kPa(place: int) -> float:
        return float(air.now.pressures[place] - air.line.ambient) / KPA

    numbers = (
        lambda: gauge_kPa(SOURCE),
        lambda: gauge_kPa(TUBE),
        lambda: air.line.gauged(gauge_kPa(TUBE), gauge_kPa(CAVITY)),
        lambda: float(air.now.flows[THROUGH] - air.now.flows[LEAK]) / MM3_PER_S,
        lambda: MG_PER_MM3 * supply.held_mm3(),
        supply.balance_error,
    )
    pairs = zip(AIR_SUPPLY, numbers, strict=True)
    return [OfSupply(model, channel.name, number) for channel, number in pairs]
