"""The problem of a design: what is improved, what is held, and what may change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from dolfingrip import config as configuration
from dolfingrip.channels import ANGLE, FORCE, PRESSURE
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.gradient.quantity import OF_MANY, Experiment, Quantity, quantity
from dolfingrip.parameter import Entry, Parameter, find, put
from dolfingrip.sections import tables
from dolfingrip.sections.errors import checked
from dolfingrip.sections.form import Form
from dolfingrip.sections.section import Section

Numbers = Annotated[tuple[float, ...], Field(strict=False, min_length=1)]
At = float | Numbers | None
PLACES = {"at_pressure_kPa": PRESSURE.name, "at_force_N": FORCE.name, "at_angle_deg": ANGLE.name}


class Placed(Section):
    """A reading at a place of an experiment's path."""

    at_pressure_kPa: At = Field(None, description="a pressure, or several: the mean counts")
    at_force_N: At = Field(None, description="where the blocked force has this value")
    at_angle_deg: At = Field(None, description="where the tip's angle has this value")
    experiment: Experiment | None = Field(None, description="that is run instead of the usual one")

    def quantity(self, option: str, name: str) -> Quantity:
        """The quantity of this name at this place."""
        places = {}
        for key, column in PLACES.items():
            value = getattr(self, key)
            if value is not None:
                places[column] = value if isinstance(value, tuple) else (value,)
        return quantity(option, name, places, self.experiment)


class Objective(Placed):
    """What is improved."""

    maximise: str | None = Field(None, description="name of a quantity")
    minimise: str | None = Field(None, description="name of a quantity")


class Limit(Placed):
    """What is held."""

    of: str = Field(description="name of a quantity")
    at_most: float | Literal["start"] | None = Field(None, description="in the name's unit")
    at_least: float | Literal["start"] | None = Field(None, description="in the name's unit")


class FreeForm(Section):
    """Offsets of the planes of the finger's faces."""

    along: int = Field(5, ge=3, le=40, description="numbers of a field along the finger")
    most_mm: float = Field(0.5, gt=0, le=20, description="largest offset")


class Scenario(Section):
    """A condition that a design must stand, too; the worst one counts."""

    config: Path | None = Field(None, strict=False, description="another configuration")
    set: tuple[str, ...] = Field((), strict=False, description="section.key=value")
    change: tuple[str, ...] = Field((), strict=False, description="section.key=amount to add")


class Method(Section):
    """How long it is sought."""

    simulations: int = Field(40, ge=1, description="largest number of load paths")
    radius: float = Field(
        0.25, gt=0, le=1, description="first step in each variable, as a part of its range"
    )


class Front(Section):
    """A front instead of one design: the best objective for each limit of a number of the shape."""

    against: Literal["cog_offset_mm", "mass_g"] = Field(description="that is limited")
    low: float = Field(description="least limit, in the name's unit")
    high: float = Field(description="largest limit, in the name's unit")
    unsure: float = Field(
        0.005, gt=0, lt=1, description="largest deviation on it, as a part of the objective's range"
    )


class File(Section):
    """A design file."""

    config: Path | None = Field(None, strict=False, description="of the finger; relative to it")
    set: tuple[str, ...] = Field((), strict=False, description="section.key=value")
    objective: Objective = Field(description="what is improved")
    constraints: tuple[Limit, ...] = Field((), strict=False, description="what is held")
    parameters: dict[str, Any] = Field({}, description="key = [low, high]")
    free_form: FreeForm | None = None
    scenarios: tuple[Scenario, ...] = Field((), strict=False, description="that it must stand")
    method: Method = Method()
    front: Front | None = None


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
        """Of the configuration."""
        return self.parameter.key

    def scaled(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of it as parts of its range, 0 to 1."""
        return np.asarray((values - self.low) / (self.high - self.low), dtype=float)


@dataclass(frozen=True, slots=True)
class Held:
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
        given = dict(zip((each.key for each in variables), values, strict=True))
        config = put(self.base, given)
        if self.change:
            now = {each.key: each.value(config) for each in find(config, list(self.change))}
            config = put(config, {key: now[key] + self.change[key] for key in now})
        return config


@dataclass(frozen=True, slots=True)
class Problem:
    """What is improved, what is held, and what may change.

    Attributes:
        sign: 1 where the objective is minimised, −1 where it is maximised.
        objective: quantity that is improved.
        limits: that are held.
        variables: that may change.
        conditions: that a design is simulated under; the first is the nominal one.
        method: how long it is sought.
        front: that is asked for instead of one design; None: one design.
    """

    sign: float
    objective: Quantity
    limits: tuple[Held, ...]
    variables: tuple[Variable, ...]
    conditions: tuple[Condition, ...]
    method: Method
    front: Front | None = None

    @property
    def nominal(self) -> Condition:
        """The condition without a scenario."""
        return self.conditions[0]


def read(file: Path, overrides: Sequence[str] = ()) -> Problem:
    """The problem in a design file.

    Args:
        file: TOML.
        overrides: ``section.key=value`` strings for the finger's configuration.

    Raises:
        ConfigError: one line about bad input.
    """
    data = tables.whole(file, "FILE")
    asked = checked(File, data)
    base = configuration.load(_beside(file, asked.config), [*asked.set, *overrides])
    if base.experiment.control != "pressure":
        raise ConfigError(
            f'experiment.control = "{base.experiment.control}": allowed: "pressure" for a design'
        )
    _without_memory(base)
    sign, name = _objective(asked.objective)
    objective = asked.objective.quantity("objective", name)
    if name in OF_MANY:
        raise ConfigError(f"objective = {name}: an extreme over the shape; allowed: a constraint")
    limits = tuple(_limits(asked.constraints))
    if asked.free_form is not None:
        base = _with_form(base, asked.free_form)
    variables = tuple(_variables(base, asked))
    conditions = [Condition("nominal", base)]
    for number, scenario in enumerate(asked.scenarios, 1):
        conditions.append(_condition(file, asked, base, overrides, number, scenario))
    if asked.front is not None:
        _check_front(asked.front, limits)
    return Problem(sign, objective, limits, variables, tuple(conditions), asked.method, asked.front)


def _check_front(front: Front, limits: Sequence[Held]) -> None:
    if not front.low < front.high:
        raise ConfigError(f"front.low = {front.low:g}: allowed: below high = {front.high:g}")
    for limit in limits:
        if limit.quantity.experiment is not None or limit.limit is None:
            raise ConfigError(f"constraints: {limit}: allowed with a front: numbers of the shape")


def _beside(file: Path, other: Path | None) -> Path | None:
    return None if other is None else file.parent / other


def _without_memory(base: Config) -> None:
    """Refuse what remembers: it has no adjoint.

    Raises:
        ConfigError: one line that names the effect.
    """
    for effect in base.extensions.active():
        if effect.remembers():
            raise ConfigError(
                f"extensions.{effect.name()}: remembers earlier states, and so has no gradient "
                "here; allowed: effects without memory"
            )


def _objective(asked: Objective) -> tuple[float, str]:
    names = [each for each in (asked.maximise, asked.minimise) if each is not None]
    if len(names) != 1:
        raise ConfigError(
            f"objective: {len(names)} quantities; allowed: one of maximise = and minimise ="
        )
    return (1.0 if asked.minimise else -1.0), names[0]


def _limits(asked: Sequence[Limit]) -> list[Held]:
    found: list[Held] = []
    for limit in asked:
        of = limit.quantity("constraints.of", limit.of)
        if limit.at_most is None and limit.at_least is None:
            raise ConfigError(f"constraints.of = {limit.of}: allowed: with at_most or at_least")
        if of.name in ("least_wall_mm", "least_gap_mm") and limit.at_most is not None:
            raise ConfigError(f"constraints.of = {of.name}: allowed: at_least")
        if of.name == "overhang_deg" and limit.at_least is not None:
            raise ConfigError("constraints.of = overhang_deg: allowed: at_most")
        for sign, value in ((1.0, limit.at_most), (-1.0, limit.at_least)):
            if value is not None:
                found.append(Held(of, sign, None if value == "start" else float(value)))
        both = limit.at_most, limit.at_least
        if all(isinstance(each, float) for each in both) and limit.at_least > limit.at_most:  # type: ignore[operator]
            raise ConfigError(
                f"constraints.of = {limit.of}: at_least = {limit.at_least:g} above at_most = "
                f"{limit.at_most:g}; allowed: limits that a design can keep"
            )
    for one in found:
        for other in found:
            contrary = one.quantity == other.quantity and one.sign < 0 < other.sign
            if contrary and None not in (one.limit, other.limit) and one.limit > other.limit:  # type: ignore[operator]
                raise ConfigError(
                    f"constraints: {one} and {other}; allowed: limits that a design can keep"
                )
    return found


def _with_form(base: Config, asked: FreeForm) -> Config:
    if base.form is not None:
        return base
    if base.mesh.file is not None:
        raise ConfigError("free_form: allowed: with a finger that is made from dimensions")
    boxes = base.geometry.boxes()
    if boxes is None:
        raise ConfigError("free_form: allowed: with a finger that is made of boxes")
    count = Form(along=asked.along, offsets_mm=()).count(boxes)
    return base.changed(form={"along": asked.along, "offsets_mm": (0.0,) * count})


def _variables(base: Config, asked: File) -> list[Variable]:
    found: list[Variable] = []
    for key, value in _flat(asked.parameters):
        found += _ranged(base, key, value)
    if asked.free_form is not None:
        most = asked.free_form.most_mm
        for parameter in find(base, ["form.offsets_mm"]):
            found.append(Variable(parameter, -most, most, parameter.value(base)))
    if not found:
        raise ConfigError("parameters: none; allowed: section.key = [low, high], or [free_form]")
    return found


def _flat(data: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    """Keys with their dots, and their values; ``{from, to, start}`` is a value."""
    found: list[tuple[str, Any]] = []
    for key, value in data.items():
        name = f"{before}{key}"
        if isinstance(value, Mapping) and not {"from", "to", "start"} & set(value):
            found += _flat(value, f"{name}.")
        else:
            found.append((name, value))
    return found


def _ranged(base: Config, key: str, value: Any) -> list[Variable]:
    option = f"parameters.{key}"
    start: Any = None
    if isinstance(value, Mapping):
        if not set(value) <= {"from", "to", "start"}:
            raise ConfigError(f"{option} = {dict(value)}: allowed: from, to, start")
        start, value = value.get("start"), [value.get("from"), value.get("to")]
    numbers = isinstance(value, list) and len(value) == 2
    if not numbers or not all(_is_number(each) for each in value):
        raise ConfigError(f"{option} = {value}: allowed: [low, high], or from, to and start")
    low, high = map(float, value)
    if not low < high:
        raise ConfigError(f"{option} = [{low:g}, {high:g}]: allowed: low below high")
    found = []
    try:
        parameters = find(base, [key])
    except ConfigError as error:
        raise ConfigError(str(error).replace("--parameters ", "parameters.")) from None
    for parameter in parameters:
        if parameter.entry in (Entry.CHOICE, Entry.INSTRUMENT, Entry.SUPPLY) or parameter.integer:
            raise ConfigError(f"{option}: {parameter.entry}; allowed: a number of the finger")
        if parameter.field.annotation in (float, float | None):
            for bound in (low, high):
                parameter.check(bound, "parameters")
        begins = parameter.value(base) if start is None else start
        if not _is_number(begins) or not low <= begins <= high:
            allowed = f"{low:g} to {high:g} {parameter.unit}".rstrip()
            raise ConfigError(f"{option}: start = {begins}: allowed: {allowed}")
        found.append(Variable(parameter, low, high, float(begins)))
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _condition(
    file: Path,
    asked: File,
    base: Config,
    overrides: Sequence[str],
    number: int,
    scenario: Scenario,
) -> Condition:
    """A further condition.

    Raises:
        ConfigError: one line, where it has not the finger's free form or parameters.
    """
    other = _beside(file, scenario.config or asked.config)
    found = configuration.load(other, [*asked.set, *overrides, *scenario.set])
    _without_memory(found)
    if base.form is not None:
        found = found.changed(form=base.form.model_dump())
    change: dict[str, float] = {}
    for assignment in scenario.change:
        key, amount = tables.assigned(assignment, "scenarios.change")
        if not _is_number(amount):
            raise ConfigError(f"scenarios.change {assignment}: allowed: section.key=number")
        (parameter,) = find(found, [key])
        change[parameter.key] = float(amount)
    said = [*scenario.set, *(f"{key} {amount:+g}" for key, amount in change.items())]
    name = ", ".join(said) or str(scenario.config or f"scenario {number}")
    return Condition(name, found, change)
