"""The problem of a design: what is improved, what is held, and what may change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from dolfingrip.channels import CURVE, CURVE_PARTS
from dolfingrip.config import Config, changed
from dolfingrip.design.gradient.file import FrontTable, Method
from dolfingrip.design.quantities.quantity import Quantity
from dolfingrip.parameter import Parameter, find

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Variable:
    """A parameter with its range.

    Attributes:
        parameter: of the configuration.
        low, high: in the parameter's unit.
        start: where it begins.
    """

    parameter: Parameter
    low: float
    high: float
    start: float

    @property
    def key(self) -> str:
        """Key of the configuration."""
        return self.parameter.key


class Scaling:
    """Values of variables as parts of their ranges, 0 to 1.

    Args:
        variables: with their ranges.

    Attributes:
        low, size: shape (variables,), where each range begins, and how long it is.
        start: shape (variables,), scaled values where they begin.
    """

    def __init__(self, variables: Sequence[Variable]) -> None:
        self.low = np.array([v.low for v in variables])
        self.size = np.array([v.high for v in variables]) - self.low
        self.start = self.parts(np.array([v.start for v in variables]))

    def parts(self, values: Floats) -> Floats:
        """Scale values, shape (…, variables)."""
        return np.asarray((values - self.low) / self.size, dtype=float)

    def values(self, parts: Floats, digits: int = 10) -> Floats:
        """Return values of scaled ones, shape (…, variables), to so many decimals."""
        return np.asarray(np.round(self.low + parts * self.size, digits) + 0.0)  # no minus zero


@dataclass(frozen=True, slots=True)
class Constraint:
    """A limit of a quantity: sign · (value − limit) ≤ 0.

    Attributes:
        quantity: that is limited.
        sign: 1 for a largest value, −1 for a least one.
        limit: in the quantity's unit; None: the start's value.
    """

    quantity: Quantity
    sign: float
    limit: float | None

    def __str__(self) -> str:
        word = "at most" if self.sign > 0 else "at least"
        value = "the start's" if self.limit is None else f"{self.limit:g}"
        return f"{self.quantity} {word} {value}"


@dataclass(frozen=True, slots=True)
class Condition:
    """One of the conditions under which a design is simulated.

    Attributes:
        name: for people.
        base: configuration that the variables are put into.
        change: amounts that are added to parameters of it.
    """

    name: str
    base: Config
    change: Mapping[str, float] = field(default_factory=dict)

    def config(self, variables: Sequence[Variable], values: Sequence[float]) -> Config:
        """The configuration of a design.

        Raises:
            ConfigError: one line, where there is no such finger.
        """
        given = dict(zip((v.key for v in variables), values, strict=True))
        config = changed(self.base, given)
        if self.change:
            now = {p.key: p.value(config) for p in find(config, list(self.change))}
            config = changed(config, {key: now[key] + self.change[key] for key in now})
        return config


@dataclass(frozen=True, slots=True)
class Problem:
    """A design problem: an objective, limits, and what may change.

    Attributes:
        sign: 1 where the objective is minimised, −1 where it is maximised.
        objective: quantity that is improved.
        limits: that are held.
        variables: that may change.
        conditions: that a design is simulated under; the first is the nominal one.
        method: how long it is sought.
        front: that is asked for instead of one design; None: one design.
        against: quantity that the front limits.
    """

    sign: float
    objective: Quantity
    limits: tuple[Constraint, ...]
    variables: tuple[Variable, ...]
    conditions: tuple[Condition, ...]
    method: Method
    front: FrontTable | None = None
    against: Quantity | None = None

    @property
    def parts(self) -> tuple[Quantity, ...]:
        """Numbers whose squares add up to nearly the objective, for each place; () if none do."""
        goal = self.objective
        if goal.name != CURVE.name:
            return ()
        values: list[tuple[float, ...]] = [(place,) for place in goal.values] or [()]
        curve = self.nominal.base.curve
        names = CURVE_PARTS[:2] if curve is not None and curve.of_tip else CURVE_PARTS
        return tuple(replace(goal, name=name, values=value) for name in names for value in values)

    @property
    def nominal(self) -> Condition:
        """The condition without a scenario."""
        return self.conditions[0]
