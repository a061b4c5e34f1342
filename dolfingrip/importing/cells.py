"""A laboratory's table as cells: encoding, sheet, separator, decimal sign, header and rows."""

from __future__ import annotations

import csv
import datetime
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pandas as pd

from dolfingrip.config import ConfigError
from dolfingrip.importing.told import Question, Told, line

Row = tuple[int, list[str]]
"""Number of a line or row in the file, and its cells."""

SEPARATORS: Final = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "spaces"}
"""Separators in the order in which they are tried, with their names."""

ENCODINGS: Final = ("cp1252", "cp932", "gb18030", "big5", "euc_jp", "mac_roman")
"""Encodings of files that are not in Unicode: Western Europe, Japan, China."""

MISSING: Final = frozenset(
    {"", "-", "--", "–", "na", "n/a", "nan", "null", "none", "#n/a", "#div/0!"}
)
"""Cells, in small letters, that have no value."""

COMMENT: Final = re.compile(r"\s*(#|%|//)+\s*")
_GROUPS: Final = " '’\u00a0\u202f\u2009"
_NUMBER: Final = re.compile(rf"[+\-−]?[\d{_GROUPS}.,]*\d[.,]?([eE][+\-−]?\d+)?")
_CLOCK: Final = re.compile(
    r"(?P<date>\d{1,4}[-./]\d{1,2}[-./]\d{1,4}(?:[ T]|, ?))?"
    r"(?P<time>\d+:\d\d:\d\d(?:[.,]\d+)?|\d+:\d\d[.,]\d+|\d+:\d\d(?= ?[ap]\.?m))"
    r"(?P<half> ?[ap]\.?m\.?)?",
    re.IGNORECASE,
)
_PAIR: Final = re.compile(r"(\d+):([0-5]\d)")
_DAY_S: Final = 86400.0


@dataclass(frozen=True, slots=True)
class Cells:
    """A table as it stands in a file.

    Attributes:
        header: name of each column, with its unit where a row of units tells it.
        rows: data rows, all as long as the header.
        decimal: the decimal sign.
        how: encoding, separator and decimal sign in words, for people.
        passed_over: lines that are neither header nor data, as they stand.
    """

    header: list[str]
    rows: list[Row]
    decimal: str
    how: str
    passed_over: list[str]

    def column(self, place: int) -> list[str]:
        """The cells of a column."""
        return [cells[place] for _, cells in self.rows]


def is_clock(cell: str) -> bool:
    """Say if a cell is a time of day, or a date with one."""
    return bool(_CLOCK.fullmatch(cell.strip()))


def seconds(texts: Sequence[str]) -> list[float] | None:
    """Times of day, or dates with one, in seconds; a day is over where they fall by half of it.

    Args:
        texts: cells of a column; empty ones are NaN.

    Returns:
        The times; None where a cell is none, or where the order of day and month is not certain.
    """
    found = [_CLOCK.fullmatch(text.strip()) for text in texts if text.strip()]
    told = [each for each in found if each]
    dates = [each["date"] for each in told]
    iso = all(date and re.fullmatch(r"\d{4}-\d\d-\d\d[ T]", date) for date in dates)
    if len(told) < len(found) or not told or (not iso and len(set(dates)) > 1):
        return None
    clock = [_of_day(each) + (_days(each["date"]) if iso else 0.0) for each in told]
    for i in range(1, len(clock) if not iso else 0):
        while clock[i] < clock[i - 1] - _DAY_S / 2:
            clock[i] += _DAY_S
    times = iter(clock)
    return [next(times) if text.strip() else float("nan") for text in texts]


def _of_day(told: re.Match[str]) -> float:
    """Seconds of a time of day; two numbers are minutes and seconds, before am and pm hours."""
    parts = [float(each.replace(",", ".")) for each in told["time"].split(":")]
    if told["half"]:
        parts = [parts[0] % 12 + 12 * ("p" in told["half"].casefold()), *parts[1:], 0.0][:3]
    return float(sum(each * 60.0**i for i, each in enumerate(reversed(parts))))


def _days(date: str) -> float:
    """Seconds to the beginning of a day, from that of another."""
    return datetime.date.fromisoformat(date[:10]).toordinal() * _DAY_S


def pairs(texts: Sequence[str]) -> list[float] | None:
    """Hours and minutes as hours, minutes and seconds as minutes; None where a cell is no such."""
    found = [_PAIR.fullmatch(text.strip()) for text in texts]
    told = [float(each[1]) + float(each[2]) / 60.0 for each in found if each]
    return told if len(told) == len(found) else None


def number(cell: str, decimal: str) -> float:
    """The number in a cell, NaN where there is none.

    Args:
        cell: as it stands in the file.
        decimal: the decimal sign; the other sign groups thousands.

    Raises:
        ValueError: the cell is no number.
    """
    text = cell.strip()
    if text.casefold() in MISSING:
        return float("nan")
    if not _NUMBER.fullmatch(text):
        raise ValueError(text)
    for sign in _GROUPS + (",."[decimal == ","]):
        text = text.replace(sign, "")
    return float(text.replace("−", "-").replace(decimal, "."))


def readings(file: Path, told: Told) -> Iterator[Cells]:
    """Read a file in each encoding and separator in which it is a table.

    Args:
        file: CSV, TSV, text or XLSX.
        told: encoding, sheet and decimal sign, where they are told.

    Yields:
        The readings of the file, the likeliest first. Of a file in Unicode and of a sheet there is
        one.

    Raises:
        Question: the sheet or the decimal sign cannot be told from the file.
        ConfigError: one line, where there is no table in the file.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None
    found = False
    if data.startswith(b"PK\x03\x04"):
        for name, rows in _sheets(file, told).items():
            if (cells := _table(rows, "", f"sheet {name}")) is not None:
                found = True
                yield cells
    else:
        for encoding, text in _texts(data, told.encoding):
            if (cells := _of_text(text, encoding, told)) is not None:
                found = True
                yield cells
    if not found:
        raise ConfigError(
            f"{file}: no table in it; allowed: a header and rows with at least two numbers each, "
            "their units in the header, separated by commas, semicolons, tabs, bars or spaces, or "
            "a sheet of an .xlsx file"
        )


def _sheets(file: Path, told: Told) -> dict[str, list[Row]]:
    sheets = pd.read_excel(file, sheet_name=None, header=None, dtype=object, engine="openpyxl")
    found = {
        str(name): [
            (i + 1, [_text(cell) for cell in row]) for i, row in enumerate(sheet.to_numpy())
        ]
        for name, sheet in sheets.items()
    }
    if told.sheet is not None:
        if told.sheet not in found:
            raise ConfigError(f"--sheet {told.sheet}: allowed: {', '.join(found)}")
        return {told.sheet: found[told.sheet]}
    tables = [name for name, rows in found.items() if _table(rows, "", "")]
    if len(tables) > 1:
        raise Question(
            f"{len(tables)} sheets have tables: which?", [line("sheet", name) for name in tables]
        )
    return {name: found[name] for name in tables}


def _text(cell: object) -> str:
    """The text of a sheet's cell; numbers with a point."""
    if cell is None or cell != cell:
        return ""
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(" ")
    return str(cell)


def _texts(data: bytes, encoding: str | None) -> Iterator[tuple[str, str]]:
    """Encodings and what the bytes are in them, the likeliest first."""
    marks = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
    marked = next((name for mark, name in marks.items() if data.startswith(mark)), None)
    if marked is None and b"\0" in data[:200]:
        marked = "utf-16-be" if data[:1] == b"\0" else "utf-16-le"
    for name in [encoding] if encoding else [marked] if marked else ["utf-8", *_ranked(data)]:
        try:
            yield name, data.decode(name)
        except LookupError:
            raise ConfigError(
                f"--encoding {name}: unknown; allowed: as in cp1252, gb18030"
            ) from None
        except UnicodeDecodeError:
            if encoding or marked:
                raise ConfigError(
                    f"--encoding {name}: the file is not in it; allowed: another"
                ) from None
            continue
        if name == "utf-8":  # bytes beyond ASCII are hardly ever valid UTF-8 by chance
            return


def _ranked(data: bytes) -> list[str]:
    from charset_normalizer import from_bytes  # files in Unicode need none

    likely = [match.encoding for match in from_bytes(data, cp_isolation=list(ENCODINGS))]
    return [*likely, *(name for name in ENCODINGS if name not in likely)]


def _of_text(text: str, encoding: str, told: Told) -> Cells | None:
    """The table in a text; its separator is the one by which most rows are numbers."""
    lines = [(i + 1, each) for i, each in enumerate(text.splitlines()) if each.strip()]
    if lines and lines[0][1].casefold().startswith("sep="):
        lines = lines[1:]
    best: tuple[int, list[Row], str] | None = None
    for separator in SEPARATORS:
        rows = [(i, _split(each, separator)) for i, each in lines]
        score = len(_data(rows)[1])
        if score and (best is None or score > best[0]):
            best = score, rows, separator
    if best is None:
        return None
    _, rows, separator = best
    cells = [c for _, row in _data(rows)[1] for c in row if _NUMBER.fullmatch(c.strip())]
    decimal = told.decimal or _decimal(cells, separator)
    return _table(rows, decimal, f"{encoding}, {SEPARATORS[separator]}")


def _split(text: str, separator: str) -> list[str]:
    text = COMMENT.sub("#", text, count=1) if COMMENT.match(text) else text
    if separator == " ":
        return re.split(r"\s+", text.strip())
    return [
        cell.strip()
        for cell in next(csv.reader([text], delimiter=separator, skipinitialspace=True))
    ]


def _is_data(cells: list[str]) -> bool:
    """Say if a row has two numbers at least, and no cell is several cells of another separator."""
    filled = [cell for cell in cells if cell.casefold() not in MISSING]
    numbers = sum(bool(_NUMBER.fullmatch(cell)) or is_clock(cell) for cell in filled)
    torn = any(re.search(r"\d[;\t|]|[;\t|]\d|\d,\s*\d+[;\t| ]", cell) for cell in filled)
    return numbers >= 2 and not torn and not cells[0].startswith("#")


def _data(rows: list[Row]) -> tuple[int, list[Row]]:
    """The usual number of cells of data rows, and the data rows of that number."""
    data = [row for row in rows if _is_data(row[1])]
    if not data:
        return 0, []
    width = Counter(len(cells) for _, cells in data).most_common(1)[0][0]
    return width, [row for row in data if len(row[1]) == width]


def _table(rows: list[Row], decimal: str, how: str) -> Cells | None:
    """Header and data of rows; rows of other lengths in between are refused."""
    width, data = _data(rows)
    if len(data) < 2:
        return None
    first, last = data[0][0], data[-1][0]
    above = [(i, _fitted(cells, width)) for i, cells in rows if i < first]
    below = [cells for i, cells in rows if i > last]
    kept: list[Row] = []
    for i, cells in rows:
        if first <= i <= last and any(cells) and not cells[0].startswith("#"):
            if (fitted := _fitted(cells, width)) is None:
                raise ConfigError(
                    f"line {i}: {len(cells)} entries; allowed: as many as above, {width}"
                )
            kept.append((i, fitted))
    names = [
        (i, cells) for i, cells in above if cells is not None and sum(map(bool, cells)) > width // 2
    ]
    header, used = _header([cells for _, cells in names], width)
    last_name = {i for i, _ in names[len(names) - used :]} if used else set()
    over = [" ".join(cells) for i, cells in rows if i < first and i not in last_name]
    over += [" ".join(cells) for cells in below]
    header = [f"{name} #{i + 1}" if header.count(name) > 1 and name else name
              for i, name in enumerate(header)]  # fmt: skip
    empty = [i for i in range(width) if not header[i] and all(not cells[i] for _, cells in kept)]
    stay = [i for i in range(width) if i not in empty]
    return Cells(
        [header[i] or f"column {i + 1}" for i in stay],
        [(number, [cells[i] for i in stay]) for number, cells in kept],
        decimal or ".",
        f"{how}, decimal {'comma' if decimal == ',' else 'point'}",
        [text for text in over if text.strip()],
    )


def _fitted(cells: list[str], width: int) -> list[str] | None:
    """A row cut or filled with empty cells to a width; None where more would be cut."""
    cells = [cell.strip() for cell in cells]
    if cells and cells[0].startswith("#"):
        cells = [cells[0].lstrip("#"), *cells[1:]] if cells[0] != "#" else cells[1:]
    if any(cells[width:]) or len(cells) < max(2, width - 1):
        return None
    return [*cells[:width], *[""] * (width - len(cells))]


def _header(names: list[list[str]], width: int) -> tuple[list[str], int]:
    """Names of columns from the rows above the data, and how many of these rows they are."""
    from dolfingrip.importing.header import is_unit

    if not names:
        return [""] * width, 0
    *others, last = names
    units = [is_unit(cell.strip("()[]（）［］ ")) for cell in last if cell]
    if others and units and sum(units) > len(units) / 2:
        joined = [
            f"{name} [{unit.strip('()[]（）［］ ')}]" if unit else name
            for name, unit in zip(others[-1], last, strict=True)
        ]
        return joined, 2
    return last, 1


def _decimal(cells: list[str], separator: str) -> str:
    """The decimal sign of a table's numbers.

    Raises:
        Question: 1,234 may be a thousand or one, and nothing else in the table tells.
    """
    can_be = dict.fromkeys(".,", True)
    seen = Counter(sign for cell in cells for sign in ".," if sign in cell)
    for cell in cells:
        for sign, other in ((".", ","), (",", ".")):
            thousands = cell.count(sign) > 1 or (
                other in cell and cell.rfind(sign) < cell.find(other)
            )
            if sign in cell and thousands:
                can_be[sign] = False  # it groups
            digits = re.sub(r"[eE].*", "", cell).lstrip("+-−")
            if sign in cell and not re.fullmatch(
                rf"[1-9]\d{{0,2}}(\{sign}\d{{3}})+", digits.split(other)[0]
            ):
                can_be[other] = False  # it does not group
    if separator == "," and not seen[","]:
        return "."
    signs = [sign for sign in ".," if can_be[sign]]
    if len(signs) == 1 or not seen:
        return signs[0] if signs else "."
    if not signs:
        raise ConfigError(
            "its numbers have points and commas without a rule; allowed: one decimal sign"
        )
    if any(re.fullmatch(r"[+\-−]?\d{4,}([.,]\d+)?", cell) for cell in cells):
        return next(sign for sign in ".," if seen[sign])  # thousands are not grouped
    example = next(cell for cell in cells if "." in cell or "," in cell)
    raise Question(
        f"{example}: a decimal sign, or thousands?", [line("decimal", sign) for sign in ".,"]
    )
