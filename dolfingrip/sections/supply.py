"""The supply of air: source, valve, tube, leak and gauge, and boards by name."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar, Final, Literal

from pydantic import Field, model_validator

from dolfingrip.channels import VACUUM_KPA
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.section import (
    FINGERS,
    Entry,
    Numbers,
    Ratio,
    Refusal,
    Role,
    Section,
    outside,
)

FILE: Final = Path(__file__).with_name("boards.toml")
"""The boards by name, each with its source."""


def refuse_supply(supply: AirLine | None) -> None:
    """Refuse a supply of air where the pressure is prescribed.

    Args:
        supply: of the configuration.

    Raises:
        ConfigError: one line, if there is one.
    """
    if supply is not None:
        why = "the pressure is prescribed here; allowed: with bend, force, cycle and grasp"
        raise ConfigError(f"supply = a table: {why}")


def with_valve(supply: AirLine | None) -> AirLine:
    """Return a supply that is asked for pressures.

    Args:
        supply: of the configuration.

    Raises:
        ConfigError: one line, if there is none, or it is a syringe.
    """
    if supply is None or supply.source == "syringe":
        shown = "none" if supply is None else '"syringe"'
        raise ConfigError(f'supply.source = {shown}: allowed: "ideal", "pump", "tank"')
    return supply


@cache
def boards() -> Mapping[str, Mapping[str, Any]]:
    """Return the keys of each board by its name; ``source_of_numbers`` says where they are from."""
    return tomllib.loads(FILE.read_text(encoding="utf-8"))


class AirLine(Section):
    """The way of the air from its source through a valve and a tube into the finger's cavities."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = FINGERS
    entry: ClassVar = dict.fromkeys(
        ("tank_cm3", "tank_kPa", "valve_dm3_per_s_bar", "valve_b", "exhaust_dm3_per_s_bar",
         "exhaust_b", "duty", "band_kPa", "tube_dm3_per_s_bar", "tube_b", "tube_cm3", "leak_mm",
         "leak_growth_mm2", "gauge_part", "exponent"),
        Entry.SUPPLY,
    )  # fmt: skip

    board: str = Field("", description="a board by name, whose numbers are the defaults below")
    source: Literal["ideal", "pump", "tank", "syringe"] = Field(
        "ideal",
        description="has the prescribed pressure itself; or fills the tube up to it through a "
        "valve; a syringe, under volume control, displaces what is prescribed",
    )
    pump_kPa: Numbers = Field((), description="of a pump's curve: its pressures, from 0 on")
    pump_l_per_min: Numbers = Field(
        (), description="of a pump's curve: its flow of free air at each pressure, down to 0"
    )
    tank_cm3: float = Field(1000.0, gt=0, le=1e6, description="volume of a tank")
    tank_kPa: float = Field(400.0, gt=0, le=10_000, description="pressure in a tank at first")
    syringe_cm3: float = Field(
        60.0, gt=0, le=10_000, description="air in a syringe's barrel at first"
    )
    valve_dm3_per_s_bar: float = Field(
        0.1, gt=0, le=100, description="sonic conductance C of the valve by ISO 6358"
    )
    valve_b: Ratio = Field(0.3, ge=0, lt=1, description="its critical ratio of pressures")
    exhaust_dm3_per_s_bar: float | None = Field(
        None, gt=0, le=100, description="C of the exhaust; default: the same valve"
    )
    exhaust_b: Ratio | None = Field(None, ge=0, lt=1, description="its critical ratio")
    duty: Ratio = Field(
        1.0, gt=0, le=1, description="part of the time that an on-off valve is open at most"
    )
    band_kPa: float = Field(
        10.0, gt=0, le=1000, description="pump, tank: what the gauge lacks at full opening"
    )
    tube_dm3_per_s_bar: float = Field(0.3, gt=0, le=100, description="C of the tube")
    tube_b: Ratio = Field(0.3, ge=0, lt=1, description="its critical ratio of pressures")
    tube_cm3: float = Field(5.0, ge=0.01, le=10_000, description="dead volume of valve and tube")
    leak_mm: float = Field(0.0, ge=0, le=10, description="diameter of a hole in the cavity")
    leak_growth_mm2: float = Field(
        0.0, ge=0, le=50, description="area by which it grows with each tenfold number of cycles"
    )
    gauge_part: Ratio = Field(
        1.0, ge=0, le=1,
        description="part of the tube's resistance between gauge and cavity: 1 gauge at the valve",
    )  # fmt: skip
    exponent: Ratio = Field(
        1.0, ge=1, le=1.4, description="n in p Vⁿ = const: 1 isothermal, 1.4 adiabatic"
    )
    error_kPa: float = Field(
        0.1, ge=1e-6, le=10, description="error of a step's pressure, which sets its length"
    )

    @model_validator(mode="before")
    @classmethod
    def _of_board(cls, data: Any) -> Any:
        """Add the numbers of a board that is named."""
        name = data.get("board") if isinstance(data, dict) else None
        if not name:
            return data
        if name not in boards():
            raise outside("board", f'"{name}"', f"allowed: {', '.join(boards())}")
        return {**{k: v for k, v in boards()[name].items() if k != "source_of_numbers"}, **data}

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        pressures, flows = self.pump_kPa, self.pump_l_per_min
        if self.source == "pump" and len(pressures) < 2:
            yield Refusal("pump_kPa", "allowed: two pressures or more of a pump's curve", "none")
        yield from self.as_many("pump_l_per_min", "pump_kPa")
        if any(b <= a for a, b in pairwise(pressures)) or min(pressures, default=0.0) < VACUUM_KPA:
            yield Refusal("pump_kPa", "allowed: each above the one before", list(pressures))
        falls = all(b <= a for a, b in pairwise(flows)) and not any(flows[-1:])
        if not falls or min(flows, default=0.0) < 0:
            yield Refusal("pump_l_per_min", "allowed: falling, and 0 at last", list(flows))

    @property
    def most_kPa(self) -> float:
        """Highest pressure that the source has; infinite where it is prescribed."""
        return {
            "pump": max(self.pump_kPa, default=0.0), "tank": self.tank_kPa
        }.get(self.source, float("inf"))  # fmt: skip
