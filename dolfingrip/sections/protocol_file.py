"""A protocol file: the laboratory's procedure, as readings at given times.

TOML: segments that are run through in order, ``cycles`` times, at each pose:

    cycles = 2
    [[segment]]
    to_kPa = 100.0           # a coupon: to_mm
    rate_kPa_per_s = 25.0    # a coupon: rate_mm_per_s
    readings = 4
    [[segment]]
    hold_s = 60.0
    readings = 5
    [[pose]]
    name = "gap 2 mm"
    set = ["plate.gap_mm=2", "gravity.direction=[1, 0, 0]"]

or the CSV of a measurement, for the time stamps of one of its specimens.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError, checked
from dolfingrip.sections.procedure import Branch
from dolfingrip.sections.section import Refusal, Section
from dolfingrip.sections.units import unit

SPARSER = 3.0
"""Ratio of the times of successive readings of a wait; relaxation slows down."""

Lines = Annotated[tuple[str, ...], Field(strict=False)]


class ProtocolSegment(Section):
    """A ramp or a wait."""

    to_kPa: float | None = Field(None, description="pressure at the end of the ramp")
    to_mm: float | None = Field(None, description="crosshead's displacement at its end (coupon)")
    rate_kPa_per_s: float = Field(25.0, gt=0, description="of the ramp")
    rate_mm_per_s: float = Field(2.5, gt=0, description="of the ramp (coupon)")
    hold_s: float | None = Field(None, ge=0, description="length of the wait")
    readings: int = Field(4, ge=1, le=100_000, description="the last at the segment's end")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        given = [key for key in ("to_kPa", "to_mm", "hold_s") if getattr(self, key) is not None]
        if len(given) != 1:
            yield Refusal("hold_s", "allowed: exactly one of to_kPa, to_mm and hold_s")


class SetupPose(Section):
    """A set-up in which all segments are run through."""

    name: str = Field(description="folder of its results")
    set: Lines = Field((), description="as with --set")


class ProtocolFile(Section):
    """Contents of a TOML protocol."""

    cycles: int = Field(1, ge=1, le=10_000, description="how often the segments are repeated")
    segment: Annotated[tuple[ProtocolSegment, ...], Field(strict=False)] = Field(
        (), description="ramps and waits in order"
    )
    pose: Annotated[tuple[SetupPose, ...], Field(strict=False)] = Field((), description="set-ups")


def waits(length_s: float, count: int) -> list[float]:
    """Return the times (s) after a wait's start at which readings are taken; the last is its end.

    Args:
        length_s: length of the wait.
        count: number of readings.
    """
    return [length_s * SPARSER ** (k + 1 - count) for k in range(count)] if length_s else []


def read(
    file: Path, experiment: str, control: str = "pressure_kPa", specimen: str | None = None
) -> tuple[dict[str, Any], Sequence[SetupPose]]:
    """Read the table ``[protocol]`` that a file describes, and its poses.

    Args:
        file: TOML, or CSV in the format of measured data.
        experiment: experiment whose rows of a CSV are read.
        control: column of the experiment's control, ``pressure_kPa`` or ``displacement_mm``.
        specimen: specimen whose rows of a CSV are read; required if the experiment has several.

    Raises:
        ConfigError: one line naming the key, its value and what is allowed.
    """
    measured = file.suffix == ".csv"
    if specimen is not None and not measured:
        raise ConfigError(f"--specimen {specimen}: {file} is no CSV; allowed: with a .csv")
    if measured:
        text = tables.text_of(file, "--protocol")
        tables.check_separator(f"--protocol {file}", text.partition("\n")[0])
        return _measured(file, text.splitlines(), experiment, control, specimen), ()
    asked = checked(ProtocolFile, tables.whole(file, "--protocol"))
    if not asked.segment:
        raise ConfigError(f"--protocol {file}: segment = []: allowed: at least one [[segment]]")
    by = f"to_{unit(control)}"
    wrong = [s for s in asked.segment if s.hold_s is None and getattr(s, by) is None]
    if wrong:
        raise ConfigError(f"--protocol {file}: segment: allowed: {by} or hold_s in a {experiment}")
    return _table(asked, control), asked.pose


def _table(asked: ProtocolFile, control: str) -> dict[str, Any]:
    rows: list[tuple[float, float, int, Branch]] = [(0.0, 0.0, 1, "loading")]
    by, rate = f"to_{unit(control)}", f"rate_{unit(control)}_per_s"
    for cycle in range(1, asked.cycles + 1):
        for segment in asked.segment:
            start_s, start, *_ = rows[-1]
            if segment.hold_s is not None:
                after = waits(segment.hold_s, segment.readings)
                rows += [(start_s + t, start, cycle, "hold") for t in after]
                continue
            change = getattr(segment, by) - start
            branch: Branch = "loading" if change > 0 else "unloading"
            length_s = abs(change) / getattr(segment, rate)
            for k in range(1, segment.readings + 1) if change else ():
                part = k / segment.readings
                rows.append((start_s + part * length_s, start + part * change, cycle, branch))
    columns = [list(column) for column in zip(*rows, strict=True)]
    return dict(zip(("time_s", control, "cycle", "branch"), columns, strict=True))


def _measured(
    file: Path, lines: Iterable[str], experiment: str, control: str, specimen: str | None
) -> dict[str, Any]:
    """Readings of one specimen of an experiment at the times in the file, from 0 s on."""
    table = csv.DictReader(lines)
    missing = [name for name in ("time_s", control) if name not in (table.fieldnames or ())]
    if missing:
        raise ConfigError(f"--protocol {file}: missing column {missing[0]}")
    rows = [row for row in table if row.get("experiment", experiment) == experiment]
    if not rows:
        raise ConfigError(f"--protocol {file}: no row; allowed: rows of experiment {experiment}")
    rows = _of_one(file, rows, experiment, specimen)
    found: dict[str, Any] = {}
    try:
        for name in ("time_s", control):
            found[name] = [float(row[name]) for row in rows]
        if "cycle" in rows[0]:
            found["cycle"] = [int(row["cycle"]) for row in rows]
    except (TypeError, ValueError) as error:
        raise ConfigError(f"--protocol {file}: {error}") from None
    if "branch" in rows[0]:
        found["branch"] = [row["branch"] for row in rows]
    start = found["time_s"][0]
    found["time_s"] = [time - start for time in found["time_s"]]
    return found


def _of_one(
    file: Path, rows: list[dict[str, str]], experiment: str, specimen: str | None
) -> list[dict[str, str]]:
    """The rows of the specimen that is asked for, or of the only specimen."""
    names = list(dict.fromkeys(row.get("specimen") or "" for row in rows))
    allowed = ", ".join(name or "(no name)" for name in names)
    if specimen is None and len(names) > 1:
        raise ConfigError(
            f"--protocol {file}: {len(names)} specimens of {experiment}; "
            f"allowed: one, by --specimen: {allowed}"
        )
    wanted = names[0] if specimen is None else specimen
    if wanted not in names:
        raise ConfigError(f"--specimen {wanted}: not in {file}; allowed: {allowed}")
    return [row for row in rows if (row.get("specimen") or "") == wanted]
