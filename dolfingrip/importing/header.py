"""Quantity and unit of a column, from its name in thirteen languages."""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Final

from dolfingrip.channels import AMBIENT_KPA, CHANNELS
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.data.table import IGNORED, MEASURED, near, of_any_number
from dolfingrip.experiments.material_fit.coupons import STRAIN, STRESS
from dolfingrip.importing.told import ORDERS, NamedColumn
from dolfingrip.sections.units import unit as unit_at_end

NO_UNIT: Final = "dimensionless"

WITHOUT_UNIT: Final = ("frame", "setpoint", "stretch", "specimen", "cycle")
"""Quantities that are certain without a unit."""

UNNAMED: Final = "its name is not known"
"""Why a column is not certain of which the unit alone is known."""

DOUBTFUL: Final = "its name may be that of another number"
"""Why a column is not certain that may be a scatter, a multiple or a prediction of a quantity."""

DATED: Final = {f"time_{order}": order for order in ORDERS}
"""Columns of dates by their order of day, month and year."""

IGNORE: Final = "ignore"
"""Name of no quantity: the column is passed over."""


@dataclass(frozen=True, slots=True)
class ColumnReading:
    """Quantity and conversion that one column may have.

    Attributes:
        target: column of the format, or one of :data:`TARGETS`.
        unit: unit in which the file has it, for people; "" for none.
        factor: by which its numbers are multiplied.
        offset: that is added afterwards.
    """

    target: str
    unit: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Recognised:
    """Readings that the name of a column allows.

    Attributes:
        header: the name.
        readings: what it may be; one: it is certain.
        why: what is not known, where it is not certain.
        offered: columns that it may be, each after what is done to its numbers, as the left side
            of ``--column`` has it.
    """

    header: str
    readings: tuple[ColumnReading, ...] = ()
    why: str = ""
    offered: tuple[tuple[str, str], ...] = ()


@cache
def _known() -> dict[str, Any]:
    text = files("dolfingrip.importing").joinpath("words.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


TARGETS: Final[Mapping[str, str]] = {
    quantity: columns[0] for quantity, columns in _known()["columns"].items()
}
"""Column of the format by quantity; some the import turns into others, or drops."""


@cache
def _registry() -> Any:
    import pint  # loads for 0.3 s, and only tables with units of their own need it

    return pint.UnitRegistry()


@cache
def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(","))


def plain(text: str) -> str:
    """A name in small letters without accents, underscores and full-width characters.

    Args:
        text: as a table has it.

    >>> plain("ActuatorAngle_deg"), plain("Présión （bar）")
    ('actuator angle deg', 'presion (bar)')
    """
    text = re.sub(r"(?<=[a-zß-ÿ])(?=[A-Z])", " ", unicodedata.normalize("NFKC", text))
    marked = unicodedata.normalize("NFD", text.casefold())
    bare = "".join(c for c, before in zip(marked, " " + marked, strict=False)
                   if not (unicodedata.combining(c) and before.isascii()))  # fmt: skip
    return " ".join(unicodedata.normalize("NFC", bare).replace("_", " ").split())


def _normal(text: str) -> str:
    """A text with usual characters; 10³ is 10^3."""
    raised = re.sub(r"(?<=\d)([⁻⁰¹²³⁴-⁹]+)", r"^\1", text)
    return unicodedata.normalize("NFKC", raised).replace("−", "-").strip()


@cache
def _pattern(word: str) -> re.Pattern[str]:
    """Finds a word in a plain name: alone, or as a part of another where the language does so."""
    text = re.escape(plain(word))
    if word[0] >= "\u0370" and len(word) == 1 and word < "\u0400":  # a Greek letter
        text = rf"(?<![^\W\d_]){text}(?![^\W\d_])"
    elif word[0] < "\u0370":
        alone = rf"(?<![a-z]){text}(?![a-z])"
        compound = len(word) >= 5 and " " not in word  # Biegewinkel, Druckluft
        text = rf"{alone}|(?<![a-z]){text}|{text}(?![a-z])" if compound else alone
    return re.compile(text)


@cache
def _patterns() -> list[tuple[str, re.Pattern[str]]]:
    vocabulary = _known()["quantities"].items()
    return [(quantity, _pattern(word)) for quantity, words in vocabulary for word in _words(words)]


def quantities(name: str) -> list[str]:
    """Quantities that a name may mean; a longer word hides the words within it.

    Args:
        name: of a column, without its unit.

    >>> quantities("Luftdruck"), quantities("true stress"), quantities("压力")
    (['pressure'], ['true_stress'], ['pressure'])
    """
    hits = [(q, m.span()) for q, pattern in _patterns() for m in pattern.finditer(plain(name))]
    longest = [
        (q, (a, b))
        for q, (a, b) in hits
        if not any(c <= a and b <= d and d - c > b - a for _, (c, d) in hits)
    ]
    return list(dict.fromkeys(q for q, _ in longest))


_DIMENSIONS: Final = ("kPa", "ml", "N", "mm", "s", "1/m", NO_UNIT)
"""Units of the dimensions that columns have."""


def _units(text: str) -> tuple[Any, ...]:
    """Quantities of one unit that a text may mean; several where letters' case decides."""
    return _bare_units(text) or _bare_units(level(text)[0])


@cache
def level(text: str) -> tuple[str, str]:
    """A pressure's unit without the word for what it counts from, and ``gauge`` or ``absolute``.

    Args:
        text: as a table has it; what has no such word stays as it is.

    >>> level("bar relatif"), level("kPa(a)"), level("psig"), level("mmHg")
    (('bar', 'gauge'), ('kPa', 'absolute'), ('psi', 'gauge'), ('mmHg', ''))
    """
    text = _normal(text)
    glued = {*_known()["cases"]["units"].casefold().split(), *_known()["units"]}  # barg, not data
    for i in range(1, 0 if _bare_units(text) else len(text)):
        unit, word = text[:i].rstrip(" _-.,(["), plain(text[i:].strip(" _-.:)]("))
        if len(unit) == i and text[i].isalpha() and unit.casefold() not in glued:
            continue
        for zero in ("gauge", "absolute"):
            if word in map(plain, _words(_known()[zero]["words"])) and any(
                q is not None and q.is_compatible_with("kPa") for q in _bare_units(unit)
            ):
                return unit, zero
    return text, ""


@cache
def _bare_units(text: str) -> tuple[Any, ...]:
    text = _normal(text).strip(".")
    if not text or len(text) > 12:
        return ()
    aliases, small = _known()["units"], text.casefold()
    key = next((k for k in (text, small, plain(text)) if k in aliases), None)
    if not key and len(text) == 1 and text not in "NmsS%°":  # years, days and tonnes
        return ()
    if not key and not re.match(r"[^\W\d_]|[%°‰]|10\^-?\d|1e-?\d|1/", text):  # 10 kPa is a range
        return ()
    if key and "|" in aliases[key]:
        return tuple(_parsed(part) for part in aliases[key].split("|"))
    exact = _parsed(aliases[key] if key else re.sub(r"(?<=[a-z])([23])$", r"**\1", text))
    if exact is not None and any(exact.is_compatible_with(dimension) for dimension in _DIMENSIONS):
        return (exact,)
    likely = [name for name in _known()["cases"]["units"].split() if name.casefold() == small]
    return tuple(_parsed(name) for name in likely)  # PSI, Mpa: the letters' case is wrong


def _parsed(text: str) -> Any:
    try:
        q = (
            _registry().Quantity(1, text)
            if text[:1].isalpha() or text in "%°‰"
            else _registry()(text)
        )
        return q if hasattr(q, "units") else _registry().Quantity(q)
    except Exception:  # pint raises its own errors, and those of Python's tokenizer
        return None


def is_unit(text: str) -> bool:
    """Say if a text is a unit, or that of an instrument's raw numbers.

    Args:
        text: without brackets.

    >>> is_unit("kPa"), is_unit("counts"), is_unit("Druck")
    (True, True, False)
    """
    return bool(_units(text)) or text.casefold() in _words(_known()["raw"]["units"])


def is_called(text: str, what: str) -> bool:
    """Say if a text is what the mean of the rows above, or a column of units, is called.

    Args:
        text: of a cell.
        what: ``summary`` or ``unit``.

    >>> is_called("Mittelwert", "summary"), is_called("Mean:", "summary")
    (True, True)
    >>> is_called("Einheit", "unit"), is_called("Druck", "unit")
    (True, False)
    """
    return text[:1].isalpha() and plain(text).strip(" :.") in _words(_known()[what]["words"])


def named_by_beginning(data: bytes) -> str | None:
    """Say what a file is that is not read, and what to do with it; None of another.

    Args:
        data: its bytes.
    """
    start, kinds = data[:8].decode("latin-1"), _known()["beginnings"]
    return next((said for beginning, said in kinds.items() if start.startswith(beginning)), None)


def encodings() -> list[str]:
    """Encodings that files may have which are not in Unicode."""
    return _known()["encodings"]["names"].split()


def _per(unit: Any, other: Any) -> float | None:
    """How many of another unit one is; None where they are not of one kind, as angles are."""
    turned = ["radian" in str(q.to_root_units().units) for q in (unit, other)]
    if turned[0] != turned[1] or not unit.is_compatible_with(other):
        return None
    return float(f"{(unit / other).to('').magnitude:.15g}")


def ratio(unit: str, other: str) -> float | None:
    """Return how many of another unit one is; None where that is not certain.

    Args:
        unit: as a table has it.
        other: the other.

    >>> ratio("mbar", "bar"), ratio("mbar", "bar abs"), ratio("V", "V"), ratio("N", "bar")
    (0.001, None, 1.0, None)
    """
    one, two = _units(unit), _units(other)
    if unit == other:
        return 1.0
    certain = len(one) == len(two) == 1 and level(unit)[1] == level(other)[1]
    return _per(one[0], two[0]) if certain else None


def factor(unit: str, target: str) -> list[float]:
    """Factors by which numbers in a unit become those of a column; several where case decides.

    Args:
        unit: as a table tells it.
        target: column of the format.

    >>> factor("bar", "pressure_kPa"), factor("V", "pressure_kPa")
    ([100.0], [])
    """
    of_target = _registry().Quantity(1, _unit_of(target))
    factors = dict.fromkeys(_per(q, of_target) for q in _units(unit))
    return [number for number in factors if number is not None]


def _unit_of(target: str) -> str:
    if target == "angle_deg" or target.endswith("_deg"):
        return "degree"
    return unit_at_end(target) or NO_UNIT


def split(header: str) -> tuple[str, str]:
    """Name and unit of a header; "" for a unit that it does not tell.

    Args:
        header: as a table has it.

    >>> split("Druck [bar]"), split("p / kPa"), split("ActuatorAngle_deg"), split("圧力（ｋPa）")
    (('Druck', 'bar'), ('p', 'kPa'), ('ActuatorAngle', 'deg'), ('圧力', 'kPa'))
    """
    text = re.sub(r" #\d+$", "", _normal(header)).strip(" _")
    two = _after(text, r"(\S+[\s_(]+\S+)")
    if two and level(two[1])[1]:  # bar (g)
        return two
    for match in re.finditer(r"[(\[<{]\s*([^()\[\]<>{}]*(?:\([^()]*\))?)\s*[)\]>}]", text):
        if is_unit(unit := re.sub(r"^(in|unit:?)\s+", "", match[1].strip(), flags=re.IGNORECASE)):
            name = f"{text[: match.start()]}{text[match.end() :]}"
            return name.rstrip(" _-").lstrip(" _"), unit
    return _after(text, r"(\S+)") or (text, "")


def _after(text: str, unit: str) -> tuple[str, str] | None:
    """Name and unit of a header that ends with it, behind a slash, ``in`` or a separator."""
    for between in (r"(.+?)\s*/\s*", r"(.+?)\s+in\s+", r"(.+?)[\s_,;:.|]+", r"(.+)[\s_,;:.|]+"):
        match = re.fullmatch(between + unit, text)
        if match and is_unit(match[2]) and match[2] not in "-–—1":
            return match[1].rstrip(" _-,").lstrip(" _"), match[2]
    return None


def recognise(header: str) -> Recognised:
    """Say what a column may be by its name.

    Args:
        header: name of the column in the file.

    >>> recognise("Biegewinkel [rad]").readings
    (ColumnReading(target='angle_deg', unit='rad', factor=57.2957795130823, offset=0.0),)
    """
    if header in (*MEASURED, *of_any_number([header]), STRAIN, STRESS, "stretch", "mode"):
        return Recognised(header, (ColumnReading(header, _shown(header)),))
    if header in IGNORED:
        return Recognised(header)
    name, unit = split(header)
    kinds = quantities(name)
    if "suction" in kinds and "pressure" in kinds:
        kinds.remove("pressure")
    if "setpoint" in kinds:
        kinds = ["setpoint"]
    if unit and _doubtful(name):
        may_be = tuple(("", TARGETS[kind]) for kind in kinds)
        return Recognised(header, (), DOUBTFUL if may_be else "", may_be)
    targets = [TARGETS[kind] for kind in kinds]
    columns = [column for kind in kinds for column in _known()["columns"][kind]]
    if kinds and unit.casefold() in _words(_known()["raw"]["units"]):
        why = f"{unit} need a calibration, value = FACTOR * {unit} + OFFSET"
        return Recognised(header, (), why, tuple(("*FACTOR+OFFSET", kind) for kind in targets))
    bare, zero = level(unit or "kPa")
    called = set(re.findall(r"\w{2,}", plain(name))) & set(_words(_known()["absolute"]["words"]))
    if (called or zero == "absolute") and kinds in (["pressure"], ["suction"], []):
        air = float(_registry().Quantity(AMBIENT_KPA, "kPa").to(_units(bare)[0].units).magnitude)
        why = "a pressure above vacuum; subtract that of the air"
        return Recognised(header, (), why, ((f"-{air:.5g}", f"pressure_{bare}"),))
    if len(kinds) == 1 and kinds[0] in WITHOUT_UNIT:
        return Recognised(header, (ColumnReading(targets[0], unit),))
    if kinds and not unit:
        said = re.search(r"[(\[<]\s*([^()\[\]<>]+?)\s*[)\]>]", header)
        why = f"{said[1]} is no unit that is known" if said else "its unit is not told"
        scale = "*FACTOR" if said else ""  # nobody shall take its numbers for others
        return Recognised(header, (), why, tuple((scale, column) for column in columns))
    readings = tuple(ColumnReading(t, unit, value) for t in targets for value in factor(unit, t))
    if len(readings) == 1:
        return Recognised(header, readings)
    if readings:
        one = len({r.target for r in readings}) == 1  # of one quantity, in two units
        offers = tuple((f"*{r.factor:g}" if one else "", r.target) for r in readings)
        return Recognised(header, readings, f"{unit} has two readings", offers)
    fitting = [t for t in TARGETS.values() if t in MEASURED and _unit_of(t) != NO_UNIT]
    fits = tuple(("", t) for t in fitting if unit and factor(unit, t))
    why = UNNAMED if fits else ""
    if kinds:
        why = f"{unit} is no unit of {' or '.join(kinds)}"
    return Recognised(header, (), why, fits or tuple(("*FACTOR", column) for column in columns))


def _doubtful(name: str) -> bool:
    """Say if a name may be that of a scatter, a multiple or a prediction of its quantity."""
    plain_name = plain(name)
    return bool(
        re.search(r"[*×^²³√]|\b1 ?/|(?<!\w)(-|\d+ ?-|x ?\d)", plain_name)
        or any(_pattern(word).search(plain_name) for word in _words(_known()["doubt"]["words"]))
    )


def _shown(target: str) -> str:
    channel = CHANNELS.get(target)
    return channel.symbol if channel else unit_at_end(target)


_LEFT: Final = re.compile(
    r"(.*?)(?:\*(-?[\d.]+(?:e-?\d+)?))?([+-][\d.]+(?:e-?\d+)?)?", re.IGNORECASE
)


def told_columns(
    columns: Iterable[NamedColumn], headers: Sequence[str]
) -> dict[str, ColumnReading]:
    """Find the columns of ``--column``: ``HEADER[*FACTOR][+OFFSET]=COLUMN``.

    Args:
        columns: their headers, and columns of the format, the same in another unit
            (``pressure_psi``, ``pressure [psi]``), or ``ignore``. A unit in the header counts where
            the other side is a column of the format.
        headers: names of the file's columns; ``column 3`` names one by its place.

    Raises:
        ConfigError: one line.
    """
    readings = {}
    for named in columns:
        header, scale, shift = _left(named, headers)
        readings[header] = _right(named, header, scale, shift)
    return readings


def _left(named: NamedColumn, headers: Sequence[str]) -> tuple[str, float | None, float]:
    left = named.header.strip()
    if left in headers:
        return left, None, 0.0
    place = re.fullmatch(r"column (\d+)", left)
    if place and 1 <= int(place[1]) <= len(headers):
        return headers[int(place[1]) - 1], None, 0.0
    parts = _LEFT.fullmatch(left)
    if parts is not None and (header := parts[1].strip()) in headers:
        return header, float(parts[2]) if parts[2] else None, float(parts[3] or 0)
    raise ConfigError(
        f"--column {named}: {near(left, headers)}allowed: {', '.join(headers)}, as in "
        f"{headers[0]}=pressure_kPa"
    )


def _right(named: NamedColumn, header: str, scale: float | None, shift: float) -> ColumnReading:
    right = named.column.strip()
    if right == IGNORE:
        return ColumnReading(IGNORE, "")
    if right in DATED:
        return ColumnReading("time_s", DATED[right])
    allowed = [
        t for t in TARGETS.values() if t not in ("setpoint", "true_stress_MPa", "true_strain")
    ]
    name, unit = split(right)
    # columns of which there are any number, as those of markers and single cavities' supplies
    ends = ("kPa", "mm", "per_m")
    allowed += of_any_number(dict.fromkeys([right, *(f"{name}_{end}" for end in ends)]))
    stem = name.replace(" ", "_")
    targets = [right] if right in allowed else [
        t for t in allowed if stem in (t, t.rpartition("_")[0])
    ]  # fmt: skip
    if right in allowed:
        unit = split(header)[1]
    values = factor(unit, targets[0]) if len(targets) == 1 else []
    if right in allowed and len(values) != 1:
        if values and scale is None:
            raise ConfigError(
                f"--column {named}: {unit} has two readings; allowed: a factor, as in "
                f"{header}*1={right}"
            )
        unit, values = unit if values else "", [1.0]
    if len(values) != 1:
        raise ConfigError(
            f"--column {named}: {right}: {near(right, allowed)}allowed: {', '.join(allowed)}, "
            "cavity_2_supply_kPa, marker_1_x_mm, curvature_2_per_m and the like, "
            f"with another unit, as in pressure_psi, or {IGNORE}"
        )
    per_unit, factor_told = values[0], 1.0 if scale is None else scale
    return ColumnReading(
        targets[0], unit or _shown(targets[0]), factor_told * per_unit, shift * per_unit
    )
