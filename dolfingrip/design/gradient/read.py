"""From a design file to its problem, with one line about bad input.

Numbers of a free form get their starts and ranges here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dolfingrip import config as configuration
from dolfingrip.config import NO_CHANGE, Change, Config, ConfigError
from dolfingrip.design.gradient import curve
from dolfingrip.design.gradient.file import (
    FACING,
    OF_MANY,
    OVERHANG,
    File,
    FreeFormTable,
    FrontTable,
    Limit,
    Objective,
    Scenario,
)
from dolfingrip.design.gradient.problem import Condition, Constraint, Problem, Variable
from dolfingrip.design.quantities.grasp import GRASP
from dolfingrip.design.quantities.quantity import Quantity
from dolfingrip.parameter import Entry, Parameter, find, named
from dolfingrip.sections import tables
from dolfingrip.sections.errors import checked
from dolfingrip.sections.form import Form, Offset
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, BoxSolid

NO_NUMBERS = (Entry.CHOICE, Entry.INSTRUMENT, Entry.SUPPLY)
"""Kinds of parameters that a finger has no gradient by."""


def read(file: Path, overrides: Change = NO_CHANGE) -> Problem:
    """The problem in a design file.

    Args:
        file: TOML.
        overrides: values of the finger's configuration by key.

    Raises:
        ConfigError: one line about bad input.
    """
    data = tables.whole(file, "FILE")
    spec = checked(File, data)
    given = {**tables.assignments(spec.set, "set"), **overrides}
    base = configuration.load(_beside(file, spec.config), given)
    if base.experiment.control != "pressure":
        raise ConfigError(
            f'experiment.control = "{base.experiment.control}": allowed: "pressure" for a design'
        )
    _without_memory(base)
    key, name = _objective(spec.objective)
    sign = -1.0 if key == "maximise" else 1.0
    base, improved = curve.given(spec.objective, file.parent, base)
    objective = improved.quantity(f"objective.{key}", name)
    if name in OF_MANY:
        raise ConfigError(f"objective = {name}: an extreme over the shape; allowed: a constraint")
    limits = tuple(_limits(spec.constraints))
    if spec.free_form is not None:
        base = _free_form_base(base, spec.free_form)
    variables = tuple(_variables(base, spec, grasp=objective.experiment == GRASP))
    conditions = [Condition("nominal", base)]
    for number, scenario in enumerate(spec.scenarios, 1):
        conditions.append(_condition(file, spec, base, given, number, scenario))
    against = None
    if spec.front is not None:
        against = spec.front.quantity("front.against", spec.front.against)
        _check_front(spec.front, limits, objective, against)
    if objective.experiment == GRASP:
        _check_grasp(spec, limits)
    return Problem(
        sign, objective, limits, variables, tuple(conditions), spec.method, spec.front, against
    )


def _check_front(
    front: FrontTable, limits: Sequence[Constraint], objective: Quantity, against: Quantity
) -> None:
    if objective.experiment is None and against.experiment is None:
        raise ConfigError(
            f"front.against = {against}: allowed: a reading, as the objective is of the shape"
        )
    if objective == against:
        raise ConfigError(f"front.against = {against}: allowed: another one than the objective")
    if not front.low < front.high:
        raise ConfigError(f"front.low = {front.low:g}: allowed: below high = {front.high:g}")
    for limit in limits:
        if limit.quantity.experiment is not None or limit.limit is None:
            raise ConfigError(f"constraints: {limit}: allowed with a front: numbers of the shape")


def _check_grasp(spec: File, limits: Sequence[Constraint]) -> None:
    """Refuse what a search without gradients has not.

    Raises:
        ConfigError: one line.
    """
    for limit in limits:
        if limit.quantity.experiment is not None:
            raise ConfigError(f"constraints: {limit}; allowed with a grasp: numbers of the shape")
    if spec.front is not None or spec.free_form is not None or spec.method.starts > 1:
        raise ConfigError(
            "front, free_form, method.starts: allowed with an objective that has a gradient"
        )


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


def _objective(objective: Objective) -> tuple[str, str]:
    """The key that says what is improved, and the quantity's name."""
    keys = ("maximise", "minimise", *curve.KEYS)
    given = [key for key in keys if getattr(objective, key) is not None]
    if len(given) != 1:
        words = ", ".join(f"{key} =" for key in keys)
        raise ConfigError(f"objective: {len(given)} quantities; allowed: one of {words}")
    return given[0], curve.KEYS.get(given[0]) or getattr(objective, given[0])


def _limits(limits: Sequence[Limit]) -> list[Constraint]:
    constraints: list[Constraint] = []
    for limit in limits:
        of = limit.quantity("constraints.of", limit.of)
        if limit.at_most is None and limit.at_least is None:
            raise ConfigError(f"constraints.of = {limit.of}: allowed: with at_most or at_least")
        if of.name in FACING and limit.at_most is not None:
            raise ConfigError(f"constraints.of = {of.name}: allowed: at_least")
        if of.name == OVERHANG and limit.at_least is not None:
            raise ConfigError("constraints.of = overhang_deg: allowed: at_most")
        for sign, value in ((1.0, limit.at_most), (-1.0, limit.at_least)):
            if value is not None:
                constraints.append(Constraint(of, sign, None if value == "start" else float(value)))
        both = limit.at_most, limit.at_least
        if all(isinstance(bound, float) for bound in both) and limit.at_least > limit.at_most:  # type: ignore[operator]
            raise ConfigError(
                f"constraints.of = {limit.of}: at_least = {limit.at_least:g} above at_most = "
                f"{limit.at_most:g}; allowed: limits that a design can keep"
            )
    for one in constraints:
        for other in constraints:
            contrary = one.quantity == other.quantity and one.sign < 0 < other.sign
            if contrary and None not in (one.limit, other.limit) and one.limit > other.limit:  # type: ignore[operator]
                raise ConfigError(
                    f"constraints: {one} and {other}; allowed: limits that a design can keep"
                )
    return constraints


def _variables(base: Config, spec: File, *, grasp: bool) -> list[Variable]:
    variables: list[Variable] = []
    for key, value in _flat(spec.parameters):
        variables += _ranged(base, key, value, grasp=grasp)
    if spec.free_form is not None:
        variables += _free_form_variables(base, spec.free_form)
    if not variables:
        raise ConfigError("parameters: none; allowed: section.key = [low, high], or [free_form]")
    return variables


def _flat(data: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    """Keys with their dots, and their values; ``{from, to, start}`` is a value."""
    pairs: list[tuple[str, Any]] = []
    for key, value in data.items():
        name = f"{before}{key}"
        if isinstance(value, Mapping) and not {"from", "to", "start"} & set(value):
            pairs += _flat(value, f"{name}.")
        else:
            pairs.append((name, value))
    return pairs


def _parameters(base: Config, key: str, *, grasp: bool) -> list[Parameter]:
    """Parameters of a key; of a grasp also the gripper's."""
    if grasp and key.startswith("gripper."):
        return [named(key, "parameters")]
    try:
        return find(base, [key])
    except ConfigError as error:
        raise ConfigError(str(error).replace("--parameters ", "parameters.")) from None


def _ranged(base: Config, key: str, value: Any, *, grasp: bool) -> list[Variable]:
    option = f"parameters.{key}"
    start: Any = None
    if isinstance(value, Mapping):
        if not set(value) <= {"from", "to", "start"}:
            raise ConfigError(f"{option} = {dict(value)}: allowed: from, to, start")
        start, value = value.get("start"), [value.get("from"), value.get("to")]
    numbers = isinstance(value, list) and len(value) == 2
    if not numbers or not all(_is_number(number) for number in value):
        raise ConfigError(f"{option} = {value}: allowed: [low, high], or from, to and start")
    low, high = map(float, value)
    if not low < high:
        raise ConfigError(f"{option} = [{low:g}, {high:g}]: allowed: low below high")
    variables = []
    refused = (Entry.INSTRUMENT, Entry.SUPPLY) if grasp else NO_NUMBERS
    for parameter in _parameters(base, key, grasp=grasp):
        if parameter.entry in refused or parameter.integer:
            raise ConfigError(f"{option}: {parameter.entry}; allowed: a number of the finger")
        if parameter.field.annotation in (float, float | None):
            for bound in (low, high):
                parameter.check(bound, "parameters")
        begins = parameter.value(base) if start is None else start
        if not _is_number(begins) or not low <= begins <= high:
            allowed = f"{low:g} to {high:g} {parameter.unit}".rstrip()
            raise ConfigError(f"{option}: start = {begins}: allowed: {allowed}")
        variables.append(Variable(parameter, low, high, float(begins)))
    return variables


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _condition(
    file: Path,
    spec: File,
    base: Config,
    given: Change,
    number: int,
    scenario: Scenario,
) -> Condition:
    """A further condition.

    Raises:
        ConfigError: one line, where it has not the finger's free form or parameters.
    """
    other = _beside(file, scenario.config or spec.config)
    config = configuration.load(
        other, {**given, **tables.assignments(scenario.set, "scenarios.set")}
    )
    _without_memory(config)
    for name in ("form", "curve", "obstacle"):
        if (table := getattr(base, name)) is not None:
            config = config.changed(**{name: table.model_dump()})
    change: dict[str, float] = {}
    for assignment in scenario.change:
        key, amount = tables.assigned(assignment, "scenarios.change")
        if not _is_number(amount):
            raise ConfigError(f"scenarios.change {assignment}: allowed: section.key=number")
        (parameter,) = find(config, [key])
        change[parameter.key] = float(amount)
    said = [*scenario.set, *(f"{key} {amount:+g}" for key, amount in change.items())]
    name = ", ".join(said) or str(scenario.config or f"scenario {number}")
    return Condition(name, config, change)


def _free_form_base(base: Config, table: FreeFormTable) -> Config:
    """A configuration with a free form: its own, or planes with a ripple.

    A straight tube is as stiff with a ripple of either sign, so no gradient makes bellows of it;
    MorphOpt's tubes begin with a ripple, too.

    Raises:
        ConfigError: one line, where the finger cannot have one.
    """
    if base.form is not None:
        if table.ripple_mm:
            raise ConfigError(
                f"free_form.ripple_mm = {table.ripple_mm:g}: allowed: without a [form] to begin at"
            )
        return base
    if base.mesh.file is not None:
        raise ConfigError("free_form: allowed: with a finger that is made from dimensions")
    boxes = base.geometry.boxes()
    if boxes is None:
        raise ConfigError("free_form: allowed: with a finger that is made of boxes")
    form = Form(along=table.along, contact_face=table.faces != "walls", offsets_mm=())
    offsets = tuple(_ripple(offset, boxes, table) for offset in form.each(boxes))
    return base.changed(form=form.model_copy(update={"offsets_mm": offsets}).model_dump())


def _free_form_variables(base: Config, table: FreeFormTable) -> list[Variable]:
    """The offsets of a configuration's free form, with their ranges.

    Raises:
        ConfigError: one line, where they begin outside them.
    """
    boxes = base.geometry.boxes()
    assert base.form is not None
    assert boxes is not None
    variables = []
    parameters = find(base, ["form.offsets_mm"])
    for parameter, offset in zip(parameters, base.form.each(boxes), strict=True):
        if not table.ends and _at_end(offset):
            continue
        inside = offset.axis != 0 or offset.plane_mm > boxes.body[0][0]
        if inside and table.faces == "contact face":
            continue
        high = table.most_mm
        outer = abs(offset.plane_mm - boxes.body[offset.axis][1]) < TOLERANCE_MM
        if table.outwards_mm is not None and outer:
            high = min(table.outwards_mm, table.most_mm)
        start = float(parameter.value(base))
        if not -table.most_mm <= start <= high:
            raise ConfigError(
                f"free_form: start = {start:g} of {parameter.key}: allowed: {-table.most_mm:g} to "
                f"{high:g} mm"
            )
        variables.append(Variable(parameter, -table.most_mm, high, start))
    return variables


def _at_end(offset: Offset) -> bool:
    return offset.axis == 2 or offset.along in (0.0, 1.0)


def _ripple(offset: Offset, boxes: BoxSolid, table: FreeFormTable) -> float:
    """Amplitude of the ripple: 0 at the contact face and along z, all of it at the roof."""
    (low, high), _, (start, end) = boxes.body
    if offset.axis == 2 or not table.ripple_mm or (not table.ends and _at_end(offset)):
        return 0.0
    share = float(offset.function) if offset.axis == 1 else 1.0
    if offset.axis == 0 and offset.plane_mm < (low + high) / 2:
        share = 0.0
    waves = offset.along * (end - start) / table.ripple_length_mm
    return round(share * table.ripple_mm * math.cos(2 * math.pi * waves), 9)
