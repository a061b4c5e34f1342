"""The design space: which numbers of the configuration vary, between what, and at which points."""

from __future__ import annotations

import math
import types
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import numpy as np
from pydantic import TypeAdapter, ValidationError
from scipy.stats import qmc

from dolfingrip.config import Config, ConfigError
from dolfingrip.sections import complaint

Points = Literal["grid", "sobol", "lhs"]
Inputs = dict[str, float | int]
"""One point: value by key of the configuration."""

PAPER = ("morph.xi1=-0.2:1:16", "morph.xi2=-0.5:1:13")
"""The 208 evenly spaced points of the paper."""

_DIGITS = 12
"""Significant digits of an input: more would make two ways to the same point two designs."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number of the configuration that varies.

    Attributes:
        key: ``section.name``.
        low, high: bounds, in the unit that the key's name ends in; both are included.
        count: of evenly spaced values on a grid; None where the parameter is for samples only.
        integer: whether only whole numbers are meant.
    """

    key: str
    low: float
    high: float
    count: int | None
    integer: bool

    def value(self, share: float) -> float | int:
        """The value at a share in [0, 1] of the way from ``low`` to ``high``."""
        raw = self.low + share * (self.high - self.low)
        if self.integer:
            return round(raw)
        return float(f"{raw:.{_DIGITS}g}") + 0.0  # no minus zero


def parse(text: str) -> Parameter:
    """A parameter from ``section.name=low:high`` or ``section.name=low:high:count``.

    Raises:
        ConfigError: one line, where the key is no number of the configuration or a bound lies
            outside its range.
    """
    key, separator, rest = text.partition("=")
    key, parts = key.strip(), rest.split(":")
    form = f"--parameter {text}: allowed: section.name=low:high or section.name=low:high:count"
    if not separator or len(parts) not in (2, 3):
        raise ConfigError(form)
    try:
        low, high = (float(part) for part in parts[:2])
        count = int(parts[2]) if len(parts) == 3 else None
    except ValueError:
        raise ConfigError(form) from None
    info, integer = _field(key)
    for bound in (low, high):
        _within(key, info, int(bound) if integer and bound.is_integer() else bound)
    if not low < high:
        raise ConfigError(f"--parameter {text}: allowed: low below high")
    if count is not None and count < 2:
        raise ConfigError(f"--parameter {text}: count = {count}: allowed: at least 2")
    return Parameter(key, low, high, count, integer)


def _field(key: str) -> tuple[Any, bool]:
    """Pydantic's field of a key, and whether it is an integer."""
    section, _, name = key.partition(".")
    info = Config.model_fields.get(section)
    fields = getattr(info.annotation, "model_fields", {}) if info is not None else {}
    if name not in fields:
        raise ConfigError(f"--parameter {key}: unknown key; allowed: a number of the configuration")
    kinds = _kinds(fields[name].annotation)
    if kinds not in ({int}, {float}):
        raise ConfigError(f"--parameter {key}: no number; allowed: a number of the configuration")
    return fields[name], kinds == {int}


def _kinds(hint: Any) -> set[Any]:
    parts = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    return set(parts) - {type(None)}


def _within(key: str, info: Any, bound: float) -> None:
    kind = TypeAdapter(_annotated(info))
    try:
        kind.validate_python(bound, strict=True)
    except ValidationError:
        allowed = complaint.bounds(info, key) or "a number"
        raise ConfigError(f"--parameter {key} = {bound:g}: allowed: {allowed}") from None


def _annotated(info: Any) -> Any:
    return Annotated[(info.annotation, *info.metadata)] if info.metadata else info.annotation


def points(
    parameters: Sequence[Parameter], kind: Points, number: int | None = None, seed: int = 0
) -> list[Inputs]:
    """The points of a design of experiments, each once.

    Args:
        parameters: at least one.
        kind: ``grid``, every combination of each parameter's ``count`` values, the first
            parameter the slowest; ``sobol``, of which a longer sequence contains a shorter one;
            or ``lhs``, a Latin hypercube.
        number: of samples; None on a grid.
        seed: of the samples.

    Raises:
        ConfigError: one line, where a count is missing or too much.
    """
    repeated = {p.key for p in parameters if sum(q.key == p.key for q in parameters) > 1}
    if repeated:
        raise ConfigError(f"--parameter {min(repeated)}: given twice; allowed: once")
    if kind == "grid":
        shares = _grid(parameters, number)
    else:
        if number is None or number < 1:
            raise ConfigError(f"--points {kind}: --number = {number}; allowed: at least 1")
        shares = _samples(len(parameters), kind, number, seed)
    found = [
        {p.key: p.value(float(share)) for p, share in zip(parameters, row, strict=True)}
        for row in shares
    ]
    return list({tuple(point.values()): point for point in found}.values())


def _grid(parameters: Sequence[Parameter], number: int | None) -> np.ndarray:
    counts = []
    for parameter in parameters:
        if parameter.count is None:
            raise ConfigError(
                f"--parameter {parameter.key}: a grid needs a count; allowed: low:high:count"
            )
        counts.append(parameter.count)
    if number is not None and number != math.prod(counts):
        raise ConfigError(
            f"--number {number}: the grid has {' x '.join(map(str, counts))} points; "
            "allowed: no number with --points grid, or sobol or lhs"
        )
    axes = [np.linspace(0, 1, count) for count in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(counts))


def _samples(dimensions: int, kind: Points, number: int, seed: int) -> np.ndarray:
    if kind == "lhs":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=seed).random(number))
    with warnings.catch_warnings():
        # a number that is no power of two costs some balance, which is the caller's choice
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(qmc.Sobol(dimensions, rng=seed).random(number))
