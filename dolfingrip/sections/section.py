"""The base class of all tables of the configuration: sections and model extensions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, NoReturn

from pydantic import BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from dolfingrip.sections.errors import ConfigError

Vector = Annotated[tuple[float, float, float], Field(strict=False)]
"""Type of a list of numbers: TOML's arrays are lists, and their numbers are checked."""


class Section(BaseModel):
    """A table of the TOML file: no unknown keys, no silent conversions, immutable.

    Attributes:
        entries: class of the tables below it whose names a user chooses; None if there are none.
    """

    entries: ClassVar[type[BaseModel] | None] = None

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse a change, in one line.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(
            f"{name} = {value}: a configuration does not change; allowed: a changed copy, "
            'config.overridden(["section.key=value"])'
        )


def with_keys_of(
    name: str, kinds: Iterable[type[BaseModel]], **choice: tuple[Any, Any]
) -> type[Section]:
    """A base class for a section that has one of several kinds.

    Args:
        name: of the class.
        kinds: a class for each kind, with its own keys; the section has those of all.
        choice: the key that chooses the kind: its type and its field.
    """
    keys: dict[str, Any] = dict(choice)
    for kind in kinds:
        keys |= {key: (info.annotation, info) for key, info in kind.model_fields.items()}
    return create_model(name, __base__=Section, **keys)


def outside(key: str, value: object, allowed: str) -> PydanticCustomError:
    """The error that a validator raises about ``key``, a key of the section or below it."""
    return PydanticCustomError("geometry", f"{key} = {value}: {allowed}")


def check_up_to(section: Section, key: str, limit: str, unit: str = "") -> None:
    """Raise the error of :func:`outside` if the value of ``key`` exceeds that of ``limit``."""
    value, most = getattr(section, key), getattr(section, limit)
    if value > most:
        raise outside(key, value, f"allowed: above 0 and up to {limit} = {most:g} {unit}".rstrip())
