"""Settings of an import that a person tells, and questions where two readings are possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

ORDERS: Final = ("dmy", "mdy")
"""Orders of day, month and year that a date may have which does not begin with the year."""

VALUE: Final = "VALUE"
"""Place of a value that the person fills in."""


@dataclass(frozen=True, slots=True)
class NamedColumn:
    """A column of a table, and what it is.

    Attributes:
        header: its name in the table, with what is done to its numbers, as ``ADC*0.05-2``.
        column: of the format, the same in another unit, or ``ignore``.
    """

    header: str
    column: str

    def __str__(self) -> str:
        """Return the text as it is typed."""
        return "=".join((self.header, self.column))


@dataclass(frozen=True, slots=True)
class ImportOption:
    """An option of the command, which settles a question.

    Attributes:
        name: of the setting, of :class:`Told`.
        value: its value; :data:`VALUE` where the person tells it.
    """

    name: str
    value: Any = True

    def __str__(self) -> str:
        """Return the text as it is typed."""
        flag = f"--{'no-' if self.value is False else ''}{self.name.replace('_', '-')}"
        if isinstance(self.value, bool):
            return flag
        text = str(self.value)
        return f"{flag} {text if text.isalnum() else _quoted(text)}"

    def filled(self, place: str, number: float) -> ImportOption:
        """The option with a number at a place that the person fills in.

        Args:
            place: a word, as :data:`VALUE`.
            number: which stands there.
        """
        if not isinstance(self.value, NamedColumn):
            return replace(self, value=number)
        header = self.value.header.replace(place, f"{number}").replace("+-", "-")
        return replace(self, value=replace(self.value, header=header))


def column_option(header: str, column: str, change: str = "") -> ImportOption:
    """The option that says what a column is.

    Args:
        header: its name.
        column: of the format.
        change: what is done to its numbers, as ``*-1``.
    """
    return ImportOption("column", NamedColumn(header + change, column))


@dataclass(frozen=True, kw_only=True)
class Told:
    """Everything about a table that is told rather than read.

    Attributes:
        column: columns that are named; see :func:`dolfingrip.importing.header.told_columns`.
        experiment: name of the experiment.
        zero_at_rest: whether the first reading is subtracted from readings that count from rest;
            None: not told.
        withdraws: whether a pump withdraws where its counter begins at 0 again; None: not told.
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

    column: tuple[NamedColumn, ...] = ()
    experiment: str | None = None
    zero_at_rest: bool | None = None
    withdraws: bool | None = None
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

    def with_option(self, option: ImportOption) -> Told:
        """These settings and one more.

        Args:
            option: of the command.
        """
        value: Any = option.value
        if option.name == "column":
            value = (*self.column, value)
        return replace(self, **{option.name: value})


class Question(Exception):
    """A table has two readings.

    Attributes:
        text: what is not known.
        options: of the command, each of which settles it.
    """

    def __init__(self, text: str, options: Sequence[ImportOption]) -> None:
        self.text, self.options = text, tuple(options)
        super().__init__(f"{text} add {' or '.join(map(str, options))}")


def _quoted(text: str) -> str:
    """A text in double quotes of a shell."""
    return '"' + "".join(f"\\{char}" if char in '\\"$`' else char for char in text) + '"'
