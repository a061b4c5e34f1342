"""Sections of the configuration for the test procedure: experiment, protocol, coupon."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from dolfingrip.sections.section import Role, Section, check_up_to, outside

Branch = Literal["loading", "unloading", "hold"]
Times = Annotated[tuple[Annotated[float, Field(ge=0)], ...], Field(strict=False)]
Values = Annotated[tuple[float, ...], Field(strict=False)]
Cycles = Annotated[tuple[Annotated[int, Field(ge=1)], ...], Field(strict=False)]
Branches = Annotated[tuple[Branch, ...], Field(strict=False)]

STEP_KPA = 25.0
"""Default pressure between readings."""


class Experiment(Section):
    """Readings to take, in order: from rest to the maximum, and back if asked."""

    role: ClassVar = Role.PROCEDURE
    later: ClassVar = {"snaps": True}

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
    max_pressure_kPa: float = Field(250.0, gt=0, le=10_000, description="highest pressure")
    step_kPa: float = Field(
        STEP_KPA, gt=0, description="a reading every so much; by default at most the maximum"
    )
    max_volume_ratio: float = Field(
        2.0, gt=1, le=1000, description="volume control: largest cavity, relative to rest"
    )
    step_volume_ratio: float = Field(
        0.1, gt=0, le=10, description="volume control: a reading every so much"
    )
    unload: bool = Field(False, description="go back to rest in the same steps")
    rate_kPa_per_s: float = Field(25.0, gt=0, description="ramp; felt by models with a clock only")
    cycles: int = Field(1, ge=1, le=10_000, description="how often; more than one unloads, too")
    hold_s: float = Field(0.0, ge=0, description="wait at the maximum of each cycle")
    rest_s: float = Field(0.0, ge=0, description="wait unpressurised after each cycle")
    hold_readings: int = Field(4, ge=1, le=1000, description="readings of a wait, ever sparser")

    @model_validator(mode="before")
    @classmethod
    def _short_steps(cls, data: Any) -> Any:
        """Shorten the default step if the highest pressure is lower."""
        if not isinstance(data, dict) or "step_kPa" in data:
            return data
        highest = data.get("max_pressure_kPa")
        if isinstance(highest, int | float) and 0 < highest < STEP_KPA:
            return {**data, "step_kPa": float(highest)}
        return data

    @model_validator(mode="after")
    def _steps(self) -> Experiment:
        check_up_to(self, "step_kPa", "max_pressure_kPa", "kPa")
        if self.control == "auto" and (self.unload or self.cycles > 1):
            raise outside(
                "control", "auto", 'allowed with unload or cycles: "pressure" or "volume"'
            )
        return self


class Protocol(Section):
    """Readings at given times, instead of the experiment's ramps; made by --protocol."""

    role: ClassVar = Role.PROCEDURE

    time_s: Times = Field((), description="of each reading, none earlier than the one before")
    pressure_kPa: Values = Field((), description="of each reading (finger)")
    displacement_mm: Values = Field((), description="of each reading (coupon)")
    cycle: Cycles = Field((), description="of each reading; default: 1")
    branch: Branches = Field((), description="of each reading; default: from its neighbour")

    @model_validator(mode="after")
    def _table(self) -> Protocol:
        count = len(self.time_s)
        control = "displacement_mm" if self.displacement_mm else "pressure_kPa"
        for key in (control, "cycle", "branch"):
            values = getattr(self, key)
            if len(values) != count and (values or key == control):
                raise outside(
                    key, f"{len(values)} values", f"allowed: as many as time_s has, {count}"
                )
        late = [b for a, b in pairwise(self.time_s) if b < a]
        if late:
            raise outside("time_s", f"… {late[0]:g}", "allowed: no earlier than the one before")
        return self


class Coupon(Section):
    """Uniaxial tension of a bar of the gauge length, which is pulled at one end."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = ("bar",)

    gauge_length_mm: float = Field(33.0, gt=0, le=1000, description="length that is stretched")
    width_mm: float = Field(3.0, gt=0, le=500, description="of the cross-section")
    thickness_mm: float = Field(3.0, gt=0, le=500, description="of the cross-section")
    grip: Literal["sliding", "clamped"] = Field(
        "sliding", description="ends free to narrow (uniform stretch) or held fast"
    )
    max_strain: float = Field(0.5, gt=0, le=10, description="largest nominal strain")
    step_strain: float = Field(0.05, gt=0, le=10, description="a reading every so much")
    rate_mm_per_s: float = Field(2.5, gt=0, description="crosshead; felt by models with a clock")

    @model_validator(mode="after")
    def _steps(self) -> Coupon:
        check_up_to(self, "step_strain", "max_strain")
        return self

    @property
    def area_mm2(self) -> float:
        """Undeformed cross-section."""
        return self.width_mm * self.thickness_mm
