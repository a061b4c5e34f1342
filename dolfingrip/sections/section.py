"""A table of the configuration: what all sections and model extensions have in common."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

Vector = Annotated[tuple[float, float, float], Field(strict=False)]
"""TOML's arrays are lists; the numbers in them stay checked."""


class Section(BaseModel):
    """A table of the TOML file: no unknown keys, no silent conversions, immutable.

    Attributes:
        entries: class of the tables below it whose names a user chooses; None where there are none.
    """

    entries: ClassVar[type[BaseModel] | None] = None

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


def outside(key: str, value: object, allowed: str) -> PydanticCustomError:
    """What a validator raises about ``key``, a key of the section or below it."""
    return PydanticCustomError("geometry", f"{key} = {value}: {allowed}")


def check_up_to(section: Section, key: str, limit: str, unit: str = "") -> None:
    """Raise the error of :func:`outside` where the value of ``key`` exceeds that of ``limit``."""
    value, most = getattr(section, key), getattr(section, limit)
    if value > most:
        raise outside(key, value, f"allowed: above 0 and up to {limit} = {most:g} {unit}".rstrip())
