"""The base class of all tables of the configuration: sections and model extensions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import Annotated, Any, ClassVar, Final, NoReturn, get_args

from pydantic import BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from dolfingrip.channels import Part
from dolfingrip.sections import errors
from dolfingrip.sections.errors import ConfigError

Vector = Annotated[tuple[float, float, float], Field(strict=False)]
"""Type of a list of numbers: TOML's arrays are lists, and their numbers are checked."""


EVERYWHERE: Final[tuple[Part, ...]] = get_args(Part)
"""Parts of all experiments."""

FINGERS: Final[tuple[Part, ...]] = ("finger", "gripper")
"""Parts of the experiments on fingers, single ones and those of a gripper."""


class Role(StrEnum):
    """The thing that a section of the configuration describes."""

    BODY = "body"
    SETUP = "set-up"
    INSTRUMENT = "instrument"
    PROCEDURE = "procedure"
    NUMERICS = "numerics"
    EXTENSIONS = "extensions"


class Entry(StrEnum):
    """How a number enters a simulation; a choice of the model has no derivative."""

    CONSTANT = "constant of a term"
    SHAPE = "reference mesh"
    POSE = "pose of the plate"
    SUPPLY = "stage of the supply"
    INSTRUMENT = "instrument"
    CHOICE = "choice of the model"


class Section(BaseModel):
    """A table of the TOML file: no unknown keys, no silent conversions, immutable.

    Attributes:
        role: the thing that it describes.
        felt_by: parts of rigs that feel it; an experiment on any of these depends on it.
        entry: how its numbers enter a simulation, by key where they differ; the other keys are
            choices of the model.
        effort: keys that say how a solution is found and what that may take. No result depends on
            them.
        later: keys that are newer than stored results. They count only where they differ from these
            values, so that older results are still found.
        entries: class of the tables below it whose names a user chooses; None if there are none.
    """

    role: ClassVar[Role]
    felt_by: ClassVar[tuple[Part, ...]] = EVERYWHERE
    entry: ClassVar[Entry | Mapping[str, Entry]] = Entry.CHOICE
    effort: ClassVar[tuple[str, ...]] = ()
    later: ClassVar[Mapping[str, Any]] = {}
    entries: ClassVar[type[Section] | None] = None

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse a change, in one line.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(
            f"{name} = {value}: a configuration does not change; allowed: a changed copy, "
            'config.changed(config, {"section.key": value})'
        )

    @classmethod
    def felt_on(cls, parts: Iterable[Part]) -> bool:
        """Return whether an experiment on these parts depends on the section."""
        return not set(parts).isdisjoint(cls.felt_by)

    @classmethod
    def entry_of(cls, key: str) -> Entry:
        """Return how a number of the section enters a simulation."""
        return cls.entry if isinstance(cls.entry, Entry) else cls.entry.get(key, Entry.CHOICE)

    @classmethod
    def is_modulus(cls, key: str) -> bool:
        """Return whether a number is in proportion to the stiffness of the material."""
        return False

    @property
    def inner(self) -> Mapping[str, Section]:
        """Tables in it whose names a user chose, by name."""
        return self.model_extra or {}

    def movable(self, key: str) -> bool:
        """Return whether the model follows a change of this number alone."""
        return True

    @classmethod
    def counted(cls, values: Mapping[str, Any], parts: Iterable[Part]) -> dict[str, Any]:
        """Return those of a table's values that an experiment's result depends on.

        Args:
            values: as plain data.
            parts: of the experiment.
        """
        found: dict[str, Any] = {}
        for key, value in values.items():
            inner = errors.table([key], cls)
            if isinstance(value, Mapping) and inner.felt_on(parts):
                found[key] = inner.counted(value, parts)
            elif not isinstance(value, Mapping) and value is not None and key not in cls.effort:
                found[key] = value
        return {k: v for k, v in found.items() if k not in cls.later or v != cls.later[k]}


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
