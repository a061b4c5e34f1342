"""Chambers with dimensions of their own: one by one, or by a spline along the finger.

A chamber's dimensions are the shared ones, in their place the spline's, in their place its own. A
finger all of whose chambers were like one of them has that one's cross-section. Between two
chambers the cross-section changes linearly along z, and so it does from the clamp, which has the
shared one, to the first chamber.

>>> from dolfingrip.config import Config, changed
>>> finger = changed(Config(), {"finger.along.depth_mm": [12.0, 19.0],
...                             "finger.override.3.wall_mm": 1.2}).finger
>>> [finger.of(i).depth_mm for i in range(4)]
[12.0, 13.0, 14.0, 15.0]
>>> finger.of(2).wall_mm, finger.of(3).wall_mm
(1.2, 1.6)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import copy
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import ConfigDict, Field, ValidationError, create_model

from dolfingrip.sections.geometry.boxes import THINNEST_MM, TOLERANCE_MM, BoxSolid
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.section import FINGERS, Entry, Refusal, Role, Section

_HALVINGS: Final = 40
"""Of the interval in which a limit of a dimension is sought."""


class _Dimensions(Section):
    """Dimensions of one chamber, or laws of dimensions along the finger."""

    role: ClassVar = Role.BODY
    felt_by: ClassVar = FINGERS
    entry: ClassVar = Entry.SHAPE


class _Overrides(_Dimensions):
    """Dimensions of single chambers; [finger.override.3] is the third from the clamp."""

    model_config = ConfigDict(extra="allow")


class OwnChambers(Geometry):
    """A kind of geometry whose chambers may differ."""

    later: ClassVar = {"override": {}, "along": {}, "tube_mm": 0.0}

    if TYPE_CHECKING:
        override: _Overrides
        along: _Dimensions

    @property
    def inner(self) -> Mapping[str, Section]:
        """The tables of single chambers, and that of laws along the finger."""
        if not self.movable("override"):
            return {}
        overrides = {f"override.{name}": table for name, table in self.override.inner.items()}
        return {"along": self.along, **overrides}

    @property
    def differ(self) -> bool:  # type: ignore[override]
        """True if any dimension of a chamber is given."""
        given = (self.along, *self.override.inner.values())
        return any(value is not None for table in given for _, value in table)

    def number_at(self, key: str) -> float:
        """Return a number by its key; that of a chamber is the shared one where it has none."""
        table, _, inner_key = key.partition(".")
        name, _, dimension = inner_key.partition(".")
        if table == "override":
            return float(getattr(self.of(int(name) - 1), dimension))
        return super().number_at(key)

    def of(self, chamber: int) -> Self:
        """Dimensions of a finger all of whose chambers are like one of this finger's.

        Args:
            chamber: from the clamp, from 0 on.
        """
        values = {key: value for key, _, value in self.given(chamber)}
        return self._alike(values)

    def alike(self) -> Self:
        """Dimensions of a finger all of whose chambers have the shared ones."""
        return self._alike({})

    def _alike(self, values: Mapping[str, float]) -> Self:
        none = {"override": type(self.override)(), "along": type(self.along)()}
        return self.model_copy(update=none | dict(values))

    def given(self, chamber: int) -> list[tuple[str, str, float]]:
        """Return dimension, key and value of what a chamber has by a law or of its own.

        Args:
            chamber: from the clamp, from 0 on.
        """
        single = self.override.inner.get(str(chamber + 1))
        dimensions = []
        for key in self.own:
            law, override = getattr(self.along, key), getattr(single, key, None)
            if override is not None:
                dimensions.append((key, f"override.{chamber + 1}.{key}", override))
            elif law is not None:
                dimensions.append((key, f"along.{key}", _spline(law, chamber, self.count()[1])))
        return dimensions

    def offset(self, key: str, by_mm: float) -> dict[str, Any]:
        """Return the changes of keys that make a dimension of all chambers larger."""
        changes = super().offset(key, by_mm)
        if key in self.own and self.differ:
            tables = self.model_dump(include={"override", "along"}, exclude_none=True)
            for table in (tables["along"], *tables["override"].values()):
                if key in table:
                    table[key] = _plus(table[key], by_mm)
            changes |= tables
        return changes

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another, and chambers that there cannot be."""
        yield from super().refusals()
        key, count = self.number, self.count()[1]
        for name in self.override.inner:
            if not (name.isdecimal() and name == str(int(name)) and 1 <= int(name) <= count):
                yield Refusal(f"override.{name}", f"allowed: 1 to {count}, the {key}", "a table")
        for dimension, law in self.along:
            if law is not None and len(law) > count:
                words = f"allowed: 2 to {count} values, no more than there are {key}"
                yield Refusal(f"along.{dimension}", words, list(law))
        for chamber in range(count) if self.differ else ():
            values: dict[str, float] = {}
            for dimension, name, value in self.given(chamber):
                if not self._possible(values | {dimension: value}):
                    yield self._refusal(chamber, values, dimension, name, value)
                values[dimension] = value

    def _refusal(
        self, chamber: int, others: Mapping[str, float], dimension: str, name: str, value: float
    ) -> Refusal:
        good, bad = float(getattr(self, dimension)), value
        for _ in range(_HALVINGS):
            middle = (good + bad) / 2
            if self._possible({**others, dimension: middle}):
                good = middle
            else:
                bad = middle
        allowed = f"allowed: {'at least' if value < good else 'at most'} {good:.4g} mm"
        why = "beside the other dimensions, with faces in the order of the shared ones"
        if name.startswith("along"):
            allowed = f"{value:.4g} mm in number {chamber + 1} from the clamp; {allowed} there"
        return Refusal(name, f"{allowed}, {why}")

    def _possible(self, values: Mapping[str, float]) -> bool:
        return _possible(self.alike(), tuple(values.items()))


@lru_cache(maxsize=4096)  # a design's steps change one chamber of many
def _possible(alike: OwnChambers, values: tuple[tuple[str, float], ...]) -> bool:
    """Tell whether a finger with such chambers is one, with its faces in the shared order."""
    try:
        finger = type(alike).model_validate({**alike.model_dump(exclude_none=True), **dict(values)})
    except ValidationError:
        return False
    if min(finger.distances_mm().values(), default=THINNEST_MM) < THINNEST_MM:
        return False
    here, there = alike.boxes(), finger.boxes()
    return here is None or there is None or _same_order(here, there)


def _same_order(one: BoxSolid, other: BoxSolid) -> bool:
    """Tell whether planes that are apart in one solid are so in the other, in the same order."""
    for axis in range(3):
        before, after = one.planes(axis), other.planes(axis)
        order = np.argsort(before, kind="stable")
        apart = np.diff(before[order]) > TOLERANCE_MM
        after = np.diff(after[order])
        if (after[apart] < THINNEST_MM).any() or (np.abs(after[~apart]) > TOLERANCE_MM).any():
            return False
    return True


def _spline(values: tuple[float, ...], chamber: int, count: int) -> float:
    """Value at one chamber of a spline through values at equal distances from first to last."""
    if len(values) == 2:  # without the time to load SciPy
        return values[0] + (values[1] - values[0]) * chamber / (count - 1)
    from scipy.interpolate import make_interp_spline

    places = np.linspace(0, count - 1, len(values))
    return float(make_interp_spline(places, values, k=min(3, len(values) - 1))(chamber))


def _plus(value: Any, by: float) -> Any:
    return [number + by for number in value] if isinstance(value, list | tuple) else value + by


def with_own(kind: type[Geometry]) -> type[Geometry]:
    """Return a kind of geometry with tables for the dimensions that its chambers may have.

    Args:
        kind: names these dimensions in ``own``; without any it stays as it is.
    """
    if not kind.own:
        return kind
    numbers: dict[str, Any] = {}
    laws: dict[str, Any] = {}
    for key in kind.own:
        info = kind.model_fields[key]
        number = copy(info)
        number.default, number.annotation = None, float | None
        numbers[key] = (float | None, number)
        about = f"{info.description}: values of a spline at equal distances, first to last chamber"
        entry = Annotated[(float, *info.metadata)]
        law = Field(None, strict=False, min_length=2, max_length=60, description=about)
        laws[key] = (tuple[entry, ...] | None, law)
    one = create_model("Own", __base__=_Dimensions, __doc__="Dimensions of one chamber.", **numbers)
    along = create_model(
        "Along", __base__=_Dimensions, __doc__="Dimensions of all chambers, by splines.", **laws
    )

    class Overrides(_Overrides):
        __doc__ = _Overrides.__doc__
        __pydantic_extra__: dict[str, one]
        entries: ClassVar = one

    return create_model(
        kind.__name__,
        __base__=(OwnChambers, kind),
        __module__=kind.__module__,
        __doc__=kind.__doc__,
        override=(Overrides, Field(Overrides(), description="dimensions of single chambers")),
        along=(along, Field(along(), description="dimensions by splines along the finger")),
    )
