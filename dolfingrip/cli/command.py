"""A command: a dataclass of its settings, and the function that takes them.

The command line is made from the dataclass: a field is an option or an argument, its type says how
it is read, its default is shown, and its :class:`Setting` says the rest. What the function needs is
imported when it is called, so ``--help`` needs no solver.
"""

from __future__ import annotations

import importlib
import os
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from importlib.util import find_spec
from inspect import Parameter, Signature, cleandoc, get_annotations
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin, get_type_hints

import typer
from typer.core import TyperArgument, TyperCommand, TyperGroup

from dolfingrip.sections import errors
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.units import sized, unit

NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})
"""No values by key."""

LONGEST_NAME = 255
"""Bytes of a file's name, as file systems allow them."""

SHOWN = 40
"""Characters of a longer name that a message shows."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A setting of a command: how it is written, shown, read and checked.

    Attributes:
        help: one line.
        flags: names of the option; the field's name with dashes where there are none.
        argument: whether it is an argument, without a flag.
        metavar: name of the value; by default its unit, its choices, or what it is.
        measured_in: unit of the value, where neither the field nor ``key`` ends in one.
        key: key of the configuration that it sets, which says unit, choices and limits.
        least: smallest value.
        above: the value is larger than this.
        most: largest value.
        read: reads the texts of a repeatable option; it gets them and the option's name.
        name: of the field.
        type: of its value.
        default: its default; ``MISSING`` where it is required.
    """

    help: str
    flags: tuple[str, ...] = ()
    argument: bool = False
    metavar: str = ""
    measured_in: str = ""
    key: str = ""
    least: float | None = None
    above: float | None = None
    most: float | None = None
    read: Callable[[Sequence[str], str], Any] | None = None
    name: str = ""
    type: Any = None
    default: Any = None

    @property
    def flag(self) -> str:
        """Name by which messages know it."""
        if self.argument:
            return self.metavar or self.name.upper()
        return self.flags[0] if self.flags else f"--{self.name.replace('_', '-')}"

    @property
    def bare(self) -> Any:
        """Type of one value, without None and without the tuple of a repeatable option."""
        kind = _without_none(self.type)
        return get_args(kind)[0] if self.repeatable and get_origin(kind) is tuple else kind

    @property
    def repeatable(self) -> bool:
        """True where it can be given several times."""
        kind = _without_none(self.type)
        return self.read is not None or get_args(kind)[1:] == (...,)

    @property
    def choices(self) -> tuple[str, ...]:
        """The values of a ``Literal``."""
        return get_args(self.bare) if get_origin(self.bare) is Literal else ()

    @property
    def unit(self) -> str:
        """Unit of its value; "" for a pure number."""
        return self.measured_in or unit(self.name) or unit(self.key)

    @property
    def allowed(self) -> str:
        """Values that are allowed, in words; "" where any is."""
        if self.key:
            return _reason(self.key)
        limits = ((self.least, "at least"), (self.above, "above"), (self.most, "up to"))
        words = [f"{word} {value:.12g}" for value, word in limits if value is not None]
        return f"{' and '.join(words)} {self.unit}".strip() if words else ""

    def parameter(self) -> Parameter:
        """Return the parameter by which Typer knows it."""
        kind = str if self.choices else self.bare
        typed: Any = list[str] if self.read else list[kind] if self.repeatable else kind  # type: ignore[valid-type]
        default = Parameter.empty if self.default is MISSING else self.default
        if self.repeatable and default is not Parameter.empty:
            default = list(self.default) or None
        if default is None:
            typed |= None
        shown = f"{self.help} Allowed: {self.allowed}." if self.allowed else self.help
        if self.argument:
            declared: Any = typer.Argument(metavar=self.metavar or None, help=shown)
        else:
            flags = self.flags or (self.flag,)
            if self.bare is bool and self.default is not False and not self.flags:
                flags = (f"{self.flag}/--no-{self.flag[2:]}",)
            declared = typer.Option(*flags, metavar=self._metavar(), help=shown)
        annotation = Annotated[typed, declared]
        return Parameter(self.name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)

    def value(self, given: Any) -> Any:
        """Read and check what was given on the command line.

        Args:
            given: by Typer.

        Raises:
            ConfigError: one line naming the option, the value and what is allowed.
        """
        for text in given if isinstance(given, list) else [given]:
            if isinstance(text, str | Path):
                self._check_text(str(text))
        if self.read is not None:
            return self.read(given or (), self.flag)
        if not self.repeatable:
            return self._checked(given)
        return tuple(self._checked(entry) for entry in given or ())

    def _check_text(self, text: str) -> None:
        """Raise if no file could have such a name, or no file keep such a text."""
        if any("\ud800" <= char <= "\udfff" for char in text):
            raise ConfigError(f"{self.flag} {text}: not in UTF-8; allowed: names in UTF-8")
        longest = max(Path(text).parts, key=len, default="") if self.bare is Path else ""
        if len(os.fsencode(longest)) > LONGEST_NAME:
            raise ConfigError(
                f"{self.flag} {text[:SHOWN]}…: a name of {len(os.fsencode(longest))} bytes; "
                f"allowed: at most {LONGEST_NAME}"
            )

    def _checked(self, value: Any) -> Any:
        if self.choices and value is not None and value not in self.choices:
            raise ConfigError(f"{self.flag} {value}: allowed: {', '.join(self.choices)}")
        if isinstance(value, int | float) and not isinstance(value, bool):
            shown = f"{value:g}" if isinstance(value, float) else f"{value}"[:SHOWN]
            if not self._within(value):
                raise ConfigError(f"{self.flag} {shown}: allowed: {self.allowed}")
            size = sized(self.unit)
            free = self.key or (isinstance(value, int) and self.least is None)  # such as a seed
            if not free and value and not size.least <= abs(value) <= size.most:
                within = f"at least {size.least:g} and at most {size.most:g} {self.unit}".strip()
                raise ConfigError(f"{self.flag} {shown}: allowed: {within}")
        return value

    def _within(self, value: float) -> bool:
        return (
            (self.least is None or value >= self.least)
            and (self.above is None or value > self.above)
            and (self.most is None or value <= self.most)
        )

    def _metavar(self) -> str:
        kind = self.bare
        if self.metavar or kind is bool:
            return self.metavar
        names = {Path: "FILE", int: "N", float: "NUMBER"}
        return self.unit or "|".join(self.choices) or names.get(kind, "NAME")


ABOUT = "about"
"""Key of a field's metadata."""


def option(default: Any, help: str, *flags: str, **more: Any) -> Any:
    """Return a field of a command's settings that is an option.

    Args:
        default: its default; ``MISSING`` where it is required.
        help: one line.
        flags: names of the option; by default the field's name with dashes.
        more: further attributes of :class:`Setting`.
    """
    about = Setting(default=default, help=help, **{"flags": flags, **more})
    return field(default=default, metadata={ABOUT: about})


def argument(default: Any, help: str, metavar: str = "") -> Any:
    """Return a field of a command's settings that is an argument.

    Args:
        default: its default; ``MISSING`` where it is required.
        help: one line.
        metavar: its name; by default the field's in capitals.
    """
    return option(default, help, metavar=metavar, argument=True)


def _reason(key: str) -> str:
    """Say which values of a key of the configuration are allowed."""
    from dolfingrip.config import Config

    *sections, name = key.split(".")
    info = errors.fields(sections, Config)[name]
    return errors.reason("greater", info, name).removeprefix("allowed: ")


def _without_none(kind: Any) -> Any:
    if get_origin(kind) in (Union, types.UnionType):
        return next(part for part in get_args(kind) if part is not type(None))
    return kind


@typing.dataclass_transform(kw_only_default=True, frozen_default=True)
class CommandSettings:
    """The settings of a command: each class below this one is a frozen dataclass."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        dataclass(frozen=True, kw_only=True)(cls)


def settings_of(kind: type) -> list[Setting]:
    """Return the settings that the fields of a dataclass describe, those of its bases last.

    Args:
        kind: its fields are made by :func:`option` and :func:`argument`.
    """
    hints, by_name = get_type_hints(kind), {field.name: field for field in fields(kind)}
    names = dict.fromkeys(name for base in kind.__mro__ for name in get_annotations(base))
    offered = [
        by_name[name]
        for name in names
        if name in by_name and name not in getattr(kind, "not_offered", ())
    ]
    return [
        replace(field.metadata[ABOUT], name=field.name, type=hints[field.name]) for field in offered
    ]


class _UntypedHelp:
    """Shows no type of ``--help``, which takes no value."""

    def get_help_option(self, ctx: Any) -> Any:
        """The option ``--help``."""
        help_option = super().get_help_option(ctx)  # type: ignore[misc]
        if help_option is not None:
            help_option.metavar = ""
        return help_option


class Command(_UntypedHelp, TyperCommand):
    """A command without commands of its own."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        for parameter in self.params:
            if isinstance(parameter, TyperArgument):  # its name says what it is
                parameter.display_type_rich = lambda ctx: None  # type: ignore[method-assign]


class Group(_UntypedHelp, TyperGroup):
    """A command with commands of its own."""


@dataclass(frozen=True)
class Subcommand:
    """A command in the list of commands.

    Attributes:
        name: on the command line.
        settings: dataclass; its docstring is the command's help.
        work: ``FILE:FUNCTION`` in this package, which is called with the settings.
        about: help in place of the docstring.
        instead: work in place of ``work`` where a setting of this name is given.
        below: commands of its own.
        rooms: folders of the package that it needs, and that may be taken out.
    """

    name: str
    settings: type
    work: str
    about: str = ""
    instead: Mapping[str, str] = NOTHING
    below: tuple[Subcommand, ...] = ()
    rooms: tuple[str, ...] = ()

    @property
    def is_there(self) -> bool:
        """True where all of its folders are."""
        return all(find_spec(f"dolfingrip.{room}") is not None for room in self.rooms)

    @property
    def help(self) -> str:
        """Help of the command."""
        text = self.about or cleandoc(self.settings.__doc__ or "")
        return "\n\n".join(" ".join(part.split()) for part in text.split("\n\n"))

    def function(self, settings: Any = None) -> Callable[[Any], None]:
        """Return the function that does the work; this loads all that it needs.

        Args:
            settings: the settings; None for the usual work.
        """
        others = (work for name, work in self.instead.items() if getattr(settings, name, None))
        module, name = next(others, self.work).split(":")
        return getattr(importlib.import_module(f"{__package__}.{module}"), name)

    def built(self) -> Any:
        """Return the command with its options."""
        app = typer.Typer(add_completion=False)
        if self.below:
            app.callback(cls=Group, invoke_without_command=True, help=self.help)(self._callback())
            for inner in self.below:
                app.command(inner.name, cls=Command, help=inner.help)(inner._callback())
        else:
            app.command(self.name, cls=Command, help=self.help)(self._callback())
        return typer.main.get_command(app)

    def _callback(self) -> Callable[..., None]:
        """Return the function whose signature Typer reads."""
        described = settings_of(self.settings)
        in_folder = any((one.name, one.metavar) == ("out", "FOLDER") for one in described)

        def perform(context: typer.Context, **given: Any) -> None:
            if context.invoked_subcommand is None:
                values = {setting.name: setting.value(given[setting.name]) for setting in described}
                settings = self.settings(**values)
                if in_folder and settings.out is not None:
                    from dolfingrip.cli.console import check_writable  # which loads MPI

                    check_writable(settings.out)
                self.function(settings)(settings)

        leading = Parameter("context", Parameter.KEYWORD_ONLY, annotation=typer.Context)
        parameters = [leading, *(setting.parameter() for setting in described)]
        perform.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
        perform.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
        return perform


class Listed(Command):
    """A command in the list, without its options, which are made once it is called.

    Args:
        entry: the command.
        group: heading of the list that it stands below.
    """

    def __init__(self, entry: Subcommand, group: str | None = None) -> None:
        super().__init__(entry.name, help=entry.help, rich_help_panel=group)
        self.entry = entry

    def make_context(self, *arguments: Any, **named: Any) -> Any:
        """Return the context of the whole command."""
        return self.entry.built().make_context(*arguments, **named)
