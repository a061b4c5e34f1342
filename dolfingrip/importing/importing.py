"""Table of a laboratory to the format of measured data: columns, questions, and the two files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import tomlkit

from dolfingrip.channels import ANGLE, CHANNELS, OF_CAVITIES, TIME, WHO, cavity_of_supply
from dolfingrip.clock import Clock, by_motion
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data import table as measured
from dolfingrip.diagnosis.data.lab_setup import SetupFile
from dolfingrip.diagnosis.data.table import (
    CONTROL,
    IGNORED,
    MEASURED,
    READINGS,
    allowed,
    controls_of,
    of_any_number,
    of_markers,
)
from dolfingrip.experiments.material_fit import coupons
from dolfingrip.experiments.material_fit.coupons import STRAIN, STRESS
from dolfingrip.experiments.material_fit.first_loading import first_loading, is_hollow, pressed
from dolfingrip.files import whole
from dolfingrip.importing import cells as reading
from dolfingrip.importing.cells import AmbiguousDate, Cells
from dolfingrip.importing.header import (
    DATED,
    DOUBTFUL,
    IGNORE,
    UNNAMED,
    ColumnReading,
    Recognised,
    level,
    recognise,
    told_columns,
)
from dolfingrip.importing.told import ORDERS, VALUE, ImportOption, Question, Told, column_option
from dolfingrip.sections import tables

CLOCK: Final = "time of day"
"""What stands for the unit of such a column."""

BENDING: Final = ("angle_deg", "chord_angle_deg", "tip_x_mm", "tip_z_mm")

BLOWN: Final = ("pressure_kPa", "suction_kPa", "volume_ml")

SEVERAL: Final = "several"
"""Stands for the experiment of a table whose rows are of several."""

REST: Final = (*BENDING, "force_N", "displacement_mm")
"""Columns that count from the state at rest."""

AT_REST_SIGMA: Final = 3.0
"""Noises of an ordinary instrument within which a first reading is at rest."""

AIR_KPA: Final = (80.0, 110.0)
"""Pressures of the air at which people live; a gauge that begins there may be an absolute one."""

UNSTRETCHED: Final = 0.9
"""A stretch begins above this, a strain below it."""

DAY_S: Final = 86400.0
"""No experiment begins later than this after its clock was set to zero."""

ZERO_KPA: Final = 10.0
"""A gauge's zero is not farther off than this."""

RESTARTS: Final = 0.1
"""Part of the largest volume below which a pump's counter does not begin at 0 again: noise."""

ALIKE: Final = 0.02
"""Part of a range by which what a machine measured and what it worked out of it may differ."""


@dataclass(slots=True)
class ImportedTable:
    """A table and all that an import found in it.

    Attributes:
        file: the table.
        cells: its header and rows.
        taken: a reading for each column of the table; None: passed over.
        table: columns of the format.
        setup: tables and keys of the TOML file.
        notes: sentences on what was done.
        questions: what is not certain; where there is one, nothing is written.
        fixed: columns that a person tells, by header.
    """

    file: Path
    cells: Cells
    taken: dict[str, ColumnReading | None] = field(default_factory=dict)
    table: pd.DataFrame = field(default_factory=pd.DataFrame)
    setup: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    questions: list[Question] = field(default_factory=list)
    fixed: Mapping[str, ColumnReading] = field(default_factory=dict)

    def ask(self, what: str, *options: ImportOption) -> None:
        """Add a question, which each of the options settles."""
        self.questions.append(Question(what, options))

    def source(self, target: str) -> tuple[str, ColumnReading]:
        """The header and the reading of the column that is taken for one of the format."""
        return next((h, t) for h, t in self.taken.items() if t and t.target == target)

    def turn(self, name: str, target: str, scale: float, shift: float = 0.0) -> None:
        """Make a column another one, ``scale × value + shift``, and its mapping with it."""
        header, column = self.source(name)
        factor, offset = column.factor * scale, column.offset * scale + shift
        self.taken[header] = replace(column, target=target, factor=factor, offset=offset)
        turned = self.table[name] * scale + (shift + 0.0)  # 0 and not -0
        self.table = self.table.drop(columns=name).assign(**{target: turned})

    def mapping(self) -> list[tuple[str, str, str]]:
        """Header, column and what was done to the numbers, of each column of the table."""
        uncertain = {q.text.partition(":")[0]: "?" for q in self.questions}
        rows = []
        for header, taken in self.taken.items():
            name = taken.target if taken else uncertain.get(header, "passed over")
            if taken and taken.target not in self.table and not self.questions:
                name = f"passed over ({taken.target})"
            rows.append((header, name, _done(taken) if taken else ""))
        return rows


def _done(taken: ColumnReading) -> str:
    parts = [taken.unit] if taken.unit else []
    if taken.factor != 1:
        parts.append(f"× {taken.factor:.6g}")
    if taken.offset:
        parts.append(f"{taken.offset:+.6g}")
    return " ".join(parts)


def is_format(header: Sequence[str]) -> bool:
    """Say whether all names of a header are columns of the format, or of nominal coupons.

    Args:
        header: names of columns.
    """
    columns = {*MEASURED, *of_any_number(header), *IGNORED, "mode"}
    columns |= {*coupons.STRETCHES, *coupons.STRESSES}
    return all(name in columns or name.startswith(OF_CAVITIES) for name in header)


def understand(file: Path, settings: Told) -> ImportedTable:
    """Find what each column of a table is, and turn it into the format.

    A TOML file of the same stem beside the table tells the set-up, as for ``diagnose``.

    Args:
        file: CSV, TSV, text or XLSX.
        settings: what a person tells.

    Returns:
        The columns of the format, or the questions where a column has two readings.

    Raises:
        ConfigError: one line, where the file is no table or what is told does not fit it.
        Question: the sheet or the decimal sign is not certain.
    """
    cells, log = reading.read(file, settings), None
    if settings.log is not None:
        log_cells = reading.read(settings.log, replace(settings, sheet=None))
        of_log = tuple(
            named for named in settings.column
            if any(name in named.header for name in {*log_cells.header} - {*cells.header})
        )  # fmt: skip
        log = _named(settings.log, log_cells, replace(settings, column=of_log))
        of_first = tuple(named for named in settings.column if named not in of_log)
        settings = replace(settings, column=of_first)
    imported = _named(file, cells, settings)
    imported.questions += [] if log is None else log.questions
    if imported.questions:
        return imported
    if settings.side_by_side:
        _beside(imported)
    else:
        _convert(imported)
    if log is not None:
        _convert(log)
        _join(imported, log, settings)
    experiment = _experiment(imported, settings)
    if experiment is None:
        return imported
    if experiment != "coupon":
        _finger(imported, settings)
    if experiment == "coupon" or set(imported.table) & set(coupons.STRETCHES):
        _coupon(imported, settings)
    if CONTROL.get(experiment) in imported.table:
        _times(imported, settings, f"rate_{'mm' if experiment == 'coupon' else 'kPa'}_per_s")
    if is_format(cells.header) and (
        "experiment" in cells.header or file.with_suffix(".toml").exists()
    ):
        imported.notes.append("it is in the format already, and its readings are taken as they are")
    else:
        _at_rest(imported, settings)
    if not imported.questions:
        _arrange(imported, experiment)
    return imported


def read_log(files: Sequence[Path], settings: Told, event: str | None = None) -> pd.DataFrame:
    """Read times and a control of a log, where another instrument has the readings.

    Args:
        files: CSV, TSV, text or XLSX; parts of one log, in the order of time.
        settings: what a person tells.
        event: header of a further column of numbers.

    Returns:
        ``time_s``, ``pressure_kPa`` or ``volume_ml``, and ``event``, in rows that have all of them.

    Raises:
        ConfigError: one line, where a file lacks one of them, or its time runs backwards.
        Question: a column has two readings.
    """
    file, parts = files[0], [reading.read(part, settings) for part in files]
    for other, part in zip(files, parts, strict=True):
        if part.header != parts[0].header:
            allowed = f"as {file}: {', '.join(parts[0].header)}"
            raise ConfigError(f"{other}: columns {', '.join(part.header)}; allowed: {allowed}")
    cells = replace(parts[0], table=pd.concat([part.table for part in parts]))
    imported = _controlled(file, cells, settings, TIME.name)
    blown = "volume_ml" if "volume_ml" in imported.table else "pressure_kPa"
    table = imported.table[[TIME.name, blown]]
    if event is not None:
        if event not in imported.cells.header:
            there = ", ".join(imported.cells.header)
            raise ConfigError(f"--event {event}: not in {file}; allowed: {there}")
        texts = imported.cells.column(imported.cells.header.index(event))
        table = table.assign(event=_numbers(imported, event, texts))
    table = table.dropna()
    _require_order(imported, table[TIME.name])
    return table


def read_states(file: Path, texts: pd.DataFrame, settings: Told) -> dict[str, np.ndarray]:
    """Read the control of pictures, the first of which is at rest.

    Args:
        file: where they stand, for messages.
        texts: a row for each picture, by the headers of columns.
        settings: what a person tells.

    Returns:
        Columns of the format.

    Raises:
        ConfigError: one line, where no column is a control, or the first picture is not at rest.
        Question: a column has two readings.
    """
    decimal = "," if (texts.map(lambda text: "," in text)).any(axis=None) else "."
    cells = Cells(texts.set_index(pd.RangeIndex(2, len(texts) + 2)), [], decimal)
    table = _controlled(file, cells, settings).table
    if not _begins_at_rest(table):
        name = next(name for name in BLOWN if name in table)
        raise ConfigError(
            f"{file}: the first picture is at {CHANNELS[name].said(table[name].iloc[0])}; allowed: "
            "that of the finger at rest first, as readings count from it"
        )
    controls = (TIME.name, *BLOWN, *filter(cavity_of_supply, table))
    return {name: table[name].to_numpy() for name in controls if name in table}


def _controlled(file: Path, cells: Cells, settings: Told, *needs: str) -> ImportedTable:
    """A table with a control, and with further columns of some names.

    Raises:
        ConfigError: one line, where one of them is missing.
        Question: a column has two readings.
    """
    imported = _named(file, cells, settings)
    if not imported.questions:
        _convert(imported)
        _by_frames(imported, settings)
        table = imported.table
        blown = {*BLOWN, *filter(cavity_of_supply, table)} & {*table}
        if not blown or not {*needs} <= {*table}:
            raise _lacking(imported, "log" if needs else "states")
        _finger(imported, settings)
    if imported.questions:
        raise imported.questions[0]
    return imported


def _require_order(imported: ImportedTable, time_s: pd.Series) -> None:
    """Refuse a table whose time runs backwards, as where a board was started again."""
    back = time_s[time_s.diff() < 0]
    if len(time_s) < 2 or len(back):
        what = f"{len(time_s)} rows with a time and a reading"
        if len(back):
            line = imported.cells.table.index[back.index[0]]
            what = f"line {line}: the clock goes back to {back.iloc[0]:g} s"
        allowed = "at least 2 rows in the order of time, as of the file's part before such a line"
        raise ConfigError(f"{imported.file}: {what}; allowed: {allowed}")


def _named(file: Path, cells: Cells, settings: Told) -> ImportedTable:
    """Find what each column of a table is, or the questions where it has two readings."""
    imported = ImportedTable(file, cells, setup=_setup(file))
    imported.fixed = fixed = told_columns(settings.column, cells.header)
    names = [_with_clock(recognise(name), cells, i) for i, name in enumerate(cells.header)]
    certain = {r.header: r.readings[0] for r in names if r.readings and not r.why}
    taken = {**dict.fromkeys(cells.header), **certain, **fixed}
    imported.taken = {
        name: None if column is None or column.target == IGNORE else column
        for name, column in taken.items()
    }
    there = {column.target for column in imported.taken.values() if column}
    imported.questions = [
        _about(entry) for entry in names
        if entry.why and entry.header not in fixed
        and (entry.why not in (UNNAMED, DOUBTFUL) or {name for _, name in entry.offered} - there)
    ]  # fmt: skip
    if not settings.side_by_side:
        _one_each(imported)
    return imported


def _join(imported: ImportedTable, log: ImportedTable, settings: Told) -> None:
    """Bring two tables with two clocks together, in the rows of that which has the readings."""
    both = (imported, log)
    for part in both:
        _by_frames(part, settings)
    controls = (*BLOWN, "displacement_mm")
    controlled = [part for part in both if {*part.table} & {*controls}]
    readings = log if controlled[:1] == [imported] else imported
    motion = next((name for name in (*BENDING, "force_N") if name in readings.table), "")
    if len(controlled) != 1 or not motion or any(TIME.name not in part.table for part in both):
        has = "; ".join(f"{part.file}: {', '.join(part.table)}" for part in both)
        raise ConfigError(
            f"{has}; allowed: a time in each, a pressure or travel in one, and angle, place of "
            "the tip or force in the other"
        )
    control = next(name for name in controls if name in controlled[0].table)
    numbers = controlled[0].table.select_dtypes("number").dropna(subset=[TIME.name, control])
    rows = readings.table.dropna(subset=[TIME.name])
    log_s, time_s = numbers[TIME.name].to_numpy(), rows[TIME.name].to_numpy()
    _require_order(controlled[0], numbers[TIME.name])
    _require_order(readings, rows[TIME.name])
    if settings.shift is not None:
        steps = [float(np.median(np.diff(values))) for values in (log_s, time_s)]
        clock = Clock(settings.shift, 1.0, max(steps) / math.sqrt(12), "what was told")
    else:
        values = numbers[control].to_numpy()
        clock = by_motion(log_s, values, time_s, rows[motion].to_numpy(dtype=float))
    at = clock.of(time_s)
    inside = (at >= log_s[0]) & (at <= log_s[-1])
    if inside.sum() < 2:
        raise ConfigError(
            f"--shift {clock.shift_s:g} s: {inside.sum()} rows of {readings.file} are within "
            f"{controlled[0].file}; allowed: at least 2"
        )
    more = {
        name: np.interp(at, log_s, numbers[name]) for name in numbers if name not in rows.columns
    }
    imported.table = rows.assign(**more)[inside].reset_index(drop=True)
    imported.taken |= {n: c for n, c in log.taken.items() if c or n not in imported.taken}
    drift = f", {1e6 * (clock.rate - 1):.0f} ppm of drift" if clock.rate != 1 else ""
    imported.notes.append(
        f"{controlled[0].file.name} is at {clock.shift_s:.3f} ± {clock.std_s:.3f} s where "
        f"{readings.file.name} is at 0 s, by {clock.by}{drift}; {(~inside).sum()} rows outside it "
        f"are left out{f'; doubt: {clock.doubt}' if clock.doubt else ''}"
    )


def _about(entry: Recognised) -> Question:
    options = [column_option(entry.header, column, change) for change, column in entry.offered]
    return Question(
        f"{entry.header}: {entry.why};", [*options, column_option(entry.header, IGNORE)]
    )


def _with_clock(entry: Recognised, cells: Cells, place: int) -> Recognised:
    """A column of times of day, whose unit they tell."""
    texts = cells.column(place)
    try:
        if reading.seconds(texts) is not None:
            return Recognised(entry.header, (ColumnReading(TIME.name, CLOCK),))
    except AmbiguousDate as date:
        offered = tuple(("", name) for name in DATED)
        return Recognised(entry.header, (), f"{date} may begin with a day or a month", offered)
    if reading.pairs(texts) is None or any(r.unit in ("min", "h") for r in entry.readings):
        return entry
    why = f"{texts[0]} may be minutes and seconds, or hours and minutes"
    return Recognised(entry.header, (), why, (("", "time_min"), ("", "time_h")))


def _one_each(imported: ImportedTable) -> None:
    """Ask where two columns are the same quantity; one that is told counts."""
    targets: dict[str, list[str]] = {}
    for header, taken in imported.taken.items():
        if taken:
            name = "pressure_kPa" if taken.target == "suction_kPa" else taken.target
            targets.setdefault(name, []).append(header)
    for target, headers in targets.items():
        fixed = [header for header in headers if header in imported.fixed]
        if len(fixed) > 1:
            raise ConfigError(
                f"--column: {' and '.join(fixed)} are both {target}; allowed: one of them"
            )
        if fixed:
            imported.taken |= {header: None for header in headers if header not in fixed}
        elif len(headers) > 1 and target not in ("setpoint", "frame"):
            options = [column_option(header, target) for header in headers]
            if target == "pressure_kPa":  # of an arm with a supply for each of its chambers
                options += [column_option(headers[0], "cavity_1_supply_kPa")]
            if target in {name for names in READINGS.values() for name in names}:
                options += [ImportOption("side_by_side")]
            names = " and ".join(headers)
            verb = "both are" if len(headers) == 2 else "each is"
            imported.ask(f"{names}: {verb} {target}: which?", *options)


def _convert(imported: ImportedTable) -> None:
    """Fill the table with the numbers of the columns that are taken."""
    columns: dict[str, Any] = {}
    for place, header in enumerate(imported.cells.header):
        taken = imported.taken[header]
        if taken is None or taken.target == "setpoint":
            continue
        texts = imported.cells.column(place)
        if taken.target in (*WHO, "mode") and taken.target != "cycle":
            columns[taken.target] = texts
        elif taken.unit in (CLOCK, *ORDERS):
            columns[taken.target] = np.array(reading.seconds(texts, taken.unit))
        elif taken.unit in ("min", "h") and (parts := reading.pairs(texts)) is not None:
            columns[taken.target] = taken.factor * np.array(parts)
        else:
            numbers = _numbers(imported, header, texts)
            if np.isnan(numbers).all():
                imported.taken[header] = None
                imported.notes.append(f"{header}: passed over, as no cell of it has a number")
            else:
                columns[taken.target] = taken.factor * numbers + taken.offset
    imported.table = pd.DataFrame(columns)
    if TIME.name in columns:
        _since_first(imported)


def _beside(imported: ImportedTable) -> None:
    """Put the specimens below one another whose columns stand side by side, or in turn.

    A quantity of a single column is that of all of them.
    """
    columns: dict[str, list[str]] = {}
    for header, taken in imported.taken.items():
        if taken:
            columns.setdefault(taken.target, []).append(header)
    count = max(map(len, columns.values()), default=1)
    several = [headers for headers in columns.values() if len(headers) > 1]
    if count < 2 or any(len(headers) != count for headers in several):
        numbers = ", ".join(f"{len(headers)} of {name}" for name, headers in columns.items())
        raise ConfigError(
            f"{imported.file}: --side-by-side: columns: {numbers}; allowed: as many of each "
            "quantity as specimens, at least 2, or one that all have in common"
        )
    parts = []
    for i in range(count):
        others = {header for headers in several for header in headers} - {h[i] for h in several}
        part = replace(imported, taken=imported.taken | dict.fromkeys(others))
        _convert(part)
        names = [headers[i] for headers in several]
        there = [name for name in part.table if len(columns[name]) > 1]
        rows = part.table.dropna(subset=there, how="all")
        before = rows.get("specimen", pd.Series("", index=rows.index))
        parts.append(rows.assign(specimen=(before + f" {i + 1}").str.strip()))
        imported.notes.append(f"specimen {i + 1} is {', '.join(names)}")
    imported.table = pd.concat(parts, ignore_index=True)


def _since_first(imported: ImportedTable) -> None:
    """Count the times of clocks and calendars from the first: a file has ten digits of each."""
    _, taken = imported.source(TIME.name)
    first = imported.table[TIME.name].min()
    if taken.unit in (CLOCK, *ORDERS) or first > DAY_S:
        imported.table[TIME.name] -= first


def _numbers(imported: ImportedTable, header: str, texts: Sequence[str]) -> np.ndarray:
    values = []
    for number, text in zip(imported.cells.table.index, texts, strict=True):
        try:
            values.append(reading.number(text, imported.cells.decimal))
        except ValueError:
            raise ConfigError(
                f"{imported.file}: line {number}: {header} = {text}: not a number; allowed: "
                f"numbers with a decimal {imported.cells.how.rpartition(' ')[2]}, or nothing; "
                f"remove a line that is no reading, or add {column_option(header, IGNORE)}"
            ) from None
    return np.array(values)


def _setup(file: Path) -> dict[str, Any]:
    """The set-up that a TOML file beside the table tells."""
    beside = file.with_suffix(".toml")
    if not beside.exists():
        return {}
    setup = SetupFile(beside)
    try:
        Config().changed(coupon=setup.table("coupon"))
    except ConfigError as error:
        raise ConfigError(f"{beside}: {error}") from None
    return dict(tables.whole(beside, ""))


def _experiment(imported: ImportedTable, settings: Told) -> str | None:
    """The experiment, by what is told or by the columns; None where it is asked for."""
    columns = set(imported.table)
    named = settings.experiment or imported.setup.get("experiment")
    named = [named] if isinstance(named, str) else list(named or ())
    of_rows = [label for label in dict.fromkeys(imported.table.get("experiment", ())) if label]
    for name in of_rows:
        if name not in READINGS:
            raise ConfigError(f"{imported.file}: experiment = {name}: {allowed(name, [*READINGS])}")
    pulled, resists = columns & set(coupons.STRETCHES), columns & set(coupons.STRESSES)
    blown = columns & {*BLOWN, *filter(cavity_of_supply, columns)}
    if len(of_rows) > 1:
        if not blown:
            raise _lacking(imported, next(label for label in of_rows if label != "coupon"))
        return SEVERAL
    named = of_rows or named
    fits = {
        "bending": bool(blown and columns & {*BENDING, *of_markers(columns)}),
        "blocked_force": bool(blown and "force_N" in columns),
        "coupon": bool(pulled and resists | (columns & {"transverse_strain"})),
    }
    only = named[0] if len(named) == 1 and named[0] in fits else ""
    can = [name for name, fit in fits.items() if fit and only in ("", name)]
    if not can:
        raise _lacking(imported, only)
    if len(can) > 1:
        options = [ImportOption("experiment", name) for name in can]
        imported.ask("its columns fit several experiments: which?", *options)
        return None
    imported.setup["experiment"] = can[0]
    return can[0]


def _lacking(imported: ImportedTable, experiment: str) -> ConfigError:
    """Say which columns an experiment needs."""
    has = ", ".join(imported.table) or "no column that is known"
    unused = [header for header, taken in imported.taken.items() if taken is None]
    more = ""
    if unused:
        example = column_option(unused[0], "pressure_kPa")
        more = f"; not known, or without numbers: {', '.join(unused)}: name one by {example}"
    needs = {
        "log": "time and pressure (or volume_ml, of a pump)",
        "states": "pressure (or volume_ml, of a pump)",
        "bending": "pressure and an angle or a place of the tip (or volume_ml, of a pump)",
        "blocked_force": "pressure and force (or volume_ml, of a pump)",
        "coupon": "displacement, strain or stretch, and force or nominal stress",
    }
    allowed = needs[experiment] if experiment else "; or ".join([*needs.values()][2:])
    return ConfigError(f"{imported.file}: {has}{more}; allowed: {allowed}")


def _finger(imported: ImportedTable, settings: Told) -> None:
    """Pressure above that of the air; suction as a negative one."""
    table = imported.table
    if not set(table) & set(BLOWN):
        imported.table["pressure_kPa"] = table[[*filter(cavity_of_supply, table)]].max(axis=1)
        imported.notes.append(
            "no column is pressure_kPa: it is the greatest of the supplies' pressures in each row, "
            "and acts on cavities without a supply of their own"
        )
        return
    if "volume_ml" in table:
        return _pumped(imported, settings)
    name = "suction_kPa" if "suction_kPa" in table else "pressure_kPa"
    value = table[name].to_numpy()
    finite = value[np.isfinite(value)]
    header, column = imported.source(name)
    certain = header in imported.fixed or level(column.unit)[1] == "gauge"
    if not certain and len(finite) and AIR_KPA[0] <= finite[0] <= AIR_KPA[1]:
        air = finite[0] / column.factor
        options = [column_option(header, name, change) for change in (f"-{air:.6g}", "")]
        what = f"{header}: begins at {finite[0]:.4g} kPa: above vacuum, or above the air?"
        imported.ask(what, *options)
    low, high = float(finite.min(initial=0.0)), float(finite.max(initial=0.0))
    if name == "suction_kPa":
        if min(-low, high) > ZERO_KPA:
            raise ConfigError(
                f"{imported.file}: {header} = {low:.4g} to {high:.4g} kPa: suction and pressure in "
                "one table; allowed: one sign, each in a table of its own"
            )
        sign = 1.0 if -low >= high else -1.0  # of a pressure below that of the air
        imported.turn(name, "pressure_kPa", sign)


def _pumped(imported: ImportedTable, settings: Told) -> None:
    """Volume in the cavity by a pump's counter, which may begin at 0 again as the pump turns."""
    blown = [name for name in BLOWN if name in imported.table]
    if len(blown) > 1:
        options = [column_option(imported.source(name)[0], IGNORE) for name in blown]
        imported.ask(f"{' and '.join(blown)}: which was prescribed? the other one:", *options)
        return
    if "withdrawn_ml" in imported.table:
        imported.table["volume_ml"] -= imported.table["withdrawn_ml"]
        imported.notes.append("volume_ml is what was infused without what was withdrawn")
    there = imported.table["volume_ml"].dropna()
    counted = there.to_numpy()
    steps = np.diff(counted)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else math.inf
    falls = (steps < -2 * usual) & (counted[:-1] > RESTARTS * counted.max(initial=0.0))
    turns = np.flatnonzero(falls & (np.abs(counted[1:]) < counted[:-1] / 4)) + 1
    turns = np.array([turn for turn in turns if counted[turn:].max() > usual], dtype=int)
    if len(turns) and settings.withdraws is None:
        row = imported.cells.table.index[there.index[turns[0]]]
        options = [ImportOption("withdraws"), ImportOption("withdraws", False)]
        imported.ask(f"line {row}: the volume begins at 0 again: does the pump withdraw?", *options)
    if settings.withdraws:
        put = np.diff(counted, prepend=0.0)
        put[turns] = counted[turns]
        way = (-1.0) ** np.searchsorted(turns, np.arange(len(counted)), side="right")
        imported.table["volume_ml"] = pd.Series((way * put).cumsum(), there.index)
        imported.notes.append(f"the pump turns where its counter begins at 0: {len(turns)} times")
    _by_frames(imported, settings)
    if TIME.name not in imported.table:
        imported.notes.append("no time: diagnose assumes how fast the pump is")


def _by_frames(imported: ImportedTable, settings: Told) -> None:
    """Times by the numbers of frames, where there are no others."""
    table, rate_hz = imported.table, settings.frame_rate
    if rate_hz is not None and "frame" in table and TIME.name not in table:
        imported.turn("frame", TIME.name, 1 / rate_hz, -table["frame"].iloc[0] / rate_hz)
        imported.notes.append(f"time_s is the frame's number by {rate_hz:g} Hz")


def _times(imported: ImportedTable, settings: Told, rate: str) -> None:
    """Times by time stamps, frames or the rate."""
    if settings.rate is not None:
        imported.setup[rate] = settings.rate
    _by_frames(imported, settings)
    if TIME.name in imported.table:
        return
    if rate in imported.setup:
        imported.notes.append(f"times follow from {rate} = {imported.setup[rate]:g}")
    elif "frame" in imported.table:
        unit = rate.removeprefix("rate_").replace("_per_", "/")
        what = f"frames in place of time: pictures per second (Hz), or the rate ({unit})?"
        imported.ask(what, ImportOption("frame_rate", VALUE), ImportOption("rate", VALUE))
    else:
        option = ImportOption("rate", VALUE)
        imported.notes.append(f"no time: diagnose assumes a rate, unless {option} tells it")


def _coupon(imported: ImportedTable, settings: Told) -> None:
    """Travel and force where length and cross-section are told; else nominal strain and stress."""
    table, setup = imported.table, imported.setup
    for name in ("true_stress_MPa", "true_strain"):
        if name in table and not set(table) & {*coupons.STRETCHES, *coupons.STRESSES}:
            raise ConfigError(f"{imported.file}: {name}: allowed: nominal strain and stress")
    sizes = {**setup, **setup.get("coupon", {})}
    area = (
        settings.area
        or sizes.get("area_mm2")
        or sizes.get("width_mm", 0.0) * sizes.get("thickness_mm", 0.0)
    )
    length = settings.gauge_length or sizes.get("gauge_length_mm")
    nominal = "displacement_mm" not in table and "force_N" not in table
    if not nominal:
        for key, value, name, needs in (
            ("gauge_length", length, "displacement_mm", "length between the grips (mm)"),
            ("area", area, "force_N", "cross-section at rest (mm²)"),
        ):
            if name in table and not value:
                imported.ask(f"{needs}: not told;", ImportOption(key, VALUE))
    if length:
        setup["gauge_length_mm"] = float(length)
    if area:
        setup["area_mm2"] = float(area)
    mode = settings.mode or setup.get("mode")
    setup["mode"] = coupons.MODES[0] if mode in (None, coupons.COMPRESSION) else mode
    if "mode" in table:
        del setup["mode"]
    _unlike_its_name(imported)
    if not imported.questions:
        for name, scale in (("stretch", length), (STRAIN, length), (STRESS, area)):
            if name in imported.table:
                _from_nominal(imported, name, scale if length and area else None)
    _pressed_or_pulled(imported, mode, length or math.nan)
    if nominal and not (length and area):
        imported.notes.append(
            "for coupon --fit; diagnose needs a travel and a force: --gauge-length and --area"
        )


def _pressed_or_pulled(imported: ImportedTable, mode: str | None, length_mm: float) -> None:
    """Turn the signs of a press to those of compression; ask where a pulled one looks like it."""
    table = imported.table
    ways, loads = (
        [n for n in names if n in table] for names in (coupons.STRETCHES, coupons.STRESSES)
    )
    if mode == coupons.COMPRESSION:
        for name in (*ways, *loads):
            at_rest = float(name == "stretch")
            values = table[name].to_numpy() - at_rest
            if pressed(values) is not values:
                imported.turn(name, name, -1.0, 2 * at_rest)
    elif mode is None and "mode" not in table and ways and loads:
        both = table[[ways[0], loads[0]]].dropna().to_numpy()
        strain = (both[:, 0] - both[0, 0]) / (length_mm if ways[0] == "displacement_mm" else 1.0)
        first = first_loading(1 + strain, both[:, 1])
        if first.any() and strain[first].min() >= 0 and is_hollow(strain[first], both[first, 1]):
            options = [
                ImportOption("mode", kind) for kind in (coupons.COMPRESSION, coupons.MODES[0])
            ]
            what = f"{loads[0]} rises ever more steeply, as that of rubber in compression: which?"
            imported.ask(what, *options)


def _from_nominal(imported: ImportedTable, name: str, scale: float | None) -> None:
    """Take what was measured in place of a nominal column, or what is worked out of that.

    Where both are there and disagree, a note has both numbers.

    Args:
        imported: of a coupon.
        name: of the nominal column, which stays where nothing takes its place.
        scale: length between the grips (mm) or cross-section (mm²); None: no number is worked out.
    """
    table = imported.table
    of, key, unit = (
        ("force_N", "area", "mm²") if name == STRESS else ("displacement_mm", "gauge_length", "mm")
    )
    if of in table:
        # differences, as zeros may differ, and slopes, as noise may stand at the ends
        one, other = (table[heading] - table[heading].mean() for heading in (of, name))
        implied = float((one * other).sum() / ((other * other).sum() or math.nan))
        if scale is not None and abs(implied / scale - 1) > ALIKE:
            imported.notes.append(
                f"{of} and {imported.source(name)[0]} disagree: {of} was measured and is taken; by "
                f"both the {key.replace('_', ' ')} is {implied:.4g} {unit}, and {scale:.4g} {unit} "
                "is told"
            )
    elif scale is not None:
        imported.turn(name, of, scale, -scale * (name == "stretch"))
    if of in table or (scale is None and name == STRAIN and "stretch" in table):
        imported.table = table.drop(columns=name)


def _unlike_its_name(imported: ImportedTable) -> None:
    """Ask where a strain begins at 1, as a stretch does, or a stretch far below it."""
    for header, taken in imported.taken.items():
        if taken is None or taken.target not in (STRAIN, "stretch") or header in imported.fixed:
            continue
        begins = float(imported.table[taken.target].dropna().iloc[0])
        if (taken.target == STRAIN) == (begins >= UNSTRETCHED):
            options = [column_option(header, name) for name in (STRAIN, "stretch")]
            imported.ask(f"{header}: begins at {begins:.4g}: a strain, or a stretch?", *options)


def _at_rest(imported: ImportedTable, settings: Told) -> None:
    """Subtract first readings, or ask where they are not those of the state at rest."""
    table = imported.table
    groups = [n for n in ("experiment", "specimen") if n in table]
    alike = [table[n] for n in groups] or [pd.Series(0, index=table.index)]
    for name in [column for column in REST if column in table]:
        first = table[name].groupby(alike, sort=False).transform("first")
        begins = float(first.loc[first.abs().idxmax()])
        noise = AT_REST_SIGMA * CHANNELS[name].noise
        if settings.zero_at_rest:
            table[name] = table[name] - first
        elif settings.zero_at_rest is None and abs(begins) > noise and _begins_at_rest(table):
            what = f"{name} begins at {begins:.4g} {CHANNELS[name].symbol}: zero there?"
            imported.ask(what, ImportOption("zero_at_rest"), ImportOption("zero_at_rest", False))
    if settings.zero_at_rest:
        imported.notes.append("first readings are subtracted: they are those at rest")
    _signs(imported)


def _begins_at_rest(table: pd.DataFrame) -> bool:
    """Say if the control is at rest in the first row, so that the reading should be zero."""
    control = next((name for name in BLOWN if name in table), None)
    if control is None:
        return True
    size = table[control].abs()
    least = 0.0 if control == "volume_ml" else 1.0  # kPa
    return bool(size.iloc[0] <= max(least, 0.02 * float(size.max())))


def _signs(imported: ImportedTable) -> None:
    """Ask where a reading falls as the control rises, which a convention of signs may explain."""
    table = imported.table
    control = next((n for n in (*BLOWN, "displacement_mm") if n in table), None)
    for name in (ANGLE.name, "chord_angle_deg", "force_N"):
        header = next((h for h, r in imported.taken.items() if r and r.target == name), "")
        if (
            control is None
            or name not in table
            or header in imported.fixed
            or imported.setup.get("cavity")
        ):
            continue
        both = table[[control, name]].dropna()
        farthest = both[name].iloc[int(both[control].to_numpy().argmax())] - both[name].iloc[0]
        if farthest < -AT_REST_SIGMA * CHANNELS[name].noise:
            options = [column_option(header, name, change) for change in ("*-1", "")]
            imported.ask(f"{header}: falls as {control} rises: turn its sign?", *options)


def _arrange(imported: ImportedTable, experiment: str) -> None:
    """Columns of the format in its order, rows with a control alone."""
    numbered = of_any_number(imported.table)
    order = [*MEASURED, *numbered, "mode", *coupons.STRETCHES, *coupons.STRESSES]
    foreign = set()
    if experiment in READINGS:
        others = {name for names in READINGS.values() for name in names}
        of_it = {*READINGS[experiment], *controls_of(experiment)}
        foreign = (others | {*BLOWN, *CONTROL.values()}) - of_it
    columns = [
        name for name in dict.fromkeys(order) if name in imported.table and name not in foreign
    ]
    table = imported.table[columns]
    every = (*CONTROL.values(), *BLOWN, STRAIN, "stretch")
    controls = [name for name in dict.fromkeys(every) if name in table]
    kept = table.dropna(subset=controls, how="all")
    if len(kept) < len(table):
        imported.notes.append(f"{len(table) - len(kept)} rows without a control are left out")
    if "cycle" in kept:
        kept = kept.assign(
            cycle=kept["cycle"].map(lambda number: "" if math.isnan(number) else f"{number:g}")
        )
    imported.table = kept


def write(imported: ImportedTable, out: Path) -> tuple[Path, Path]:
    """Write the two files of the format; the TOML says in comments what was taken for what.

    Args:
        imported: without questions.
        out: folder.

    Returns:
        The CSV and the TOML.

    Raises:
        ConfigError: one line, if the table is not valid in the format; nothing stays then.
    """
    target = out / f"{imported.file.stem}.csv"
    if target.resolve() == imported.file.resolve():
        raise ConfigError(f"--out {out}: the table lies there; allowed: another folder")
    document = tomlkit.document()
    for text in (f"from {imported.file.name} ({imported.cells.how})", *_comments(imported)):
        document.add(tomlkit.comment(" ".join(text.split())))
    for key, value in sorted(imported.setup.items(), key=lambda item: isinstance(item[1], Mapping)):
        document.add(key, value)
    text = imported.table.to_csv(index=False, float_format="%.10g", lineterminator="\n")
    _check(imported, text, tomlkit.dumps(document))
    whole.write_together({target: text, target.with_suffix(".toml"): tomlkit.dumps(document)})
    return target, target.with_suffix(".toml")


def _comments(imported: ImportedTable) -> list[str]:
    lines = [f"{name} <- {header} {done}".rstrip() for header, name, done in imported.mapping()]
    return [
        *lines,
        *imported.notes,
        *(f"passed over: {text}" for text in imported.cells.passed_over),
    ]


def _check(imported: ImportedTable, rows: str, setup: str) -> None:
    """Read both files as ``diagnose`` does, unless the rows are nominal."""
    import tempfile

    if STRESS in imported.table or STRAIN in imported.table or "stretch" in imported.table:
        return
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{imported.file.stem}.csv"
        whole.write(file, rows)
        whole.write(file.with_suffix(".toml"), setup)
        try:
            setup_file = SetupFile(file)
            read = measured.read(file, setup_file.experiments)
            setup_file.check_specimens(set(read["specimen"]))
            for experiment, specimen in read.groupby(["experiment", "specimen"]).groups:
                setup_file.of(experiment, specimen)
        except ConfigError as error:
            raise ConfigError(str(error).replace(folder + "/", "")) from None
