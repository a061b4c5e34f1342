"""The base class of all tables of the configuration: sections and model extensions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from enum import StrEnum
from typing import Annotated, Any, ClassVar, Final, NamedTuple, NoReturn, Self, get_args

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator
from pydantic_core import PydanticCustomError

from dolfingrip import plugins
from dolfingrip.channels import Part
from dolfingrip.sections import errors, ranges, tables
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.ranges import PURE
from dolfingrip.sections.units import unit

Ratio = Annotated[float, PURE]
"""Type of a number without a unit: a ratio, an exponent, a strain. Names of others end in one."""

Numbers = Annotated[tuple[float, ...], Field(strict=False)]
"""Type of a list of numbers of any length."""

Vector = Annotated[tuple[float, float, float], Field(strict=False)]
"""Type of a list of numbers: TOML's arrays are lists, and their numbers are checked."""


PLUGGED: Final[dict[str, Any]] = {"plugin": True}
"""Note of a key whose choices plugins add to, for messages."""

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


class Refusal(NamedTuple):
    """A value that is not allowed beside the others of a section.

    Attributes:
        key: of the section or below it.
        allowed: what is wrong, and what is allowed, in words.
        shown: in place of the value; None: the value itself.
    """

    key: str
    allowed: str
    shown: object = None


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
        extensible: whether plugins add keys to it.
    """

    role: ClassVar[Role]
    felt_by: ClassVar[tuple[Part, ...]] = EVERYWHERE
    entry: ClassVar[Entry | Mapping[str, Entry]] = Entry.CHOICE
    effort: ClassVar[tuple[str, ...]] = ()
    later: ClassVar[Mapping[str, Any]] = {}
    entries: ClassVar[type[Section] | None] = None
    extensible: ClassVar[bool] = False

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True
    )

    @classmethod
    def __pydantic_init_subclass__(cls, **_: object) -> None:
        """Give every number the range of its unit, which its name has in the configuration."""
        for key, info in cls.model_fields.items():
            ranges.narrow(key, info, named=hasattr(cls, "role"))

    def __repr_args__(self) -> list[tuple[str | None, Any]]:
        """Keys as ``repr`` shows them, without those that are not given."""
        return [(key, value) for key, value in super().__repr_args__() if value is not None]

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse a change, in one line.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(
            f"{name} = {value}: a configuration does not change; allowed: a changed copy, "
            'config.changed(config, {"section.key": value})'
        )

    def refusals(self) -> Iterator[Refusal]:
        """Yield the values that are not allowed beside the others; each is in its own range.

        The first one becomes the error, so that later ones may rely on what earlier ones checked.
        """
        yield from ()

    @model_validator(mode="after")
    def _allowed(self) -> Self:
        for key, allowed, shown in self.refusals():
            raise outside(key, self.shown(key) if shown is None else shown, allowed)
        return self

    def shown(self, key: str) -> object:
        """Return a value as messages show it.

        Args:
            key: of the section or below it.
        """
        value: Any = self
        for part in key.split("."):
            value = getattr(value, part)
        return list(value) if isinstance(value, tuple) else "none" if value is None else value

    def up_to(self, key: str, most: float | str, why: str = "") -> Iterator[Refusal]:
        """Yield a refusal of a number that is larger than a limit.

        Args:
            key: of the number.
            most: the limit, or the key of a number that is it.
            why: what is wrong beyond the limit, in words.
        """
        limit, words = self._limit(key, most)
        if getattr(self, key) > limit:
            yield Refusal(key, f"{why}allowed: above 0 and up to {words}")

    def below(self, key: str, limit: float | str, why: str = "") -> Iterator[Refusal]:
        """Yield a refusal of a number that is not smaller than a limit.

        Args:
            key: of the number.
            limit: the limit, or the key of a number that is it.
            why: what is wrong from the limit on, in words.
        """
        least, words = self._limit(key, limit)
        if getattr(self, key) >= least:
            yield Refusal(key, f"{why}allowed: above 0 and below {words}")

    def above(self, key: str, limit: float | str, why: str = "") -> Iterator[Refusal]:
        """Yield a refusal of a number that is not larger than a limit.

        Args:
            key: of the number.
            limit: the limit, or the key of a number that is it.
            why: what is wrong down from the limit, in words.
        """
        most, words = self._limit(key, limit)
        if getattr(self, key) <= most:
            yield Refusal(key, f"{why}allowed: above {words}")

    def as_many(self, key: str, other: str) -> Iterator[Refusal]:
        """Yield a refusal of a list that is not as long as another one.

        Args:
            key: of the list.
            other: key of the other one.
        """
        given, count = len(getattr(self, key)), len(getattr(self, other))
        if given != count:
            yield Refusal(key, f"allowed: as many as {other} has, {count}", f"{given} values")

    def directed(self, key: str) -> Iterator[Refusal]:
        """Yield a refusal of a vector without a direction.

        Args:
            key: of the vector.
        """
        if not any(getattr(self, key)):
            yield Refusal(key, "allowed: any vector but zero")

    def _limit(self, key: str, limit: float | str) -> tuple[float, str]:
        """A limit of a key, and its words."""
        name, value = (
            (f"{limit} = ", getattr(self, limit)) if isinstance(limit, str) else ("", limit)
        )
        return value, f"{name}{value:g} {unit(key)}".rstrip()

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

    @property
    def unused(self) -> Collection[str]:
        """Keys that do nothing beside the others."""
        return ()

    def number_at(self, key: str) -> float:
        """Return a number in this table or below it.

        Args:
            key: names with points between them; entries of a list are numbered from 0 in brackets.
        """
        value: Any = self
        for part in tables.parts(key):
            value = value[part] if isinstance(part, int) else getattr(value, part)
        return float(value)

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
        kept: dict[str, Any] = {}
        for key, value in values.items():
            if isinstance(value, Mapping):
                inner, *_ = errors.kinds([key], cls)
                if inner.felt_on(parts):
                    kept[key] = inner.counted(value, parts)
            elif value is not None and key not in cls.effort:
                kept[key] = value
        kept = {k: v for k, v in kept.items() if k not in cls.later or v != cls.later[k]}
        digests = plugins.digests(*cls.made_of(values))
        return {**kept, "plugin": digests} if digests else kept

    @classmethod
    def made_of(cls, values: Mapping[str, Any]) -> tuple[type, ...]:
        """Return the classes whose code a result depends on: this one, and a kind that it names.

        Args:
            values: of the table, as plain data.
        """
        return (cls,)


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
        for key, info in kind.model_fields.items():
            if key in keys and keys[key][1].default != info.default:
                why = f"{key}: a key of another kind, with the default {keys[key][1].default}"
                raise plugins.PluginError(f"{kind.__name__}: {why}; allowed: another name")
            keys[key] = (info.annotation, info)
    return create_model(name, __base__=Section, **keys)


def outside(key: str, value: object, allowed: str) -> PydanticCustomError:
    """Return the error that a validator raises about a value.

    Args:
        key: of the section or below it.
        value: as the message shows it.
        allowed: what is wrong, and what is allowed, in words.
    """
    return PydanticCustomError("geometry", f"{key} = {value}: {allowed}")
