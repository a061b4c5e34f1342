"""Bounds of numbers in a table, and of the entries of lists, as pydantic declares them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel

from dolfingrip.sections.errors import bare


def bounds_of(table: type[BaseModel], key: str) -> tuple[float, float]:
    """Lower and upper bound of a number, or of a list's entries; infinite if there is none."""
    info = table.model_fields[key]
    entries = of_floats(info.annotation)
    return bounds(of_entries(info.annotation) if entries else info.metadata)


def of_floats(hint: Any) -> bool:
    arguments = get_args(bare(hint))
    first = arguments[0] if arguments else None
    return first is float or (get_origin(first) is Annotated and get_args(first)[0] is float)


def _entry_metadata(hint: Any) -> Sequence[Any]:
    first = get_args(bare(hint))[0]
    return get_args(first)[1:] if get_origin(first) is Annotated else ()


def of_entries(hint: Any) -> Sequence[Any]:
    return [item for field in _entry_metadata(hint) for item in getattr(field, "metadata", [field])]


def bounds(metadata: Sequence[Any]) -> tuple[float, float]:
    """Pydantic's bounds; open bounds are taken for closed ones."""

    def limits(*names: str) -> list[float]:
        found = (getattr(item, name, None) for item in metadata for name in names)
        return [float(limit) for limit in found if limit is not None]

    return max(limits("gt", "ge"), default=-math.inf), min(limits("lt", "le"), default=math.inf)
