"""Sections of the configuration for the test procedure: experiment, cavities, protocol, coupon.

>>> cavities = Cavities.model_validate({"cavity_2": {"pressure_ratio": 0.5}})
>>> cavities.ratio("cavity"), cavities.ratio("cavity_2")
(1.0, 0.5)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, model_validator

from dolfingrip.channels import AMBIENT_KPA, VACUUM_KPA
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.section import FINGERS, Numbers, Ratio, Refusal, Role, Section

Branch = Literal["loading", "unloading", "hold"]
Times = Annotated[tuple[Annotated[float, Field(ge=0)], ...], Field(strict=False)]
Cycles = Annotated[tuple[Annotated[int, Field(ge=1, le=1_000_000)], ...], Field(strict=False)]
Branches = Annotated[tuple[Branch, ...], Field(strict=False)]


def branch_of(before: float, value: float) -> Branch:
    """Return the branch of a control that goes from one value to another.

    Args:
        before: value that it comes from, of either sign, in its unit.
        value: value that it comes to.

    Returns:
        ``loading`` where it goes away from 0, as also suction does; ``unloading`` where it comes
        back towards 0.
    """
    crosses = before * value < 0
    return "loading" if crosses or abs(value) >= abs(before) else "unloading"


STEP_KPA = 25.0
"""Default pressure between readings."""

NO_VACUUM = f"below absolute vacuum; allowed: from {VACUUM_KPA:g} kPa on"
"""Why a lower pressure is refused."""


class ExperimentSettings(Section):
    """Readings to take, in order: from rest to the maximum, and back if asked."""

    role: ClassVar = Role.PROCEDURE
    later: ClassVar = {"snaps": True, "min_pressure_kPa": 0.0, "dynamic": False}

    control: Literal["pressure", "volume", "auto"] = Field(
        "pressure",
        description="what is prescribed; volume control passes limit points; auto: the pressure "
        "until it cannot be raised, from there on the volume",
    )
    snaps: bool = Field(
        True,
        description="under pressure control: go on to another stable state, if there is one, where "
        "the pressure has a maximum; false: end there at once, unless the jump is small",
    )
    max_pressure_kPa: float = Field(
        250.0, le=10_000, description="highest pressure; below 0: suction alone, down to it"
    )
    min_pressure_kPa: float = Field(
        0.0, le=0, description="suction that each cycle goes to and back from before the maximum"
    )
    step_kPa: float = Field(
        STEP_KPA, gt=0, description="a reading every so much; by default at most the maximum"
    )
    max_volume_ratio: Ratio = Field(
        2.0, gt=1, le=1000, description="volume control: largest cavity, relative to rest"
    )
    step_volume_ratio: Ratio = Field(
        0.1, gt=0, le=10, description="volume control: a reading every so much"
    )
    unload: bool = Field(False, description="go back to rest in the same steps")
    rate_kPa_per_s: float = Field(25.0, gt=0, description="ramp; felt by models with a clock only")
    cycles: int = Field(1, ge=1, le=10_000, description="how often; more than one unloads, too")
    hold_s: float = Field(0.0, ge=0, description="wait at the maximum of each cycle")
    rest_s: float = Field(0.0, ge=0, description="wait unpressurised after each cycle")
    dynamic: bool = Field(False, description="with inertia, in the time of ramps and waits")
    hold_readings: int = Field(
        4,
        ge=1,
        le=1000,
        description="readings of a wait, ever sparser; even if dynamic",
    )

    @model_validator(mode="before")
    @classmethod
    def _short_steps(cls, data: Any) -> Any:
        """Shorten the default step if the largest pressure is smaller."""
        if not isinstance(data, dict) or "step_kPa" in data:
            return data
        ends = [data.get(key, 0.0) for key in ("max_pressure_kPa", "min_pressure_kPa")]
        if "max_pressure_kPa" in data and all(isinstance(end, int | float) for end in ends):
            largest = float(max(map(abs, ends)))
            if 0 < largest < STEP_KPA:
                return {**data, "step_kPa": largest}
        return data

    @property
    def largest_kPa(self) -> float:
        """Largest pressure or suction."""
        return max(abs(self.max_pressure_kPa), abs(self.min_pressure_kPa))

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        for key in ("max_pressure_kPa", "min_pressure_kPa"):
            if getattr(self, key) < VACUUM_KPA:
                yield Refusal(key, NO_VACUUM)
        if not self.largest_kPa:
            yield Refusal("max_pressure_kPa", "allowed: any pressure but 0 kPa")
        if self.max_pressure_kPa < 0 and self.min_pressure_kPa:
            yield Refusal("min_pressure_kPa", "allowed: 0 with a max_pressure_kPa below 0 kPa")
        raised = self.max_pressure_kPa == self.largest_kPa
        yield from self.up_to("step_kPa", "max_pressure_kPa" if raised else self.largest_kPa)
        if self.control != "pressure" and min(self.max_pressure_kPa, self.min_pressure_kPa) < 0:
            yield Refusal("control", 'allowed with suction: "pressure"')
        if self.dynamic and self.control != "pressure":
            yield Refusal("control", 'allowed with dynamic: "pressure"')
        if self.control == "auto" and (self.unload or self.cycles > 1):
            yield Refusal(
                "control", 'allowed with unload or cycles: "pressure" or "volume"', "auto"
            )


class Protocol(Section):
    """Readings at given times, instead of the experiment's ramps; made by --protocol."""

    role: ClassVar = Role.PROCEDURE

    time_s: Times = Field((), description="of each reading, none earlier than the one before")
    pressure_kPa: Numbers = Field((), description="of each reading (finger)")
    volume_ml: Numbers = Field((), description="put in by a pump, of each reading (finger)")
    displacement_mm: Numbers = Field((), description="of each reading (coupon)")
    cycle: Cycles = Field((), description="of each reading; default: 1")
    branch: Branches = Field((), description="of each reading; default: from its neighbour")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        controls = ("displacement_mm", "volume_ml", "pressure_kPa")
        control = next((key for key in controls if getattr(self, key)), controls[-1])
        for key in (control, "cycle", "branch"):
            if key == control or getattr(self, key):
                yield from self.as_many(key, "time_s")
        if min(self.pressure_kPa, default=0.0) < VACUUM_KPA:
            yield Refusal("pressure_kPa", NO_VACUUM, min(self.pressure_kPa))
        late = [b for a, b in pairwise(self.time_s) if b < a]
        if late:
            yield Refusal("time_s", "allowed: no earlier than the one before", f"… {late[0]:g}")


class CouponSettings(Section):
    """Uniaxial tension of a bar of the gauge length, which is pulled at one end."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = ("bar",)

    gauge_length_mm: float = Field(33.0, gt=0, le=1000, description="length that is stretched")
    width_mm: float = Field(3.0, gt=0, le=500, description="of the cross-section")
    thickness_mm: float = Field(3.0, gt=0, le=500, description="of the cross-section")
    grip: Literal["sliding", "clamped"] = Field(
        "sliding", description="ends free to narrow (uniform stretch) or held fast"
    )
    max_strain: Ratio = Field(0.5, gt=0, le=10, description="largest nominal strain")
    step_strain: Ratio = Field(0.05, gt=0, le=10, description="a reading every so much")
    rate_mm_per_s: float = Field(2.5, gt=0, description="crosshead; felt by models with a clock")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        yield from self.up_to("step_strain", "max_strain")

    @property
    def area_mm2(self) -> float:
        """Undeformed cross-section."""
        return self.width_mm * self.thickness_mm


class Cavity(Section):
    """One of several cavities: a part of the experiment's pressure, its own supply, or air."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = FINGERS
    later: ClassVar = {
        "closed": False, "closed_at_kPa": AMBIENT_KPA, "exponent": 1.0, "pressure_kPa": [],
    }  # fmt: skip

    pressure_ratio: Ratio = Field(
        1.0, ge=-10, le=10, description="the cavity's pressure by the experiment's; 0: vented"
    )
    pressure_kPa: Numbers = Field(
        (), description="a supply of its own: its pressure at each time of the protocol"
    )
    closed: bool = Field(False, description="no supply: air is trapped in it")
    closed_at_kPa: float = Field(
        AMBIENT_KPA, gt=0, le=10_000, description="absolute pressure at which it was closed"
    )
    exponent: Ratio = Field(
        1.0, ge=1, le=2, description="n in p Vⁿ = const: 1 isothermal, 1.4 adiabatic"
    )

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if self.closed and self.pressure_ratio != 1:
            yield Refusal("pressure_ratio", "allowed: not beside closed = true")
        if self.pressure_kPa and (self.closed or self.pressure_ratio != 1):
            other = "closed = true" if self.closed else "a pressure_ratio"
            yield Refusal("pressure_kPa", f"allowed: not beside {other}")


class Cavities(Section):
    """Cavities by the group of a mesh file, as [cavity.cavity_2] is one."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = FINGERS
    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Cavity]
    entries: ClassVar = Cavity

    @property
    def all(self) -> Mapping[str, Cavity]:
        """The cavities that are named."""
        return self.__pydantic_extra__

    def of(self, name: str) -> Cavity:
        """Settings of a cavity, whether it is named or not."""
        return self.__pydantic_extra__.get(name, Cavity())

    def ratio(self, name: str) -> float:
        """A cavity's pressure by the experiment's; 1 if it is not named, 0 without that supply."""
        cavity = self.of(name)
        return 0.0 if cavity.closed or cavity.pressure_kPa else cavity.pressure_ratio

    @property
    def own(self) -> Mapping[str, Numbers]:
        """Pressures of the cavities with a supply of their own, by name."""
        return {
            name: cavity.pressure_kPa for name, cavity in self.all.items() if cavity.pressure_kPa
        }

    def refuse_own(self, who: str) -> None:
        """Refuse cavities with a supply of their own.

        Args:
            who: cannot follow them.

        Raises:
            ConfigError: one line, if there is one.
        """
        for name in self.own:
            raise ConfigError(
                f"cavity.{name}.pressure_kPa: {who} has no supply of its own for a cavity; "
                "allowed: a pressure_ratio"
            )
