"""The page of all keys of the configuration, from its sections themselves."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from docstrings import Docstring, inline, table
from pydantic.fields import FieldInfo

from dolfingrip.config import Config
from dolfingrip.sections import errors
from dolfingrip.sections.units import unit

HEAD = """# All keys of a configuration

Every key of the TOML file, with its unit, default, allowed range and meaning.
`--set finger.wall_mm=1.8` gives a key on the command line.
A key without a default is left out, or follows from others as its meaning says.
[Drawings](../dimensions.md) show the dimensions.
A region such as `[material.film]` takes the keys of `[material]`.
The keys of each effect stand on [its own page](effects/index.md).
"""
COLUMNS = ["key", "type", "unit", "default", "range", "what it does"]
TYPES = {float: "number", int: "whole number", bool: "true or false", str: "text", Path: "file"}
ON_THEIR_PAGES = {"extensions"}
NAMED = {"override": "1", "film": "NAME", "cavity": "NAME"}
"""Name of a table that a user chooses, as the page shows it."""


def page() -> str:
    """The whole page in Markdown."""
    names = [name for name in Config.model_fields if name not in ON_THEIR_PAGES]
    return "\n\n".join([HEAD, *(part for name in names for part in section([name]))]) + "\n"


def section(location: list[str]) -> list[str]:
    """A heading, a sentence and a table of a section, and those of the tables below it."""
    fields = errors.fields(location, Config)
    tables = [key for key in fields if is_table([*location, key])]
    parts = []
    if rows := [row(key, fields[key], location) for key in fields if key not in tables]:
        about = Docstring.of(errors.kinds(location, Config)[0]).paragraphs[:1]
        alone = len(location) == 1 or location[-1] == NAMED.get(location[-2])
        depth = 2 if alone and "override" not in location else 3
        parts = [f"{'#' * depth} `[{'.'.join(location)}]`",
                 *map(inline, about), table(COLUMNS, rows)]  # fmt: skip
    for key in tables:
        parts += section([*location, key])
    if location[-1] in NAMED:
        parts += section([*location, NAMED[location[-1]]])
    return parts


def is_table(location: list[str]) -> bool:
    """Tell whether a key is a table with keys of its own, or with names that a user chooses."""
    return all(hasattr(kind, "model_fields") for kind in errors.kinds(location, Config))


def row(key: str, info: FieldInfo, location: list[str]) -> list[str]:
    """The line of one key."""
    hint = errors.bare(info.annotation)
    chosen = choices(key, location)
    allowed = chosen or errors.reason("", info, key).rpartition("allowed: ")[2]
    allowed = re.sub(r"at least (\S+) and at most (\S+)", r"\1 to \2", allowed)
    if not chosen and not re.search(r"\d", allowed):  # the type says it already
        allowed = ""
    default = info.get_default(call_default_factory=True)
    shown = "" if default is None or default == () or info.is_required() else value(default)
    bounds = inline(allowed.removesuffix(unit(key)).strip())
    about = inline(info.description or "")
    return [f"`{key}`", kind(hint, bool(chosen)), unit(key), shown, bounds, about]


def choices(key: str, location: list[str]) -> str:
    """The texts that a key may have, in all kinds of its section; "" where it is no choice."""
    hints = [
        errors.bare(each.model_fields[key].annotation)
        for each in errors.kinds(location, Config)
        if key in getattr(each, "model_fields", {})
    ]
    texts = [text for hint in hints if get_origin(hint) is Literal for text in get_args(hint)]
    return ", ".join(f"`{text}`" for text in dict.fromkeys(texts))


def kind(hint: Any, chosen: bool) -> str:
    """The type of a key in words."""
    entry, _ = errors.entry_of(hint)
    if chosen:
        return "choice"
    if hint in TYPES:
        return TYPES[hint]
    return f"list of {TYPES.get(entry, 'number')}s" if entry is not Ellipsis else "list"


def value(default: Any) -> str:
    """A default as TOML has it."""
    if isinstance(default, bool):
        return f"`{str(default).lower()}`"
    if isinstance(default, tuple):
        return f"[{', '.join(map(value, default))}]"
    if isinstance(default, float):
        return f"{default:g}"
    return f"`{default}`" if isinstance(default, str) and default else str(default)
