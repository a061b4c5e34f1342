"""Reading and writing the tables of a configuration: TOML, ``run.json``, ``--set``."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import tomlkit
from pydantic import BaseModel

from dolfingrip.sections.errors import ConfigError, shown

POSTERIOR = "posterior"
"""Table, next to the sections, with the uncertainty that a fit to measurements left."""

SHORT_NUMBER = re.compile(r"[+-]?(\.\d+|\d+\.)([eE][+-]?\d+)?")
"""Numbers such as .5 and 5., which TOML does not allow."""

TOO_DEEP = "tables or lists too deep in one another; allowed: those of the configuration"
"""What is said of a text that the parsers cannot follow."""


def toml(text: str) -> dict[str, Any]:
    """Parse TOML.

    Args:
        text: of a file, or of an assignment.

    Returns:
        Its tables.

    Raises:
        ValueError: the text is not TOML, or too deep for a configuration.
    """
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(TOO_DEEP) from None


def assigned(assignment: str, option: str = "--set") -> tuple[str, Any]:
    """Return key and value of one ``section.key=value``; the value is read as TOML.

    Args:
        assignment: text of a command line or file.
        option: that messages name.

    Raises:
        ConfigError: one line naming the option, if it is not an assignment.
    """
    key, separator, text = assignment.partition("=")
    key, text = key.strip(), text.strip()
    if not separator or not all(part.strip() for part in key.split(".")):
        shown = " ".join(assignment.split())
        raise ConfigError(f"{option} {shown}: allowed: section.key=value")
    try:
        value = toml(f"v = {text}")["v"]
    except ValueError:
        return key, float(text) if SHORT_NUMBER.fullmatch(text) else text
    check_values(value, f"{option} {key}")
    return key, value


def assignment(key: str, value: float, *, listed: bool = False) -> str:
    """Write a number as a ``section.key=value`` text of the command line, to three digits.

    Args:
        key: of the configuration.
        value: of it.
        listed: whether the key's value is a list of one number.
    """
    return f"{key}=[{value:.3g}]" if listed else f"{key}={value:.3g}"


def check_values(value: Any, name: str) -> None:
    """Raise if a whole number is too large for a floating-point one, or a text has a NUL in it.

    Args:
        value: a number or a text, or tables and lists of them.
        name: that the message calls it.

    Raises:
        ConfigError: one line.
    """
    if isinstance(value, dict):
        for key, entry in value.items():
            check_values(entry, f"{name}.{key}")
    elif isinstance(value, list):
        for entry in value:
            check_values(entry, name)
    elif isinstance(value, int) and abs(value) > sys.float_info.max:
        digits = len(str(abs(value)))
        raise ConfigError(f"{name}: a number of {digits} digits; allowed: below 1.8e308")
    elif "\0" in str(value):
        raise ConfigError(f"{name} = {shown(value)}: allowed: a text without the character NUL")


def assignments(texts: Iterable[str], option: str = "--set") -> dict[str, Any]:
    """Read ``section.key=value`` texts of the command line, or of a TOML file.

    Args:
        texts: in the order in which they apply; of one key the last one counts.
        option: that messages name.

    Returns:
        Values by key.

    Raises:
        ConfigError: one line naming the option, if one is not an assignment.
    """
    by_key: dict[str, Any] = {}
    for text in texts:
        key, value = assigned(text, option)
        by_key.pop(key, None)
        by_key[key] = value
    return by_key


def parts(key: str) -> list[str | int]:
    """Return the names in a key, and the numbers of entries.

    Args:
        key: names with points between them; an entry of a list is numbered from 0 in brackets.

    >>> parts("extensions.prony.g[0]")
    ['extensions', 'prony', 'g', 0]
    """
    names = re.findall(r"[^.\[\]]+|\[\d+\]", key)
    return [int(part[1:-1]) if part.startswith("[") else part for part in names]


def put(data: dict[str, Any], change: Mapping[str, Any], *, replace: bool = True) -> None:
    """Set values of nested tables.

    Args:
        data: tables; those that are absent are added.
        change: values by key (``section.name``); entries of a list are numbered from 0 in brackets.
        replace: whether values that are there already are replaced.

    Raises:
        ConfigError: one line, if a key goes on beyond a value, or a list has no such entry.
    """
    if not isinstance(change, Mapping):
        raise ConfigError(f"{change}: allowed: values by key, such as {{'finger.wall_mm': 1.8}}")
    for key, value in change.items():
        *sections, name = parts(key)
        place: Any = data
        for section in sections:
            if isinstance(place, dict) and place.get(section) is None:
                place[section] = {}
            if isinstance(place[section], tuple):
                place[section] = list(place[section])
            place = place[section]
            if not isinstance(place, dict | list):
                raise ConfigError(f"{key}: {section} is a value, not a section")
        if isinstance(place, list) and name not in range(len(place)):
            raise ConfigError(f"{key}: no such entry; allowed: 0 to {len(place) - 1}")
        if replace or name not in place:
            place[name] = value


def read(file: Path) -> dict[str, Any]:
    """Read the sections of a TOML file or of a ``run.json``.

    The table ``posterior`` is no section; :mod:`dolfingrip.sections.posterior` reads it.

    Args:
        file: TOML, or a ``run.json``.
    """
    data = whole(file, "--config")
    return {name: section for name, section in data.items() if name != POSTERIOR}


def whole(file: Path, option: str) -> dict[str, Any]:
    """Read all tables of a TOML file or of a ``run.json``.

    Args:
        file: TOML, or a ``run.json``.
        option: option that names the file; empty where none does.
    """
    text, named = text_of(file, option), f"{option} {file}".strip()
    try:
        data = json.loads(text)["config"] if file.suffix == ".json" else toml(text)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        kind = "a run.json" if file.suffix == ".json" else "TOML"
        why = TOO_DEEP if isinstance(error, RecursionError) else error
        raise ConfigError(f"{named}: not {kind}: {why}") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{named}: not a run.json: its config is no table")
    for name, table in data.items():
        check_values(table, f"{named}: {name}")
    return data


def text_of(file: Path, option: str) -> str:
    """Return the text of a file.

    Args:
        file: that a user names.
        option: option that names it; empty where none does.

    Raises:
        ConfigError: one line, where it cannot be read or is no text.
    """
    named = f"{option} {file}".strip()
    try:
        return file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ConfigError(f"{named}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise ConfigError(f"{named}: not text: {error}") from None
    except ValueError as error:  # a name that no file can have
        raise ConfigError(f"{named}: no file: {error}") from None


SEPARATORS: Final = {";": "semicolons", "\t": "tabs"}
"""Separators of CSV files that spreadsheets of some languages write, and their names."""


def check_separator(prefix: str, header: str) -> None:
    """Refuse a CSV table whose entries are not separated by commas.

    Args:
        prefix: option and file that the message begins with.
        header: first line of the table.

    Raises:
        ConfigError: one line.
    """
    for character, name in SEPARATORS.items():
        if header.count(character) > header.count(","):
            raise ConfigError(
                f"{prefix}: its entries are separated by {name}; allowed: commas, with a point "
                "before decimals"
            )


def anchor(data: dict[str, Any], folder: Path) -> None:
    """Make paths of the files of mesh, food and obstacle absolute, so that they are found later.

    Args:
        data: tables of a configuration; they are changed.
        folder: that paths are relative to.
    """
    for name in ("mesh", "food", "obstacle"):
        section = data.get(name)
        if isinstance(section, dict) and isinstance(section.get("file"), str | Path):
            check_values(section["file"], f"{name}.file")
            section["file"] = str((folder / section["file"]).resolve())


def dumps(config: BaseModel) -> str:
    """Return the resolved configuration as TOML, each key with its meaning as a comment.

    Args:
        config: that is written.
    """
    document = tomlkit.document()
    document.add(tomlkit.comment("dolfingrip configuration: every key, as resolved"))
    for name in type(config).model_fields:
        section = getattr(config, name)
        if section is not None:  # the tables of other kinds of geometry
            document.add(name, table(section))
    return tomlkit.dumps(document)


def table(section: BaseModel) -> tomlkit.items.Table:
    """Return a section as TOML, each key with its meaning; sections in it come last.

    Args:
        section: any table of the configuration.
    """
    made = tomlkit.table()
    inner: dict[str, Any] = {}
    made.comment((type(section).__doc__ or "").splitlines()[0])
    for key, info in type(section).model_fields.items():
        value = getattr(section, key)
        if value is None:  # TOML has no null: an unset key is shown commented out
            made.add(tomlkit.comment(f"{key} =    # {info.description}"))
        elif isinstance(value, BaseModel):
            inner[key] = table(value)
        elif isinstance(value, tuple) and value and isinstance(value[0], BaseModel):
            inner[key] = tomlkit.aot()
            inner[key].extend(table(entry) for entry in value)
        else:
            item = tomlkit.item(plain(value))
            item.comment(info.description or "")
            made.add(key, item)
    inner |= {key: table(below) for key, below in (section.model_extra or {}).items()}
    for key, below in inner.items():
        made.add(key, below)
    return made


def plain(value: Any) -> Any:
    """Return a value as TOML and JSON have it.

    Args:
        value: of a key.
    """
    if isinstance(value, Path):
        return str(value)
    return list(value) if isinstance(value, tuple) else value
