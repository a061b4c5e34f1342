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

from dolfingrip.sections.units import unit

BOUNDS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
LONGEST = 60
"""Largest number of characters of a value that a message shows."""


class ConfigError(ValueError):
    """One line about bad input, with the key, the value and the allowed range."""


class MachineError(RuntimeError):
    """One line about what the machine could not do now, which says nothing about the model."""


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
    # numbers are places in a list; the list is named as a whole
    location = [str(part) for part in first["loc"] if not isinstance(part, int)]
    key = ".".join(location)
    if first["type"] == "extra_forbidden" or _is_no_table(first, location, root):
        return unknown(location, root)
    if first["type"] == "geometry":
        return f"{key}.{first['msg']}" if key else str(first["msg"])
    info = fields(location[:-1], root).get(location[-1])
    if info is None:  # a name that a user chose
        why = f"not a table; allowed: keys {', '.join(fields(location, root))}"
    else:
        why = reason(first["type"], info, location[-1])
    value: Any = data
    last = max(i for i, part in enumerate(first["loc"]) if not isinstance(part, int))
    for place in first["loc"][: last + 1]:
        if first["type"] == "missing" and place not in value:
            return f"{key}: missing; {why}"
        value = value[place]
    return f"{key} = {shown(value)}: {why}"


def _is_no_table(first: Mapping[str, Any], location: Sequence[str], root: type[BaseModel]) -> bool:
    """Whether the name of a table belongs to a value, so that the user meant a key."""
    no_table = first["type"] in ("model_type", "model_attributes_type")
    known = fields(location[:-1], root)
    return no_table and bool(known) and location[-1] not in known


def shown(value: Any) -> str:
    """A value in TOML's notation; a long one is cut."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


def reason(kind: str, info: Any, key: str) -> str:
    """Why a value is refused, and what is allowed.

    Args:
        kind: pydantic's type of the error.
        info: pydantic's description of the key.
        key: name of the key, which ends in its unit.
    """
    hint = bare(info.annotation)
    if isinstance(hint, type) and issubclass(hint, BaseModel):
        return f"not a table; allowed: keys {', '.join(hint.model_fields)}"
    if get_origin(hint) is Literal:
        return f"allowed: {', '.join(str(choice) for choice in get_args(hint))}"
    if hint is bool:
        return "allowed: true, false"
    if hint is Path:
        return "allowed: a file's path in quotes"
    if get_origin(hint) is tuple:
        return f"allowed: {_entries(hint, info)}"
    if hint is str:
        return "allowed: a text in quotes"
    what = "integer" if hint is int else "number"
    limits = _within(info.metadata)
    allowed = f"{limits} {unit(key)}".strip() if limits else f"any finite {what}"
    if kind.startswith(("greater", "less")):
        return f"allowed: {allowed}"
    if kind == "finite_number":
        what = "finite number"
    article = "an" if what == "integer" else "a"
    return f"not {article} {what}; allowed: {allowed}"


def _entries(hint: Any, info: Any) -> str:
    """The values that a list may hold, in words."""
    entry, *more = get_args(hint)
    if more and more[0] is not Ellipsis:
        return "three finite numbers, as in [1, 0, 0]"
    inner, bounded = entry, None
    if get_origin(entry) is Annotated:
        inner, *bounded = get_args(entry)
    if get_origin(inner) is Literal:
        return f"a list of {', '.join(str(choice) for choice in get_args(inner))}"
    limits = {
        name: getattr(item, name)
        for item in info.metadata
        for name in ("min_length", "max_length")
        if getattr(item, name, None) is not None
    }
    count = " to ".join(dict.fromkeys(str(limit) for limit in limits.values()))
    what = "integers" if inner is int else "numbers"
    each = _within([item for field in bounded or () for item in getattr(field, "metadata", [])])
    text = " ".join(part for part in ("a list of", count, what) if part)
    return f"{text}, each {each}" if each else text


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
    """Return a type without ``None``, which makes it optional.

    Args:
        hint: annotation of a key.
    """
    if get_origin(hint) in (Union, types.UnionType):
        return next(part for part in get_args(hint) if part is not type(None))
    return hint


def fields(sections: Sequence[str], root: type[BaseModel]) -> dict[str, Any]:
    """Fields of the section at the end of ``sections``; none if it is a value."""
    return below(sections, root)[0]


def below(
    sections: Sequence[str], root: type[BaseModel]
) -> tuple[dict[str, Any], type[BaseModel] | None]:
    """The contents that the section at the end of ``sections`` may have.

    Returns:
        Its fields, none if it is a value; and the class of tables whose names a user chooses, None
        if there are none.
    """
    model = table(sections, root)
    return dict(getattr(model, "model_fields", {})), getattr(model, "entries", None)


def table(sections: Sequence[str], root: type[BaseModel]) -> Any:
    """Return the class of the section at the end of ``sections``, or the type of a value.

    Args:
        sections: names, from the top.
        root: class of the configuration.
    """
    model: Any = root
    for name in sections:
        if name not in model.model_fields:
            model = model.entries
            continue
        model = bare(model.model_fields[name].annotation)
        if get_origin(model) is tuple:  # a list of tables
            model = get_args(model)[0]
    return model


def unknown(location: Sequence[str], root: type[BaseModel]) -> str:
    """A message about an unknown key, with the most similar key and all allowed keys."""
    *sections, name = location
    here = list(fields(sections, root))
    elsewhere = [
        f"{section}.{name}"
        for section, info in root.model_fields.items()
        if name in getattr(info.annotation, "model_fields", ())
    ]
    if elsewhere:
        meant = " or ".join(elsewhere)
    else:
        near = difflib.get_close_matches(name, here, 1, 0.6)
        meant = ".".join([*sections, *near]) if near else ""
    hint = f"did you mean {meant}? " if meant else ""
    allowed = ", ".join(here) or f"tables [{'.'.join(sections)}.NAME]"
    return f"{'.'.join(location)}: unknown key; {hint}allowed: {allowed}"
