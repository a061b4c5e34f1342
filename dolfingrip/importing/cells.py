"""A laboratory's table as cells: encoding, sheet, separator, decimal sign, header and rows."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import date, datetime
from functools import lru_cache
from pathlib import Path
from typing import IO, Any, Final, Literal

import numpy as np
import pandas as pd

from dolfingrip.config import ConfigError
from dolfingrip.files import package, xml
from dolfingrip.importing import arrays
from dolfingrip.importing.header import (
    encodings,
    is_called,
    is_unit,
    named_by_beginning,
    quantities,
    ratio,
    recognise,
    split,
)
from dolfingrip.importing.told import ORDERS, ImportOption, Question, Told

Row = tuple[int, list[str]]
"""Number of a line or row in the file, and its cells."""

SEPARATORS: Final = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "spaces"}
"""Separators in the order in which they are tried, with their names."""

_MISSING: Final = re.compile(
    r"|[-–—−]+|n\.?/?a\.?n?|null|none|ol|over(load|flow)|err(or)?|#n/?[av]|#[^\W\d]+(/0)?[!?]",
    re.IGNORECASE,
)
"""Cells that have no value: those of instruments out of their range and of sheets' errors, too."""
_RULE: Final = re.compile(r"[\s|+:=\-_]*[-=_]{2}[\s|+:=\-_]*")
_END_OF_HEADER: Final = re.compile(r"\W*end[ _]of[ _]header\W*", re.IGNORECASE)

COMMENT: Final = re.compile(r"\s*(#|%(?!\s*[,;|\t])|//)+\s*")
"""What begins a comment; % before a separator is a unit."""

_SIGNS: Final = {".": "point", ",": "comma"}
_GROUPS: Final = " '’\u00a0\u202f\u2009"
_PLAIN: Final = {
    decimal: str.maketrans({**dict.fromkeys(_GROUPS), ",": None, ".": None, "−": "-", decimal: "."})
    for decimal in ".,"
}
_UNGROUPED: Final = str.maketrans(dict.fromkeys(_GROUPS))
_BY_SIGN: Final = {
    decimal: re.compile(
        rf"[+\-−]?(?:\d*|[1-9]\d{{0,2}}(?:\{other}\d{{3}})+)(?:\{decimal}\d*)?(?:[eE].*)?"
    )
    for decimal, other in (".,", ",.")
}
"""Numbers by their decimal sign, whose thousands the other sign may group."""
_DATE: Final = r"\d{1,4}(?P<sign>[-./])\d{1,2}(?P=sign)\d{1,4}"
_NUMBER: Final = re.compile(rf"[+\-−]?[\d{_GROUPS}.,]*\d[.,]?(?:[eE][+\-−]?\d+)?")
_SPREAD: Final = re.compile(rf"(?<=\d) ?(?:±|\+/[-−]) ?{_NUMBER.pattern}")
"""What a number is uncertain by, behind it."""
_WITH_UNIT: Final = re.compile(rf"({_NUMBER.pattern}) ?([^\W\d][^\s;]*(?: [^\W\d][^\s;]*)?|[%°‰])")
_CLOCK: Final = re.compile(
    rf"(?P<date>{_DATE}(?:[ T]|, ?))?"
    r"(?P<time>\d+:\d\d:\d\d(?:[.,]\d+)?|\d+:\d\d[.,]\d+|\d+:\d\d(?= ?[ap]\.?m))"
    r"(?P<half> ?[ap]\.?m\.?)?(?P<zone>Z|[+-]\d\d:?\d\d)?",
    re.IGNORECASE,
)
_NAMED: Final = re.compile(
    r"\"?([^\W\d][\w ./%°()\[\]]*?)\"?\s*[:=]\s*([+\-−]?\d+(?:[.,]\d+)?(?:[eE][+\-]?\d+)?)(?![\d:])"
    r"(?: ?([^\W\d:=][^\s;:=,]*|[%°‰])(?=[\s;,}]|$))?"
)
"""A name, a number and its unit."""
_ALONE: Final = re.compile(r"\s*[+-]?\d*\.?\d+(?:[eE][+-]?\d+)?\s*")
"""A line of one number, whose decimal comma would be that of two columns."""
_PAIR: Final = re.compile(r"(\d+):([0-5]\d)")
_TORN: Final = re.compile(r"\d[;\t|]|[;\t|]\d|\d,\s*\d+[;\t| ]")
_ALIKE: Final = str.maketrans("456789", "111111")
"""Digits that no rule tells apart: a 0 begins no thousands, 2 and 3 are in units, as in cm2."""
_DAY_S: Final = 86400.0


@dataclass(frozen=True, slots=True)
class Cells:
    """A table as it stands in a file.

    Attributes:
        table: texts of the data rows, by their numbers in the file; a unit that a row of units
            tells stands behind the name of its column.
        passed_over: lines that are neither header nor data, as they stand.
        decimal: the decimal sign.
        how: encoding and separator, or sheet, and decimal sign in words, for people.
    """

    table: pd.DataFrame
    passed_over: list[str]
    decimal: str
    how: str = ""

    @property
    def header(self) -> list[str]:
        """Name of each column."""
        return [*self.table]

    def column(self, place: int) -> list[str]:
        """The cells of a column."""
        return self.table.iloc[:, place].tolist()


def is_clock(cell: str) -> bool:
    """Say if a cell is a time of day, or a date with one."""
    return bool(_CLOCK.fullmatch(cell.strip()))


def seconds(texts: Sequence[str], order: str = "") -> list[float] | None:
    """Times of day, or dates with one, in seconds; a day is over where they fall by half of it.

    Args:
        texts: cells of a column; empty ones are NaN.
        order: of day, month and year, as in ``dmy``, where the dates may have two.

    Returns:
        The times; None where a cell is none.

    Raises:
        AmbiguousDate: the dates may have two orders.
    """
    if not is_clock(_first(texts)):
        return None
    filled = [text.strip() for text in texts if not missing(text)]
    parsed = [match for text in filled if (match := _CLOCK.fullmatch(text))]
    dates = [match["date"] for match in parsed if match["date"]]
    alike = len({match["zone"] for match in parsed}) == 1 and len(dates) in (0, len(parsed))
    if len(parsed) < len(filled) or not alike:
        return None
    clock = np.array([_of_day(match) for match in parsed])
    over = np.diff(clock, prepend=clock[0]) < -_DAY_S / 2
    clock += _days(dates, order) if dates else _DAY_S * over.cumsum()
    times = map(float, clock)
    return [float("nan") if missing(text) else next(times) for text in texts]


class AmbiguousDate(Exception):
    """Dates have two orders of day and month."""


def _days(dates: Sequence[str], order: str) -> list[float]:
    """Seconds to the beginning of each day, from that of the first.

    Raises:
        AmbiguousDate: the dates may have two orders.
    """
    parts = [[int(part) for part in re.split(r"[-./]", text.strip(" T,"))] for text in dates]
    orders = ["ymd"] if re.match(r"\d{4}", dates[0]) else ["dmy"] if "." in dates[0] else [*ORDERS]
    candidates = set()
    for layout in [order] if order in orders else orders:
        with suppress(ValueError):  # a month 13
            days = [date(*(p[layout.index(k)] for k in "ymd")).toordinal() for p in parts]
            candidates.add(tuple((day - days[0]) * _DAY_S for day in days))
    if len(candidates) != 1:
        raise AmbiguousDate(dates[0].strip())
    return [*candidates.pop()]


def _of_day(match: re.Match[str]) -> float:
    """Seconds of a time of day; two numbers are minutes and seconds, before am and pm hours."""
    parts = [float(part.replace(",", ".")) for part in match["time"].split(":")]
    if match["half"]:
        parts = [parts[0] % 12 + 12 * ("p" in match["half"].casefold()), *parts[1:], 0.0][:3]
    return float(sum(part * 60.0**i for i, part in enumerate(reversed(parts))))


def pairs(texts: Sequence[str]) -> list[float] | None:
    """Hours and minutes as hours, minutes and seconds as minutes; None where a cell is no such."""
    if not _PAIR.fullmatch(_first(texts)):
        return None
    matches = [_PAIR.fullmatch(text.strip()) for text in texts]
    numbers = [float(match[1]) + float(match[2]) / 60.0 for match in matches if match]
    return numbers if len(numbers) == len(matches) else None


def missing(cell: str) -> bool:
    """Say if a cell has no value."""
    return bool(_MISSING.fullmatch(cell.strip()))


def _first(texts: Iterable[str]) -> str:
    """The first cell of a column that has a value."""
    return next((text.strip() for text in texts if not missing(text)), "")


def _measure(cell: str) -> tuple[str, str]:
    """Number and unit of a cell that has both; else the cell and nothing."""
    match = _WITH_UNIT.fullmatch(cell.strip())
    return (match[1].strip(), match[2]) if match and is_unit(match[2]) else (cell, "")


def _is_number(cell: str) -> bool:
    return bool(_NUMBER.fullmatch(cell.strip())) or is_clock(cell) or bool(_measure(cell)[1])


def number(cell: str, decimal: str) -> float:
    """The number in a cell, NaN where there is none.

    Args:
        cell: as it stands in the file.
        decimal: the decimal sign; the other sign groups thousands.

    Raises:
        ValueError: the cell is no number.
    """
    text = cell.strip()
    if missing(text):
        return float("nan")
    if not _NUMBER.fullmatch(text):
        raise ValueError(text)
    return float(text.translate(_PLAIN[decimal]))


def read(file: Path, settings: Told) -> Cells:
    """Read the one table of a file, or that which is told.

    Args:
        file: CSV, TSV, text, XLSX or MAT.
        settings: encoding, sheet and decimal sign, where they are told.

    Raises:
        Question: the sheet or the decimal sign cannot be told from the file.
        ConfigError: one line, where there is no table in the file.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None
    if (other := named_by_beginning(data)) is not None:
        raise ConfigError(f"{file}: {other}")
    if file.suffix.lower() == ".mat" or data.startswith((b"MATLAB", b"\x89HDF")):
        tables = _of_arrays(file)
    elif data.startswith(b"PK\x03\x04"):
        tables = _sheets(file, settings)
    else:
        try:
            by_encoding = [
                _of_text(text, encoding, settings)
                for encoding, text in _texts(data, settings.encoding).items()
            ]
        except ConfigError as error:
            raise ConfigError(f"{file}: {error}") from None
        named = [column.header for column in settings.column]
        tables = max(by_encoding, key=lambda tables: _recognised(tables, named))
    if not tables:
        raise ConfigError(
            f"{file}: no table in it; allowed: a header and rows with at least two numbers each, "
            "their units in the header, separated by commas, semicolons, tabs, bars or spaces, or "
            "a sheet of an .xlsx file"
        )
    if settings.sheet is not None and settings.sheet not in tables:
        raise ConfigError(f"--sheet {settings.sheet}: allowed: {', '.join(tables)}")
    if settings.sheet is None and len(tables) > 1:
        options = [ImportOption("sheet", name) for name in tables]
        raise Question(f"{len(tables)} tables: which?", options)
    return next(cells for name, cells in tables.items() if settings.sheet in (None, name))


def _recognised(tables: dict[str, Cells], named: Sequence[str]) -> float:
    """Return how many columns are told or known by their names; half of one that is not certain."""
    columns = [recognise(name) for cells in tables.values() for name in cells.header]
    return sum(
        any(column.header in name for name in named)
        + (bool(column.readings) or 0.5 * bool(column.why))
        for column in columns
    )


def _of_arrays(file: Path) -> dict[str, Cells]:
    """Tables of a MAT file, by the names of their arrays."""
    by_name = {}
    for name, columns in arrays.tables(file).items():
        texts = pd.DataFrame(columns, index=range(1, len(next(iter(columns.values()))) + 1))
        texts = texts.map(lambda value: "" if value != value else repr(float(value)))
        by_name[name] = Cells(texts, [], ".", f"arrays {name}, decimal point")
    return by_name


def _sheets(file: Path, settings: Told) -> dict[str, Cells]:
    """Tables of a workbook, by the name of their sheet."""
    by_name: dict[str, Cells] = {}
    for sheet in _workbook(file).worksheets:
        areas = sheet.merged_cells.ranges
        merged = {place for area in areas for above in [*area.rows][1:] for place in above}
        values = []
        for row in sheet.iter_rows():
            filled = [cell for cell in row if cell.value is not None]
            below = any((cell.row, cell.column) in merged for cell in row)
            values.append([] if below and not filled else list(row))
        for area in areas:
            if area.size["columns"] < sheet.max_column:  # no title
                of_all = sheet.cell(area.min_row, area.min_col)
                for row in filter(None, values[area.min_row - 1 : area.max_row]):
                    row[area.min_col - 1 : area.max_col] = [of_all] * area.size["columns"]
        data = [row for row in values if row and _is_data([_text(cell, ".") for cell in row])]
        texts = (cell.value for row in data for cell in row if isinstance(cell.value, str))
        decimal = _sign(texts, "", settings)
        rows = [(i + 1, [_text(cell, decimal) for cell in row]) for i, row in enumerate(values)]
        for more, part in _tables(rows, decimal).items():
            name = f"{sheet.title} {more}".strip()
            by_name[name] = replace(part, how=f"sheet {name}, decimal {_SIGNS[decimal]}")
    return by_name


MOST_CELLS: Final = 20_000_000
"""Cells of a sheet, empty ones before the last one too: a million rows of twenty columns."""


def _workbook(file: Path) -> Any:
    """A workbook whose sheets are not larger than they may be.

    Raises:
        ConfigError: one line.
    """
    import openpyxl  # only workbooks need it

    try:
        with package.opened(file) as packed:
            for part in packed.namelist():
                with packed.open(part) as stream:
                    rows, columns = _extent(stream)
                if rows * columns > MOST_CELLS:
                    raise ConfigError(
                        f"{file}: {part}: {rows} rows by {columns} columns; allowed: up to "
                        f"{MOST_CELLS} cells"
                    )
        return openpyxl.load_workbook(file, data_only=True)
    except ConfigError:
        raise
    except Exception as error:  # any error of the parser on a broken file
        raise ConfigError(f"{file}: not readable as a workbook: {error}") from None


def _extent(part: IO[bytes]) -> tuple[int, int]:
    """Rows and columns of a sheet up to its last cell, merged ones too; 0 of another part.

    openpyxl makes each of these cells, also empty ones.
    """
    from openpyxl.utils import range_boundaries

    rows = columns = 0
    try:
        for element in xml.elements(part):
            name = element.tag.rpartition("}")[2]
            if place := {"c": element.get("r"), "mergeCell": element.get("ref")}.get(name):
                _, _, column, row = range_boundaries(place)
            elif name == "row" and len(element):  # its cells may have no places of their own
                column, row = len(element), int(element.get("r", 0))
            else:
                continue
            rows, columns = max(rows, row), max(columns, column)
    except xml.DocumentTypeError:
        raise
    except xml.XmlError:  # a picture; of a broken sheet openpyxl reads no more than was read here
        pass
    return rows, columns


def _tables(rows: list[Row], decimal: str = ".") -> dict[str, Cells]:
    """Tables below one another, by the line that stands above each; "" where there is one.

    A header that is repeated where the first column goes on is left out.
    """
    parts: list[list[Row]] = [[]]
    between: list[Row] = []
    last: list[str] | None = None
    for row in rows:
        if not _is_data(row[1]):
            between.append(row)
            continue
        names = [cells for _, cells in between if _is_header(cells)]
        if last is not None and names:
            above = [cells for _, cells in parts[-1]]
            if all(texts in above for _, texts in between if any(texts)) and _goes_on(last, row[1]):
                between = []
            else:
                parts.append([])
        parts[-1] += [*between, row]
        between, last = [], row[1]
    parts[-1] += between
    titled = [(part[0][1], cells) for part in parts if (cells := _table(part, decimal))]
    if len(titled) < 2:
        return {"": titled[0][1]} if titled else {}
    titles = [" ".join(dict.fromkeys(filter(None, first))) for first, _ in titled]
    clear = [title.isascii() and titles.count(title) == 1 for title in titles]
    return {
        titles[i] if clear[i] else f"table {i + 1}": cells for i, (_, cells) in enumerate(titled)
    }


def _is_header(cells: list[str]) -> bool:
    """Say if a row may be names of columns: it has two at least, and no number."""
    filled = [cell for cell in cells if not missing(cell)]
    return len(filled) > 1 and not any(map(_is_number, filled)) and not cells[0].startswith("#")


def _goes_on(before: list[str], row: list[str]) -> bool:
    """Say if the first number of a row is above that of a row before."""
    first, second = (re.sub(r"[^\d.]", "", cells[0].replace(",", ".")) for cells in (before, row))
    try:
        return float(second) > float(first)
    except ValueError:
        return False


def _text(cell: Any, decimal: str) -> str:
    """The text of a sheet's cell as it is shown: percent, too."""
    value = cell.value
    if isinstance(value, datetime):
        return value.isoformat(" ").removesuffix(" 00:00:00")
    if isinstance(value, (int, float)):
        shown = f"{100 * value:.15g} %" if "%" in cell.number_format else str(value)
        return shown.replace(".", decimal)
    return "" if value is None else _alone(str(value))


def _texts(data: bytes, encoding: str | None) -> dict[str, str]:
    """Decode bytes in each encoding that they may have, the likeliest first."""
    marks = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
    name = encoding or next((marks[mark] for mark in marks if data.startswith(mark)), "utf-8")
    if not encoding and name == "utf-8" and 4 * data[:200].count(0) > len(data[:200]):
        name = "utf-16-be" if data[:1] == b"\0" else "utf-16-le"
    try:
        return {name: data.decode(name)}
    except (LookupError, UnicodeDecodeError):
        if encoding or name != "utf-8":
            raise ConfigError(
                f"--encoding {name}: unknown, or the file is not in it; allowed: as in cp1252, "
                "gb18030"
            ) from None
    from charset_normalizer import from_bytes  # files in Unicode need none

    # all in which the bytes are letters: the names of columns say which
    return {
        match.encoding: str(match)
        for match in from_bytes(data, cp_isolation=encodings(), threshold=1.0)
    }


def _of_text(text: str, encoding: str, settings: Told) -> dict[str, Cells]:
    """Tables in a text; their separator is the one by which most rows are numbers."""
    lines = [
        (i + 1, line) for i, line in enumerate(text.splitlines())
        if line.strip() and not _RULE.fullmatch(line)
    ]  # fmt: skip
    ends = [i for i, (_, line) in enumerate(lines) if _END_OF_HEADER.fullmatch(line)]
    if ends:  # numbers above are those of the instrument
        lines = [
            (i, f"#{line}") if n < ends[-1] else (i, line) for n, (i, line) in enumerate(lines)
        ]
    if lines and lines[0][1].casefold().startswith("sep="):
        lines = lines[1:]
    lines = _labelled([(i, _unmonitored(line)) for i, line in lines])
    separated = (
        (separator, [(i, _split(line, separator)) for i, line in lines])
        for separator in SEPARATORS
        if any(separator in line for _, line in lines)
    )
    separator, rows = max(separated, key=lambda pair: len(_data(pair[1])[1]), default=(",", []))
    if not (data := _data(rows)[1]):
        return {}
    decimal = _sign((cell for _, row in data for cell in row), separator, settings)
    how = f"{encoding}, {SEPARATORS[separator]}, decimal {_SIGNS[decimal]}"
    return {name: replace(cells, how=how) for name, cells in _tables(rows, decimal).items()}


def _unmonitored(line: str) -> str:
    """A line with a cell for the time of day that a serial monitor writes before an arrow."""
    stamp, arrow, written = line.partition(" -> ")
    if not arrow or not is_clock(stamp):
        return line
    return next((sign for sign in "\t;," if sign in written), "\t").join((stamp, written))


def _labelled(lines: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """Lines with tabs of a log that has names in each, as in ``P: 12.3 kPa, A: 45.2 deg``.

    A name that comes back begins a row, which has the time stamp of its first line. A log of a
    single name, or of none, without stamps is a column beside the number of its row.
    """
    entries: list[tuple[int, str, str, str]] = []
    alone = [bool(_ALONE.fullmatch(text)) for _, text in lines]
    if len(lines) > 2 and 2 * sum(alone) > len(lines):
        head = "value" if alone[0] else lines[0][1].strip()
        readings = [line for line in lines[not alone[0] :] if re.search(r"\d", line[1])]
        entries = [(number, "", head, text.strip()) for number, text in readings]
    elif any(set(":=") & set(text) for _, text in lines[-3:]):  # the last one may be cut off
        parsed = [(number, text, [*_NAMED.finditer(text)]) for number, text in lines]
        names = [tuple(match[1].strip() for match in parts) for _, _, parts in parsed]
        usual = Counter(filter(None, names)).most_common(1)
        kept = [
            line for line, of_line in zip(parsed, names, strict=True)
            if of_line and (len(usual[0][0]) == 1 or of_line == usual[0][0])  # no message
        ]  # fmt: skip
        if 2 * len(kept) >= len(lines):
            for n, text, parts in kept:
                stamp = text[: parts[0].start()].strip(" ->{[]\t,;")
                entries += [(n, stamp, m[1].strip(), f"{m[2]} {m[3] or ''}") for m in parts]
    if not entries:
        return lines
    rows: list[tuple[int, dict[str, str]]] = []
    for number, stamp, name, value in entries:
        if not rows or name in rows[-1][1]:
            rows.append((number, {"stamp": stamp} if stamp else {}))
        rows[-1][1][name] = value
    columns = list(dict.fromkeys(name for _, row in rows for name in row))
    if len(columns) == 1:
        rows = [(number, {"frame": f"{i}", **row}) for i, (number, row) in enumerate(rows)]
        columns = ["frame", *columns]
    texts = [(number, [row.get(name, "") for name in columns]) for number, row in rows]
    return [(n, "\t".join(cells)) for n, cells in [(rows[0][0] - 1, columns), *texts]]


def _split(text: str, separator: str) -> list[str]:
    text = COMMENT.sub("#", text, count=1) if COMMENT.match(text) else text
    if separator == " ":
        return re.split(r"\s+", text.strip())
    cells = next(csv.reader([text], delimiter=separator, skipinitialspace=True))
    return [_alone(cell.strip()) for cell in cells]


def _alone(cell: str) -> str:
    """A cell without what its number is uncertain by."""
    return _SPREAD.sub("", cell) if "±" in cell or "+/" in cell else cell


def _is_data(cells: list[str]) -> bool:
    """Say if a row has two numbers at least, and no cell is several cells of another separator."""
    kinds = [_kind(cell.translate(_ALIKE)) for cell in cells]
    return kinds.count("number") >= 2 and "torn" not in kinds and not cells[0].startswith("#")


@lru_cache(10_000)
def _kind(cell: str) -> Literal["missing", "number", "torn", "text"]:
    """Kind of a cell; one that is several cells of another separator is torn."""
    if missing(cell):
        return "missing"
    if _is_number(cell):
        return "number"
    return "torn" if _TORN.search(cell) else "text"


def _data(rows: list[Row]) -> tuple[int, list[Row]]:
    """The usual number of cells of data rows, and the data rows of that number."""
    data = [row for row in rows if _is_data(row[1])]
    if not data:
        return 0, []
    width = Counter(len(cells) for _, cells in data).most_common(1)[0][0]
    return width, [row for row in data if len(row[1]) == width]


def _table(rows: list[Row], decimal: str) -> Cells | None:
    """Header and data of rows; rows of other lengths in between are refused."""
    width, data = _data(rows)
    if len(data) < 2:
        return None
    first, last = data[0][0], data[-1][0]
    above = [(i, _fitted(cells, width)) for i, cells in rows if i < first]
    kept: list[Row] = []
    for i, cells in rows:
        if first <= i <= last and any(cells) and not cells[0].startswith("#"):
            if (fitted := _fitted(cells, width)) is None:
                raise ConfigError(
                    f"line {i}: {len(cells)} entries; allowed: as many as above, {width}"
                )
            kept.append((i, fitted))
    titles = [
        (i, cells) for i, cells in above
        if cells is not None and (filled := [_bare(cell) for cell in cells if cell])
        and (len(filled) > width // 2 or (len(filled) > 1 and all(map(_tells_unit, filled))))
    ]  # fmt: skip
    header, used = _header([cells for _, cells in titles], width)
    of_header = {i for i, _ in titles[len(titles) - used :]} if used else set()
    lines, texts = zip(*kept, strict=True)  # a line of a log may have several rows
    table = pd.DataFrame(texts, lines, dtype=object)
    summaries = _summaries(table)
    over = [" ".join(cells) for i, cells in rows if i < first and i not in of_header]
    over += [" ".join(cells) for cells in table[summaries].to_numpy()]
    over += [" ".join(cells) for i, cells in rows if i > last]
    table = _with_names(table[~summaries].copy(), header, decimal)
    return Cells(table, [text for text in over if text.strip()], decimal)


def _with_names(table: pd.DataFrame, header: list[str], decimal: str) -> pd.DataFrame:
    """Columns by their names, with units that stand in the cells; dates before times of day."""
    names = dict(enumerate(header))
    for i in range(
        len(names) - 1, 0, -1
    ):  # units may have a column of their own behind the numbers
        units = table.loc[~table[i - 1].map(missing), i].unique()
        if (
            (not names[i] or is_called(names[i], "unit"))
            and len(units)
            and all(is_unit(t) and not _is_number(t) for t in units)
        ):
            table[i - 1] += " " + table.pop(i)
            del names[i]
    for i in table:
        names[i], table[i] = _without_units(names[i], table[i], decimal)
    dates = [i for i in table if table[i].str.fullmatch(_DATE).all()]
    clocks = [
        i for i in table if table[i].map(is_clock).all() and not table[i].str.match(_DATE).any()
    ]
    if len(dates) == len(clocks) == 1:
        table[clocks[0]] = table[dates[0]] + " " + table[clocks[0]]
    count = Counter(names.values())
    table = table[[i for i in table if names[i] or table[i].any()]]
    for i in names:
        more = f" #{i + 1}" if count[names[i]] > 1 else ""
        names[i] = names[i] + more if names[i] else f"column {i + 1}"
    return table.rename(columns=names)


def _summaries(table: pd.DataFrame) -> pd.Series:
    """Rows that are called a mean or the like, and last rows with a word where numbers stand."""
    called = table.map(lambda cell: is_called(cell, "summary")).any(axis=1)
    if 2 * called.sum() > len(table):  # names of specimens
        return called & False
    kinds = table.map(lambda cell: _kind(cell.translate(_ALIKE)))
    of_numbers = (kinds[~called] == "number").mean() > 0.5
    first = (table != "").cumsum(axis=1) == 1
    word = kinds.isin(["text", "torn"]) & first & of_numbers
    return called | (called | word.any(axis=1))[::-1].cummin()[::-1]


def _without_units(name: str, column: pd.Series, decimal: str) -> tuple[str, pd.Series]:
    """Name and cells of a column, with the unit that the cells have in its name.

    Numbers in another unit than the header's, or than the first cell's, become those in that one.
    """
    alike = {cell.translate(_ALIKE): cell for cell in column}.values()
    units = dict.fromkeys(_measure(cell)[1] for cell in alike if not missing(cell))
    named_unit = split(name)[1]
    unit = named_unit or next(filter(None, units), "")
    ratios = {other: ratio(other, unit) if other or not named_unit else 1.0 for other in units}
    if not any(units) or None in ratios.values():
        return name, column
    measures = column.map(_measure)
    scaled = [
        value if (scale := ratios.get(other) or 1.0) == 1.0
        else f"{number(value, decimal) * scale:.15g}".replace(".", decimal)
        for value, other in measures
    ]  # fmt: skip
    return name if named_unit else f"{name} [{unit}]", pd.Series(scaled, column.index)


def _fitted(cells: list[str], width: int) -> list[str] | None:
    """A row cut or filled with empty cells to a width; None where more would be cut."""
    cells = [cell.strip() for cell in cells]
    if cells and cells[0].startswith("#"):
        cells = [cells[0].lstrip("#"), *cells[1:]] if cells[0] != "#" else cells[1:]
    if any(cells[width:]) or len(cells) < max(2, width - 1):
        return None
    return [*cells[:width], *[""] * (width - len(cells))]


def _below(upper: list[str], lower: list[str]) -> list[str]:
    """Names in two rows, where the lower one is blank below names of the upper one."""
    if all(lower[i] for i in range(len(lower)) if upper[i]):
        return lower
    joined, over = [], ""
    for above, below in zip(upper, lower, strict=True):
        over = above or (over if below else "")
        joined.append(f"{over} {below}".strip())
    return joined


def _bare(cell: str) -> str:
    """A cell without brackets around all of it."""
    within = re.fullmatch(r"[(\[（［]\s*(.*?)\s*[)\]）］]", cell)
    return within[1] if within else cell


def _tells_unit(cell: str) -> bool:
    return is_unit(cell) and not re.search(r"\d[.,]", cell)


def _header(names: list[list[str]], width: int) -> tuple[list[str], int]:
    """Names of columns from the rows above the data, and how many of these rows they are."""
    bare = [[_bare(cell) for cell in row] for row in names]
    of_units = [2 * sum(map(_tells_unit, row)) > sum(map(bool, row)) for row in bare]
    named = [len({q for cell in row for q in quantities(cell)}) for row in names]
    at = max(
        (i for i in range(len(names)) if not of_units[i]), key=lambda i: (named[i], i), default=None
    )
    if at is None:
        return [""] * width if not names else names[-1], min(len(names), 1)
    called = _below(names[at - 1], names[at]) if at and not of_units[at - 1] else names[at]
    units = next((bare[i] for i in reversed(range(len(names))) if of_units[i]), [""] * width)
    joined = [
        f"{name} [{unit}]" if name and unit and (i or _tells_unit(unit)) else name
        for i, (name, unit) in enumerate(zip(called, units, strict=True))
    ]
    return joined, len(names) - at


def _sign(texts: Iterable[str], separator: str, settings: Told) -> str:
    """The decimal sign of cells, as it is told or as they tell it.

    Raises:
        ConfigError: one line, where the numbers have no sign in common.
        Question: 1,234 may be a thousand or one, and nothing else in the table tells.
    """
    alike = {text.translate(_ALIKE): text for text in texts}.values()
    cells = [_measure(text)[0].strip() for text in alike if not re.fullmatch(_DATE, text)]
    numbers = [cell for cell in cells if _NUMBER.fullmatch(cell)]
    signed = [cell.translate(_UNGROUPED) for cell in numbers if "." in cell or "," in cell]
    certain = not signed or (separator == "," and not any("," in cell for cell in signed))
    if settings.decimal or certain:
        return settings.decimal or "."
    signs = [sign for sign in ".," if all(map(_BY_SIGN[sign].fullmatch, signed))]
    if len(signs) == 1:
        return signs[0]
    if not signs:
        odd = [cell for cell in signed if not any(r.fullmatch(cell) for r in _BY_SIGN.values())]
        raise ConfigError(
            f"its numbers have points and commas without a rule, as {[*odd, *signed][0]}; "
            "allowed: one decimal sign"
        )
    if any(re.fullmatch(r"[+\-−]?\d{4,}([.,]\d+)?", cell) for cell in numbers):
        return "." if any("." in cell for cell in signed) else ","  # no thousands are grouped
    raise Question(
        f"{signed[0]}: a decimal sign, or thousands?",
        [ImportOption("decimal", sign) for sign in ".,"],
    )
