"""Readings of a finger's experiments, at the highest pressure or at a place of the path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Final

import numpy as np

from dolfingrip.channels import CHANNELS, CONTACT_GAP, CURVE, FORCE, OBSTACLE, PRESSURE, read_of
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.quantities.quantity import (
    AskedDesign,
    Outcome,
    Places,
    Quantity,
    QuantitySource,
)
from dolfingrip.experiments.request import Answer, Place, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.jobs.job import JobFailure

SIDE_STIFFNESS: Final = "stiffness_y_N_per_mm"

USUAL: Final[dict[str, str]] = {
    **{each.name: "bending" for each in read_of("finger")},
    **{each.name: "blocked_force" for each in read_of("plate")},
    CURVE.name: "bending",
    **{each.name: "bending" for each in OBSTACLE},
    "work_mJ": "bending",
    "peak_stretch": "bending",
    SIDE_STIFFNESS: "push",
}
"""FingerReadings, each with the experiment that is run for it unless another is named."""

OBSTACLE_NAMES: Final = frozenset(each.name for each in OBSTACLE)

EXPERIMENTS: Final = {"blocked_force": "blocked", "bending": "free", "push": "pushed"}
"""Experiments, and what the columns of their curves begin with."""


class FingerReadings(QuantitySource):
    """Readings of one finger: of its tip, of its cavity, of the plate that it presses on."""

    names: ClassVar = (*USUAL, PRESSURE.name)

    def quantity(self, said: str, name: str, places: Places, experiment: str | None) -> Quantity:
        if len(places) > 1 or (not places and name == PRESSURE.name):
            raise ConfigError(
                f"{said}: {len(places)} places; allowed: one, a pressure (kPa), a force (N) or an "
                "angle (deg)"
            )
        where, values = next(iter(places.items()), ("", ()))
        if name == where:
            raise ConfigError(f"{said}: given by {where}; allowed: another place")
        if name in OBSTACLE_NAMES and where == FORCE.name:
            where = OBSTACLE[0].name  # the force that is meant is that on the obstacle
        usual = USUAL[where if name == PRESSURE.name else name]
        if where == FORCE.name:
            usual = USUAL[FORCE.name]
        chosen = experiment or usual
        if chosen not in EXPERIMENTS:
            raise ConfigError(f"{said} in {chosen}: allowed: in {', '.join(EXPERIMENTS)}")
        if FORCE.name in (name, where) and chosen != USUAL[FORCE.name]:
            raise ConfigError(
                f'experiment = "{chosen}": allowed: "{USUAL[FORCE.name]}" with {FORCE.name}'
            )
        if name == SIDE_STIFFNESS and (chosen != "push" or where not in ("", PRESSURE.name)):
            raise ConfigError(f'{name} in "{chosen}": allowed: in "push", at a pressure')
        return Quantity(name, chosen, where, values, chosen == usual)

    def check_design(self, wanted: Sequence[Quantity], design: AskedDesign) -> None:
        for experiment, some in by_experiment(wanted).items():
            request(experiment, some, design)

    def add(self, outcome: Outcome, wanted: Sequence[Quantity], design: AskedDesign) -> None:
        assert outcome.curve is not None
        assert outcome.gradients is not None
        for experiment, some in by_experiment(wanted).items():
            asking = request(experiment, some, design)
            answer = compute(asking)
            outcome.curve |= _curve(asking, answer)
            outcome.iterations = (outcome.iterations or 0) + answer.iterations
            if answer.failure_class is not None:
                curve = {"curve": outcome.curve}
                raise JobFailure(answer.failure_class, answer.failure or "", curve)
            for quantity in some:
                value, slopes = read(quantity, asking, answer)
                outcome.outputs[str(quantity)] = value
                outcome.gradients[str(quantity)] = _sorted(slopes, design.keys or ())


def by_experiment(wanted: Sequence[Quantity]) -> dict[str, list[Quantity]]:
    """Sort quantities by the experiment that gives them.

    Args:
        wanted: the quantities; experiments stand in their order.
    """
    quantities: dict[str, list[Quantity]] = {}
    for quantity in wanted:
        quantities.setdefault(str(quantity.experiment), []).append(quantity)
    return quantities


def request(experiment: str, wanted: Sequence[Quantity], design: AskedDesign) -> Request:
    """Ask for the simulation that quantities are read from.

    Args:
        experiment: that gives them.
        wanted: quantities; where all are readings at the highest pressure, the path stops where the
            configuration says.
        design: its configuration, and what is wanted of it.

    Returns:
        The request.

    Raises:
        ConfigError: one line, where there is no such design.
    """
    from dolfingrip.experiments.derivatives.gradients import XI, by_adjoint

    keys = design.keys
    if keys is None and by_adjoint(design.config):
        keys = XI
    names = tuple(dict.fromkeys(quantity.name for quantity in wanted))
    if all(not quantity.where and quantity.name in CHANNELS for quantity in wanted):
        return Request.of(
            experiment, design.config, keys, at_highest=True,
            columns=(PRESSURE.name, *names, CONTACT_GAP.name),
            fields=None if design.fields is None else design.fields / experiment,
            ranks=design.ranks,
        )  # fmt: skip
    if design.fields is not None:
        raise ConfigError(f"--fields: allowed: without a place, as in {wanted[0]}")
    return replace(at_places(experiment, wanted, design.config, keys), ranks=design.ranks)


def at_places(
    experiment: str,
    wanted: Sequence[Quantity],
    config: Config,
    keys: Sequence[str] | None,
    **further: Any,
) -> Request:
    """Ask for quantities at the places of a path where they are read.

    Args:
        experiment: that gives them.
        wanted: quantities.
        config: of the design; its highest pressure is raised if a place lies above.
        keys: of parameters that they are derived by; None: no derivatives.
        further: attributes of the request.

    Returns:
        The request.

    Raises:
        ConfigError: one line, where there is no such design.
    """
    places = tuple(dict.fromkeys(place for q in wanted for place in _places(q, config)))
    highest = max((place.value for place in places if place.column == PRESSURE.name), default=0.0)
    if highest > config.experiment.max_pressure_kPa:
        config = config.changed(experiment={"max_pressure_kPa": highest})
    columns = tuple(dict.fromkeys(q.name for q in wanted))
    return Request.of(experiment, config, keys, columns=columns, places=places, **further)


def _places(quantity: Quantity, config: Config) -> list[Place]:
    """Places of a path where a quantity is read."""
    if not quantity.where:
        return [Place(PRESSURE.name, config.experiment.max_pressure_kPa)]
    return [Place(quantity.where, value) for value in quantity.values]


def read(quantity: Quantity, request: Request, answer: Answer) -> tuple[float, dict[str, float]]:
    """Read a quantity from the answer of its request.

    Args:
        quantity: that was asked for.
        request: the request.
        answer: without a failure.

    Returns:
        Its value, and its derivatives by key of the parameter, as far as they were taken.
    """
    if request.places:
        at = [request.places.index(place) for place in _places(quantity, request.config)]
    else:
        at = [int(np.argmax(answer.columns[PRESSURE.name]))]
    slopes = {
        key: float(np.mean(values[at]))
        for (column, key), values in answer.slopes.items()
        if column == quantity.name and np.isfinite(values[at]).all()
    }
    return float(np.mean(answer.columns[quantity.name][at])), slopes


def _sorted(slopes: dict[str, float], keys: Sequence[str]) -> dict[str, float]:
    """Derivatives in the order of the keys that were asked for; a choice's label begins with it."""
    order = {key: number for number, key in enumerate(keys)}
    ranked = sorted(slopes, key=lambda label: order.get(label.partition(" ")[0], len(order)))
    return {label: slopes[label] for label in ranked}


def _curve(request: Request, answer: Answer) -> dict[str, list[float]]:
    """Readings at each pressure or place that was reached."""
    prefix = EXPERIMENTS[request.experiment.name]
    common: dict[str, np.ndarray] = dict.fromkeys((PRESSURE.name, CONTACT_GAP.name), np.empty(0))
    if answer.columns and {place.column for place in request.places} == {PRESSURE.name}:
        common[PRESSURE.name] = np.array([place.value for place in request.places])
    return {
        f"{prefix}_{name}" if name in common else name: list(map(float, values))
        for name, values in {**common, **answer.columns}.items()
    }
