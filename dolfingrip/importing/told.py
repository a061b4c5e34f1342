"""Settings of an import that a person tells, and questions where two readings are possible."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final, get_args, get_type_hints

ORDERS: Final = ("dmy", "mdy")
"""Orders of day, month and year that a date may have which does not begin with the year."""

VALUE: Final = "VALUE"
"""Place of a value in a line that the person fills in."""


@dataclass(frozen=True, kw_only=True)
class Told:
    """Everything about a table that is told rather than read.

    Attributes:
        column: ``HEADER=COLUMN`` texts; see :func:`dolfingrip.importing.header.told_columns`.
        experiment: name of the experiment.
        zero_at_rest: whether the first reading is subtracted from readings that count from rest;
            None: not told.
        gauge_length: of a coupon (mm).
        area: cross-section of a coupon (mm²).
        mode: mode of tension of a coupon, or compression; None: not told.
        frame_rate: pictures per second (Hz).
        rate: of the ramps, in kPa/s, of a coupon in mm/s.
        encoding: of a text file.
        decimal: the decimal sign.
        sheet: name of a sheet.
        side_by_side: whether columns of one quantity are those of several specimens.
        log: a second table of the same test, whose clock is another one.
        shift: time of the pressure's clock where that of the readings shows 0 (s).
    """

    column: tuple[str, ...] = ()
    experiment: str | None = None
    zero_at_rest: bool | None = None
    gauge_length: float | None = None
    area: float | None = None
    mode: str | None = None
    frame_rate: float | None = None
    rate: float | None = None
    encoding: str | None = None
    decimal: str | None = None
    sheet: str | None = None
    side_by_side: bool = False
    log: Path | None = None
    shift: float | None = None

    def with_line(self, text: str) -> Told:
        """These settings and one line of a command, such as ``--column "p=pressure_bar"``."""
        flag, *values = shlex.split(text)
        name = flag.removeprefix("--").replace("-", "_")
        value: Any = values[0] if values else True
        if name.startswith("no_"):
            name, value = name.removeprefix("no_"), False
        elif name == "column":
            value = (*self.column, value)
        elif float in get_args(get_type_hints(Told)[name]):
            value = float(value)
        return replace(self, **{name: value})

    @classmethod
    def of(cls, settings: Any) -> Told:
        """The settings of a command that has these among others."""
        return cls(**{field.name: getattr(settings, field.name) for field in fields(cls)})


class Question(Exception):
    """A table has two readings.

    Attributes:
        text: what is not known.
        lines: options of a command, each of which settles it.
    """

    def __init__(self, text: str, lines: Sequence[str]) -> None:
        self.text, self.lines = text, tuple(lines)
        super().__init__(f"{text} add {' or '.join(lines)}")


def line(name: str, value: str = VALUE) -> str:
    """An option of the command, as it is typed.

    Args:
        name: of the setting.
        value: its value.
    """
    return f"--{name.replace('_', '-')} {value if value.isalnum() else _quoted(value)}"


def column_line(header: str, column: str, change: str = "") -> str:
    """The option that says what a column is.

    Args:
        header: its name.
        column: of the format.
        change: what is done to its numbers, as ``*-1``.
    """
    return line("column", f"{header}{change}={column}")


def sides(text: str) -> tuple[str, str]:
    """The header with what is done to its numbers, and the column, of such an option's value.

    Args:
        text: as it is typed.
    """
    header, _, column = text.rpartition("=")
    return header, column


def _quoted(text: str) -> str:
    """A text in double quotes of a shell."""
    return '"' + "".join(f"\\{char}" if char in '\\"$`' else char for char in text) + '"'
