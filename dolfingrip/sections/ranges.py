"""The range of every number of the configuration: its own, within the sizes that its unit has.

A key that says ``gt=0`` is at least its unit's least size; one that has no bound ends at the
largest. A key whose range has a 0 in it takes no number that is nearly 0.

>>> from dolfingrip.sections.specimen import ThicknessMorph
>>> ThicknessMorph.model_fields["d_mm"].metadata
[Ge(ge=0.001), Le(le=10000.0)]
"""

from __future__ import annotations

from collections.abc import Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from dolfingrip.sections import units
from dolfingrip.sections.errors import bare

PURE: Final = "without a unit"
"""Note of a key whose numbers have no unit; the name of every other one ends in its unit."""


def _something(value: float | None) -> float | None:
    if value and abs(value) < units.NOTHING:
        raise PydanticCustomError("nearly_zero", "nearly 0")
    return value


_SOMETHING: Final = AfterValidator(_something)


def narrow(key: str, info: FieldInfo, *, named: bool) -> None:
    """Give the numbers of a key the range of its unit where it tells none of its own.

    Args:
        key: whose name ends in its unit.
        info: pydantic's description of the key, which is changed.
        named: whether the name has to end in the unit of numbers that have one.

    Raises:
        TypeError: its name ends in no unit, and nothing says that it has none.
    """
    unit = units.of(key)
    if named and unit is units.PURE and _numbers(info.annotation) and not pure(info):
        raise TypeError(
            f"{key}: ends in no unit; allowed: one of {', '.join(units.UNITS)}, or the type Ratio"
        )
    others = [part for part in get_args(info.annotation) if part is not NoneType]
    if bare(info.annotation) is float and len(others) < 2:  # a number, or none
        info.metadata = _within(info.metadata, unit)
    else:
        info.annotation = _of_entries(info.annotation, unit)


def _numbers(hint: Any) -> bool:
    """Return whether a type has numbers that are no counts."""
    return hint is float or any(map(_numbers, get_args(hint)))


def pure(noted: Any) -> bool:
    """Return whether it is noted that the numbers of a key have no unit.

    Args:
        noted: pydantic's description of the key, or a type.
    """
    if isinstance(noted, FieldInfo):
        return PURE in noted.metadata or pure(noted.annotation)
    return any(arg is PURE or pure(arg) for arg in get_args(noted))


def _of_entries(hint: Any, unit: units.Unit) -> Any:
    """A type with the range in each of its numbers."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint is float:
        return Annotated[(float, *_within((), unit))]
    if origin is Annotated and inner[0] is float:
        bounds = [bound for item in inner[1:] for bound in getattr(item, "metadata", [item])]
        return Annotated[(float, *_within(bounds, unit))]
    if origin is Annotated:
        return Annotated[(_of_entries(inner[0], unit), *inner[1:])]
    if origin in (Union, UnionType):
        return Union[tuple(_of_entries(part, unit) for part in inner)]  # noqa: UP007  # of a tuple
    if origin in (tuple, dict):
        return origin[tuple(_of_entries(part, unit) for part in inner)]
    return hint


def _within(metadata: Sequence[Any], unit: units.Unit) -> list[Any]:
    """The bounds of a number's metadata, and the missing ones by its unit."""
    kept = [bound for bound in metadata if bound != Gt(0) and bound is not _SOMETHING]
    if not _limits(kept, "lt", "le"):
        kept.append(Le(unit.most))
    if not _limits(kept, "gt", "ge"):
        kept.insert(0, Ge(unit.least if Gt(0) in metadata else -unit.most))
    if _limits(kept, "gt", "ge")[0] <= 0:
        kept.append(_SOMETHING)
    return kept


def _limits(metadata: Sequence[Any], *names: str) -> list[float]:
    limits = [getattr(bound, name, None) for bound in metadata for name in names]
    return [limit for limit in limits if limit is not None]
