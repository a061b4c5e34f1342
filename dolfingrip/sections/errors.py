"""Errors of the configuration: one line with the key, the value and the allowed range."""

from __future__ import annotations

import difflib
import json
import types
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import BaseMetadata
from pydantic import BaseModel, ValidationError

from dolfingrip import plugins
from dolfingrip.sections.units import NOTHING, unit, words

BOUNDS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
LONGEST = 60
"""Largest number of characters of a value that a message shows."""


class ConfigError(ValueError):
    """One line about bad input, with the key, the value and the allowed range.

    Args:
        message: the line; what it quotes of the input may have line breaks, which are spelled.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(printable(message))


class MachineError(RuntimeError):
    """One line about what the machine could not do now, which says nothing about the model."""


def printable(text: str) -> str:
    """Return a text in one line, without characters that would control a terminal.

    Args:
        text: of a message, which may quote what a user gave.
    """
    return "".join(char if char.isprintable() else ascii(char)[1:-1] for char in text)


def checked[S: BaseModel](root: type[S], data: dict[str, Any]) -> S:
    """Return the checked object of a table.

    Args:
        root: class of the table.
        data: values by key.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    try:
        return root.model_validate(data)
    except ValidationError as error:
        raise ConfigError(one_line(error, root, data)) from None


def one_line(error: ValidationError, root: type[BaseModel], data: Mapping[str, Any]) -> str:
    """The first error that pydantic finds in the data of a ``root``."""
    first = error.errors()[0]
    if first["type"] == "string_unicode":  # of a key, too
        return f"{first['input']!a}: not in UTF-8; allowed: text that is"
    places = _places(first["loc"], root)
    # numbers are places in a list; the list is named as a whole
    location = [str(part) for part in places if not isinstance(part, int)]
    key = ".".join(location)
    if first["type"] == "extra_forbidden" or _is_no_table(first, location, root):
        return unknown(location, root)
    if first["type"] == "geometry":
        return f"{key}.{first['msg']}" if key else str(first["msg"])
    info = fields(location[:-1], root).get(location[-1])
    if info is None:  # a name that a user chose
        why = f"not a table; allowed: keys {', '.join(fields(location, root))}"
    else:
        why = reason(first["type"], info, location[-1], str(first["input"]))
    value: Any = data
    last = max(i for i, part in enumerate(places) if not isinstance(part, int))
    for place in places[: last + 1]:
        if first["type"] == "missing" and place not in value:
            return f"{key}: missing; {why}"
        value = value[place]
    return f"{key} = {shown(value)}: {why}"


def _places(loc: Sequence[str | int], root: type[BaseModel]) -> list[str | int]:
    """An error's keys and entries, without the names of kinds that pydantic puts among them."""
    places: list[str | int] = []
    named = False
    for part in loc:
        if named:
            named = False
            continue
        types = kinds([key for key in places if isinstance(key, str)], root)
        if types and not any(hasattr(kind, "model_fields") for kind in types):
            break  # below a value pydantic puts the types that it may have
        places.append(part)
        types = kinds([key for key in places if isinstance(key, str)], root)
        named = len(types) > 1 and all(hasattr(kind, "model_fields") for kind in types)
    return places


def _is_no_table(first: Mapping[str, Any], location: Sequence[str], root: type[BaseModel]) -> bool:
    """Tell whether the name of a table belongs to a value, so that the user meant a key."""
    no_table = first["type"] in ("model_type", "model_attributes_type")
    section_keys = fields(location[:-1], root)
    return no_table and bool(section_keys) and location[-1] not in section_keys


def shown(value: Any) -> str:
    """Return a value in TOML's notation; a long one is cut.

    Args:
        value: plain data.
    """
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


def reason(kind: str, info: Any, key: str, value: str = "") -> str:
    """Why a value is refused, and what is allowed.

    Args:
        kind: pydantic's type of the error.
        info: pydantic's description of the key.
        key: name of the key, which ends in its unit.
        value: what is refused; a plugin may have it.
    """
    hint = bare(info.annotation)
    if isinstance(hint, type) and issubclass(hint, BaseModel):
        keys = f"keys {', '.join(hint.model_fields)}" if hint.model_fields else "tables by name"
        return f"not a table; allowed: {keys}"
    if get_origin(hint) is Literal:
        choices = ", ".join(str(choice) for choice in get_args(hint))
        return f"allowed: {choices}{'; ' + plugins.hint(value) if info.json_schema_extra else ''}"
    if hint is bool:
        return "allowed: true, false"
    if hint is Path:
        return "allowed: a file's path in quotes"
    if hint is str:
        return "allowed: a text in quotes"
    what = "integer" if hint is int else "number"
    nearly = f"nearer to 0 than {NOTHING:g}; " if kind == "nearly_zero" else ""
    if get_origin(hint) in (tuple, dict):
        return f"{nearly}allowed: {_entries(hint, info, unit(key))}"
    beside = [get_args(part) for part in get_args(info.annotation) if get_origin(part) is Annotated]
    of_number = [note for kind_of, *notes in beside if kind_of is hint for note in notes]
    limits = _within([*info.metadata, *of_number])
    allowed = f"{limits} {unit(key)}".strip() if limits else f"any finite {what}"
    if kind.startswith(("greater", "less", "nearly")):
        return f"{nearly}allowed: {allowed}"
    if kind == "finite_number":
        what = "finite number"
    article = "an" if what == "integer" else "a"
    return f"not {article} {what}; allowed: {allowed}"


def _entries(hint: Any, info: Any, unit: str) -> str:
    """The values that a list or a table of numbers may hold, in words."""
    inner, bounded = entry_of(hint)
    if get_origin(inner) is Literal:
        return f"a list of {', '.join(str(choice) for choice in get_args(inner))}"
    range_text = f", each {_within(bounded)} {unit}".rstrip() if bounded else ""
    if get_origin(hint) is dict:
        return f"a table of numbers{range_text}"
    if get_args(hint)[1:2] not in ((), (Ellipsis,)):
        return f"three finite numbers, as in [1, 0, 0]{range_text}"
    limits = {
        name: getattr(item, name)
        for item in info.metadata
        for name in ("min_length", "max_length")
        if getattr(item, name, None) is not None
    }
    count = " to ".join(dict.fromkeys(str(limit) for limit in limits.values()))
    what = "integers" if inner is int else "numbers"
    return " ".join(part for part in ("a list of", count, what) if part) + range_text


def entry_of(hint: Any) -> tuple[Any, Sequence[Any]]:
    """Return the type of the entries of a list or a table, and their bounds; None of other types.

    Args:
        hint: annotation of a key.
    """
    bare_hint = bare(hint)
    entry = next(iter(get_args(bare_hint)[get_origin(bare_hint) is dict :]), None)
    if get_origin(entry) is not Annotated:
        return entry, []
    kind, *more = get_args(entry)
    return kind, [item for field in more for item in getattr(field, "metadata", [field])]


def _within(metadata: Sequence[Any]) -> str:
    """Pydantic's bounds in words."""
    return " and ".join(
        f"{word} {getattr(item, name):.10g}"
        for item in metadata
        if isinstance(item, BaseMetadata)
        for name, word in BOUNDS.items()
        if getattr(item, name, None) is not None
    )


def bare(hint: Any) -> Any:
    """Return a type without ``None``, which makes it optional, and without what is noted of it.

    Args:
        hint: annotation of a key.
    """
    if get_origin(hint) in (Union, types.UnionType):
        part = next(part for part in get_args(hint) if part is not type(None))
        return get_args(part)[0] if get_origin(part) is Annotated else part
    return hint


def fields(sections: Sequence[str], root: type[BaseModel]) -> dict[str, Any]:
    """Return pydantic's descriptions of the keys of a section; none of a value.

    Args:
        sections: names, from the top.
        root: class of the configuration.
    """
    every = (getattr(kind, "model_fields", {}) for kind in kinds(sections, root))
    by_key: dict[str, Any] = {}
    for key, info in (item for infos in every for item in infos.items()):
        by_key.setdefault(key, info)
    return by_key


def kinds(sections: Sequence[str], root: type[BaseModel]) -> tuple[Any, ...]:
    """Return the classes that a section may have, or the type of a value.

    Args:
        sections: names, from the top.
        root: class of the configuration.

    Returns:
        One class, or several where one of the section's keys chooses; the type of a value; none
        below a value.
    """
    types: tuple[Any, ...] = (root,)
    for name in sections:
        holders = [kind for kind in types if name in getattr(kind, "model_fields", {})]
        hints = [holders[0].model_fields[name].annotation] if holders else []
        hints = hints or [kind.entries for kind in types[:1] if getattr(kind, "entries", None)]
        types = tuple(kind for hint in hints for kind in _alternatives(hint))
    return types


def _alternatives(hint: Any) -> Sequence[Any]:
    """The classes of a union, without ``None``; the class of a list's tables."""
    if get_origin(hint) is Annotated:
        return _alternatives(get_args(hint)[0])
    if get_origin(hint) in (Union, types.UnionType):
        return [part for part in get_args(hint) if part is not type(None)]
    if get_origin(hint) is tuple:
        return get_args(hint)[:1]
    return [hint]


def unknown(location: Sequence[str], root: type[BaseModel]) -> str:
    """Return a message about an unknown key, with the most similar key and all allowed keys.

    Args:
        location: names from the top, that of the key last.
        root: class of the configuration.
    """
    *sections, name = location
    here = list(fields(sections, root))
    elsewhere = [
        f"{section}.{name}"
        for section, info in root.model_fields.items()
        if name in getattr(info.annotation, "model_fields", ())
    ]
    if elsewhere:
        meant = " or ".join(elsewhere)
    elif near := difflib.get_close_matches(name, here, 1, 0.6):
        meant = ".".join([*sections, *near])
    else:
        meant = "" if sections else _without_section(name, root)
    hint = f"did you mean {meant}? " if meant else ""
    allowed = ", ".join(here) or f"tables [{'.'.join(sections)}.NAME]"
    if any(getattr(kind, "extensible", False) for kind in kinds(sections, root)):
        allowed += f"; {plugins.hint(name)}"
    return f"{'.'.join(location)}: unknown key; {hint}allowed: {allowed}"


def _without_section(name: str, root: type[BaseModel]) -> str:
    """The key that is most similar to one without section and unit; "" where none is."""
    keys: dict[str, str] = {}
    for section, info in root.model_fields.items():
        if info.default is not None:  # not of another kind of geometry
            for key in fields([section], root):
                keys.setdefault(words(key).lower(), f"{section}.{key}")
    near = difflib.get_close_matches(name.replace("_", " ").lower(), keys, 1, 0.6)
    return keys[near[0]] if near else ""
