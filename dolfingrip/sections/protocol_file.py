"""A protocol file: the laboratory's procedure, as readings at given times.

TOML: segments that are run through in order, ``cycles`` times, at each pose:

    cycles = 2
    [[segment]]
    to_kPa = 100.0           # a coupon: to_mm
    rate_kPa_per_s = 25.0    # a coupon: rate_mm_per_s
    readings = 4
    [[segment]]
    cavity_kPa = { cavity_2 = 40.0 }  # a supply of its own, beside to_kPa or alone
    [[segment]]
    hold_s = 60.0
    readings = 5
    [[pose]]
    name = "gap 2 mm"
    set = ["plate.gap_mm=2", "gravity.direction=[1, 0, 0]"]

or the CSV of a measurement, for the time stamps of one of its specimens; columns such as
``cavity_2_supply_kPa`` are supplies of single cavities.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from dolfingrip.channels import PRESSURE, cavity_of_supply, supply_of
from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError, checked
from dolfingrip.sections.procedure import Branch, branch_of
from dolfingrip.sections.section import Refusal, Section
from dolfingrip.sections.units import unit

SPARSER = 3.0
"""Ratio of the times of successive readings of a wait; relaxation slows down."""

FIRST = 1e-6
"""The first reading of a wait is not nearer to its start, as a part of its length."""

Lines = Annotated[tuple[str, ...], Field(strict=False)]


class ProtocolSegment(Section):
    """A ramp or a wait."""

    to_kPa: float | None = Field(None, description="pressure at the end of the ramp")
    to_ml: float | None = Field(None, description="a pump's volume at its end")
    to_mm: float | None = Field(None, description="crosshead's displacement at its end (coupon)")
    cavity_kPa: dict[str, float] = Field(
        {}, description="pressures at its end, by cavity, of supplies of their own"
    )
    rate_kPa_per_s: float = Field(25.0, gt=0, description="of the farthest ramp")
    rate_ml_per_s: float = Field(1.0, gt=0, description="of the pump")
    rate_mm_per_s: float = Field(2.5, gt=0, description="of the ramp (coupon)")
    hold_s: float | None = Field(None, ge=0, description="length of the wait")
    every_s: float | None = Field(None, gt=0, description="time between readings of the wait")
    readings: int = Field(4, ge=1, le=100_000, description="the last at the segment's end")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        keys = ("to_kPa", "to_ml", "to_mm", "hold_s")
        given = [key for key in keys if getattr(self, key) is not None]
        if len(given) > 1 or not (given or self.cavity_kPa):
            yield Refusal("hold_s", "allowed: exactly one of to_kPa, to_mm, to_ml and hold_s")
        if self.cavity_kPa and given not in ([], ["to_kPa"]):
            yield Refusal("cavity_kPa", "allowed: alone or beside to_kPa", "a table")
        if self.every_s is None:
            return
        if self.hold_s is None or "readings" in self.model_fields_set:
            yield Refusal("every_s", "allowed: beside hold_s, without readings")
        elif not 1 <= self.hold_s / self.every_s * (1 + 1e-9) <= 100_000:
            ends = f"{self.hold_s / 100_000:g} to {self.hold_s:g} s"
            yield Refusal("every_s", f"allowed: {ends}, the length of the wait")

    def leads(self, by: str) -> bool:
        """Return whether it waits, or is a ramp of what an experiment prescribes.

        Args:
            by: key of the end of the control's ramps.
        """
        ramps_cavity = by == "to_kPa" and bool(self.cavity_kPa)
        return ramps_cavity or self.hold_s is not None or getattr(self, by) is not None


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


def waits(length_s: float, count: int, *, even: bool = False) -> list[float]:
    """Return the times (s) after a wait's start at which readings are taken; the last is its end.

    Args:
        length_s: length of the wait.
        count: number of readings.
        even: whether they are at equal distances, as a specimen in motion is read.
    """
    ratio = min(SPARSER, FIRST ** (-1 / max(count - 1, 1)))
    parts = [(k + 1) / count if even else ratio ** (k + 1 - count) for k in range(count)]
    return [length_s * part for part in parts] if length_s else []


def key(column: str) -> str:
    """Return the key of the configuration that a protocol's column is the value of.

    Args:
        column: as :func:`read` returns them.
    """
    cavity = cavity_of_supply(column)
    return f"protocol.{column}" if cavity is None else f"cavity.{cavity}.pressure_kPa"


def read(
    file: Path,
    experiment: str,
    control: str = "pressure_kPa",
    specimen: str | None = None,
    *,
    even: bool = False,
) -> tuple[dict[str, Any], Sequence[SetupPose]]:
    """Read the columns of the protocol that a file describes, and its poses.

    Args:
        file: TOML, or CSV in the format of measured data.
        experiment: experiment whose rows of a CSV are read.
        control: column of what is prescribed: ``pressure_kPa``, ``volume_ml`` or
            ``displacement_mm``.
        specimen: specimen whose rows of a CSV are read; required if the experiment has several.
        even: whether readings of a wait are at equal distances, as where the specimen has inertia.

    Returns:
        Values by column, and set-ups; :func:`key` says where a column belongs.

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
    protocol = checked(ProtocolFile, tables.whole(file, "--protocol"))
    if not protocol.segment:
        raise ConfigError(f"--protocol {file}: segment = []: allowed: at least one [[segment]]")
    by = f"to_{unit(control)}"
    if not all(segment.leads(by) for segment in protocol.segment):
        raise ConfigError(f"--protocol {file}: segment: allowed: {by} or hold_s in a {experiment}")
    return _table(protocol, control, even), protocol.pose


def _table(protocol: ProtocolFile, control: str, even: bool) -> dict[str, list[Any]]:
    """Readings of all segments: each of the controls goes on a straight line to its end."""
    cavities = dict.fromkeys(name for segment in protocol.segment for name in segment.cavity_kPa)
    by, rate = f"to_{unit(control)}", f"rate_{unit(control)}_per_s"
    rows: list[tuple[float, dict[str, float], int, Branch]] = [
        (0.0, dict.fromkeys((control, *cavities), 0.0), 1, "loading")
    ]
    for cycle in range(1, protocol.cycles + 1):
        for segment in protocol.segment:
            start_s, start, *_ = rows[-1]
            if segment.hold_s is not None:
                after = waits(segment.hold_s, segment.readings, even=even)
                if segment.every_s is not None:
                    count = int(segment.hold_s / segment.every_s * (1 + 1e-9))
                    after = [segment.every_s * (k + 1) for k in range(count)]
                rows += [(start_s + t, start, cycle, "hold") for t in after]
                continue
            end = start | segment.cavity_kPa
            if getattr(segment, by) is not None:
                end[control] = getattr(segment, by)
            change = {name: end[name] - start[name] for name in end}
            leads = control if change[control] else max(change, key=lambda name: abs(change[name]))
            length_s = max(map(abs, change.values())) / getattr(segment, rate)
            for k in range(1, segment.readings + 1) if length_s else ():
                part = k / segment.readings
                now = {name: start[name] + part * change[name] for name in change}
                branch = branch_of(rows[-1][1][leads], now[leads])
                rows.append((start_s + part * length_s, now, cycle, branch))
    times, controls, cycles, branches = ([*column] for column in zip(*rows, strict=True))
    values = {name: [state[name] for state in controls] for name in (control, *cavities)}
    columns = {"time_s": times, control: values.pop(control), "cycle": cycles, "branch": branches}
    return columns | {supply_of(name).name: series for name, series in values.items()}


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
    columns: dict[str, Any] = {}
    try:
        supplies = [name for name in rows[0] if control == PRESSURE.name and cavity_of_supply(name)]
        for name in ("time_s", control, *supplies):
            columns[name] = [float(row[name]) for row in rows]
        if "cycle" in rows[0]:
            columns["cycle"] = [int(row["cycle"]) for row in rows]
    except (TypeError, ValueError) as error:
        raise ConfigError(f"--protocol {file}: {error}") from None
    if "branch" in rows[0]:
        columns["branch"] = [row["branch"] for row in rows]
    start = columns["time_s"][0]
    columns["time_s"] = [time - start for time in columns["time_s"]]
    return columns


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
