"""A measured CSV as a checked table; one line names file, line and column of a fault.

The format's columns are controls and readings of each experiment.
"""

from __future__ import annotations

import csv
import difflib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, get_args

import pandas as pd

from dolfingrip.channels import (
    AIR_SUPPLY,
    CHANNELS,
    CURVE,
    DISPLACEMENT,
    ENERGIES,
    OBSTACLE,
    OF_CAVITIES,
    PRESSURE,
    TIME,
    VOLUME,
    WHO,
    at_marker,
    cavity_of_supply,
    readings,
)
from dolfingrip.config import ConfigError
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.recorder import columns
from dolfingrip.sections.procedure import Branch
from dolfingrip.sections.tables import check_separator
from dolfingrip.sections.units import NOTHING

EXPERIMENT_NAMES: Final = tuple(name for name, each in EXPERIMENTS.items() if each.measured)
"""Experiments that the format has and the package simulates."""

NOT_SIMULATED: Final = ("grasp", "pick_up")
"""Experiments that the format has and the package does not simulate."""

CONTROL: Final[Mapping[str, str]] = {
    name: EXPERIMENTS[name].control.name for name in EXPERIMENT_NAMES
}
"""Column of what each experiment controls; a pump's volume may stand in place of a pressure."""

READINGS: Final[Mapping[str, tuple[str, ...]]] = {
    name: tuple(each.name for each in readings(*EXPERIMENTS[name].parts))
    for name in EXPERIMENT_NAMES
}
"""Columns that each experiment reads; any of them may be absent. Markers have further ones."""

READING_COLUMNS: Final = tuple(sorted({name for own in READINGS.values() for name in own}))
"""All columns of readings."""

NUMBERS: Final = (TIME.name, PRESSURE.name, VOLUME.name, DISPLACEMENT.name, *READING_COLUMNS)
"""All columns of numbers."""

MEASURED: Final = (*WHO, *NUMBERS)
"""All columns of the format."""

IGNORED: Final = frozenset(
    {name for each in EXPERIMENTS.values() for name in columns(each)}
    | {CURVE.name, *(each.name for each in (*OBSTACLE, *AIR_SUPPLY, *ENERGIES))}
) - {*MEASURED}
"""Further columns of a simulation's ``result.csv``, which no instrument reads."""


def controls_of(experiment: str) -> tuple[str, ...]:
    """List the columns one of which an experiment prescribes.

    Args:
        experiment: its name.
    """
    control = CONTROL[experiment]
    return (control, VOLUME.name) if control == PRESSURE.name else (control,)


def of_markers(names: Iterable[str]) -> tuple[str, ...]:
    """List the columns of markers among some names, of which a table has as many as were seen.

    Args:
        names: of columns.
    """
    return tuple(name for name in names if at_marker(name) is not None)


def of_any_number(names: Iterable[str]) -> tuple[str, ...]:
    """List the columns of markers and of single cavities' supplies among some names.

    Args:
        names: of columns.
    """
    names = tuple(names)
    return (*of_markers(names), *filter(cavity_of_supply, names))


def read_by(experiment: str, names: Iterable[str] = ()) -> tuple[str, ...]:
    """List the columns that an experiment reads, with those of markers among some names.

    Args:
        experiment: its name.
        names: of columns.
    """
    sees = "finger" in EXPERIMENTS[experiment].parts
    return (*READINGS[experiment], *(of_markers(names) if sees else ()))


def near(name: str, names: Sequence[str]) -> str:
    """Return ``did you mean …? `` if a known name is like another, else "".

    Args:
        name: as it is written.
        names: names that there are.
    """
    close = difflib.get_close_matches(name, names, 1)
    return f"did you mean {close[0]}? " if close else ""


def allowed(name: str, names: Sequence[str]) -> str:
    """Tell what is allowed in place of a name, the nearest first.

    Args:
        name: of a column or an experiment.
        names: names that are allowed.
    """
    return f"{near(name, names)}allowed: {', '.join(names)}"


BRANCHES = get_args(Branch)


@contextmanager
def _refused_at(file: Path, line: int) -> Iterator[None]:
    """Tell of a fault in which line of a file it is."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{file}: line {line}: {' '.join(str(error).split())}") from None


def read(file: Path, experiments: Sequence[str]) -> pd.DataFrame:
    """The rows of a CSV in the format of measured data.

    Args:
        file: the CSV file.
        experiments: those that its TOML names; the only one is meant where the CSV has no such
            column.

    Returns:
        A row for each of the file: ``line`` in the file, the format's columns and those of supplies
        of single cavities. An absent specimen is called like the file, an absent cycle is 1, an
        absent branch is "". Absent numbers are NaN.

    Raises:
        ConfigError: one line naming the file, the line, the column, its value and what is allowed.
    """
    rows = []
    for line, cells in _cells(file):
        with _refused_at(file, line):
            rows.append({"line": line, **_checked(file, cells, experiments)})
    if not rows:
        raise ConfigError(f"{file}: no rows; allowed: at least 2 readings")
    names = dict.fromkeys(name for row in rows for name in row)
    extra = [*of_markers(sorted(names)), *filter(cavity_of_supply, names)]  # supplies in file order
    table = pd.DataFrame(rows, columns=["line", *MEASURED, *extra])
    table[[*NUMBERS, *extra]] = table[[*NUMBERS, *extra]].astype(float)
    _check_together(file, table)
    return table


def _cells(file: Path) -> list[tuple[int, dict[str, str]]]:
    """The entries that are not empty, by column, with their lines in the file."""
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            check_separator(str(file), stream.readline())
            stream.seek(0)
            reader = csv.reader(stream)
            lines = [(reader.line_num, cells) for cells in reader if any(map(str.strip, cells))]
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{file}: not a CSV in UTF-8: {error}") from None
    if not lines:
        raise ConfigError(f"{file}: empty; allowed: a header line and rows")
    names = [name.strip() for name in lines[0][1]]
    _check_header(file, names)
    columns = {*MEASURED, *of_any_number(names)}
    entries = []
    for line, cells in lines[1:]:
        if len(cells) != len(names):
            with _refused_at(file, line):
                raise ConfigError(
                    f"{len(cells)} entries; allowed: as many as the header, {len(names)}"
                )
        row = zip(names, map(str.strip, cells), strict=True)
        entries.append((line, {name: text for name, text in row if text and name in columns}))
    return entries


def _check_header(file: Path, names: Sequence[str]) -> None:
    columns = {*MEASURED, *IGNORED, *of_markers(names)}
    for i, name in enumerate(names):
        if name not in columns and not name.startswith(OF_CAVITIES):
            raise ConfigError(
                f"{file}: column {name or '(no name)'}: unknown; {allowed(name, MEASURED)}"
            )
        if name in names[:i]:
            raise ConfigError(f"{file}: column {name}: twice; allowed: once")
    if not set(names) & {*READING_COLUMNS, *of_markers(names)}:
        raise ConfigError(
            f"{file}: no reading; allowed: at least one column of {', '.join(READING_COLUMNS)}"
        )


def _checked(file: Path, cells: dict[str, str], experiments: Sequence[str]) -> dict[str, Any]:
    """One row by column."""
    row: dict[str, Any] = {
        "experiment": _experiment(file, cells.get("experiment"), experiments),
        "specimen": cells.get("specimen", file.stem),
        "cycle": _cycle(cells.get("cycle", "1")),
        "branch": cells.get("branch", ""),
    }
    if row["branch"] not in ("", *BRANCHES):
        raise ConfigError(f"branch = {row['branch']}: allowed: {', '.join(BRANCHES)}")
    markers = of_markers(cells)
    supplies = [name for name in cells if cavity_of_supply(name)]
    numbers = {*NUMBERS, *markers, *supplies}
    row |= {name: _number(name, text) for name, text in cells.items() if name in numbers}
    control, readings = CONTROL[row["experiment"]], read_by(row["experiment"], cells)
    there = [name for name in controls_of(row["experiment"]) if name in row]
    if not there:
        raise ConfigError(
            f"{control}: missing; allowed: a number in each row of {row['experiment']}"
        )
    if len(there) > 1:
        raise ConfigError(f"{' and '.join(there)}: both told; allowed: what was prescribed")
    driven = supplies if control == PRESSURE.name else ()
    every = (*READING_COLUMNS, *markers, *supplies)
    foreign = [name for name in every if name in row and name not in (*readings, *driven)]
    if foreign:
        raise ConfigError(
            f"{foreign[0]} = {cells[foreign[0]]}: {row['experiment']} does not read it; are "
            f"columns swapped? allowed: {', '.join(readings)}"
        )
    return row


def _experiment(file: Path, name: str | None, experiments: Sequence[str]) -> str:
    if name is None:
        if len(experiments) == 1:
            return experiments[0]
        raise ConfigError(f"experiment: missing; allowed: {', '.join(EXPERIMENT_NAMES)}")
    if name in NOT_SIMULATED:
        raise ConfigError(
            f"experiment = {name}: not simulated yet; allowed: {', '.join(EXPERIMENT_NAMES)}"
        )
    if name not in EXPERIMENT_NAMES:
        raise ConfigError(f"experiment = {name}: unknown; {allowed(name, EXPERIMENT_NAMES)}")
    if experiments and name not in experiments:
        raise ConfigError(
            f"experiment = {name}: not in {file.with_suffix('.toml').name}; "
            f"allowed: {', '.join(experiments)}"
        )
    return name


def _cycle(text: str) -> int:
    value = float(pd.to_numeric(text, errors="coerce"))
    if not (value.is_integer() and value >= 1):
        raise ConfigError(f"cycle = {text}: allowed: a whole number from 1 on")
    return int(value)


def _number(name: str, text: str) -> float:
    channel = PRESSURE if cavity_of_supply(name) else CHANNELS[name]
    assert channel.plausible is not None
    low, high = channel.plausible
    least = f" ({channel.least})" if channel.least else ""
    within = f"allowed: {low:g}{least} to {high:g} {channel.unit or '(no percent)'}"
    try:
        value = float(text)
    except ValueError:
        raise ConfigError(f"{name} = {text}: not a number; {within}") from None
    if not math.isfinite(value):
        raise ConfigError(f"{name} = {text}: not a finite number; {within}, or nothing")
    if not low <= value <= high:
        raise ConfigError(f"{name} = {text}: {within}")
    if 0 < abs(value) < NOTHING:
        raise ConfigError(f"{name} = {text}: nearer to 0 than {NOTHING:g}; {within}")
    return value


def _check_together(file: Path, table: pd.DataFrame) -> None:
    """Check the rows of one specimen in one experiment together."""
    for (experiment, specimen), rows in table.groupby(["experiment", "specimen"], sort=False):
        who = f"{experiment} of {specimen}"
        numbers = [TIME.name, VOLUME.name, *filter(cavity_of_supply, rows.columns)]
        for name in (*numbers, "branch"):
            absent = rows[name].isna() | (rows[name] == "")
            if absent.any() and not absent.all():
                what = f"{', '.join(BRANCHES)}, or in no row"
                if name in numbers:
                    what = f"a number in each row of {who}, or in none"
                with _refused_at(file, int(rows["line"][absent].iloc[0])):
                    raise ConfigError(f"{name}: missing; allowed: {what}")
        _check_time(file, rows, who)
        count = int(rows[[*READING_COLUMNS, *of_markers(rows)]].count().sum())
        if count < 2:
            raise ConfigError(
                f"{file}: {who}: {count} reading{'' if count == 1 else 's'}; allowed: at least 2"
            )


def _check_time(file: Path, rows: pd.DataFrame, who: str) -> None:
    """Check that time goes on, and that no row is there twice; rows without times may be."""
    time_s = rows[TIME.name]
    back = time_s.diff() < 0
    if back.any():
        before, now = time_s.shift()[back].iloc[0], time_s[back].iloc[0]
        with _refused_at(file, int(rows["line"][back].iloc[0])):
            raise ConfigError(
                f"time_s = {now:g}: before the row above of {who}; allowed: from {before:g} s on"
            )
    columns = [name for name in rows.columns if name != "line"]
    first = rows.groupby(columns, dropna=False, sort=False)["line"].transform("first")
    again = (rows["line"] > first) & time_s.notna()
    if again.any():
        with _refused_at(file, int(rows["line"][again].iloc[0])):
            raise ConfigError(
                f"the same as line {first[again].iloc[0]} ({who}); allowed: each row once"
            )
