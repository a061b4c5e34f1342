"""The least pressure that picks food up, and the friction that makes it so, by grasps.

Each grasp is an answer in a spool, so that a search that was killed goes on where it was.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import grasps
from dolfingrip.design.campaign.answer import Answer
from dolfingrip.design.campaign.evaluate import Task, work
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.design.campaign.spool import Spool
from dolfingrip.design.campaign.threshold import Threshold, least

PRESSURE: Final = "experiment.max_pressure_kPa"
FRICTION: Final = "food.friction"

LIFT_MM: Final = 10.0
"""Way up in a trial: what slips does so within the first millimetres."""

HIGHEST_kPa: Final = 300.0
"""The paper's highest pressure."""

ESTIMATES: Final = 4
"""Grasps at most that are made to estimate the pressure."""

LARGEST_FRICTION: Final = 2.0

WANTED: Final = ("picked_up", "normal_N", "weight_N", "outcome_s", "margin")


@dataclass(frozen=True, slots=True)
class Trial:
    """One grasp of a search.

    Attributes:
        pressure_kPa: of the fingers.
        friction: of fingers on food.
        picked_up: whether it was.
        outcome: class, or that of the failure.
        normal_N: sum of the normal forces before the lift; 0 of a failure.
        weight_N: of the food.
        computed: not known from before.
        wall_s: its time.
    """

    pressure_kPa: float
    friction: float
    picked_up: bool
    outcome: str
    normal_N: float
    weight_N: float
    computed: bool
    wall_s: float


class Trials:
    """Grasps of one gripper and food by pressure and friction, each computed once.

    Args:
        base: configuration that pressure and friction are put into.
        out: folder, whose ``spool`` has the answers.
        progress: called with each trial.
        objective: import path of what computes a grasp.
    """

    def __init__(
        self,
        base: Config,
        out: Path,
        progress: Callable[[Trial], None] = lambda trial: None,
        objective: str = grasps.OBJECTIVE,
    ) -> None:
        self.base = base
        self._known: dict[str, Trial] = {}
        self._spool = Spool((out / "spool").absolute())
        self._progress = progress
        self._objective = objective

    @property
    def made(self) -> list[Trial]:
        """All trials so far, each once, in order."""
        return list(self._known.values())

    def at(self, pressure_kPa: float, friction: float) -> Trial:
        """The grasp at a pressure and with a coefficient of friction.

        Raises:
            ConfigError: there is no such gripper.
        """
        inputs: Inputs = {PRESSURE: round(pressure_kPa, 9), FRICTION: round(friction, 9)}
        step = min(self.base.experiment.step_kPa, pressure_kPa)
        base = self.base.changed(experiment={"max_pressure_kPa": pressure_kPa, "step_kPa": step})
        plan = Plan(base, (PRESSURE, FRICTION), (inputs,), WANTED, self._objective)
        design = plan.designs()[0]
        if design.key in self._known:
            return self._known[design.key]
        self._spool.folder.mkdir(parents=True, exist_ok=True)
        known = self._spool.read(design.key) is not None
        folder = str(self._spool.folder)
        answer = work(Task(design.key, design.config, WANTED, self._objective, 1, folder))
        if answer.failure_class == "geometry":
            self._spool.forget(design.key)
            raise ConfigError(answer.failure or "there is no such gripper")
        trial = _trial(pressure_kPa, friction, answer, computed=not known)
        self._known[design.key] = trial
        self._progress(trial)
        return trial


def _trial(pressure_kPa: float, friction: float, answer: Answer, *, computed: bool) -> Trial:
    outputs: dict[str, Any] = answer.outputs
    outcome = (answer.curve or {}).get("outcome") or f"failure: {answer.failure_class}"
    return Trial(
        pressure_kPa,
        friction,
        outputs.get("picked_up") == 1.0,
        str(outcome),
        float(outputs.get("normal_N", 0.0)),
        float(outputs.get("weight_N", 0.0)),
        computed,
        answer.wall_s or 0.0,
    )


@dataclass(frozen=True, slots=True)
class Pickup:
    """The least pressure that picks up.

    Attributes:
        fails_kPa: highest pressure below that was tried and does not; None where there is none.
        least_kPa: that pressure; None where none up to the highest does.
    """

    fails_kPa: float | None
    least_kPa: float | None


def pickup_pressure(
    trials: Trials,
    resolution_kPa: float,
    start_kPa: float,
    highest_kPa: float = HIGHEST_kPa,
    estimates: int = ESTIMATES,
) -> Pickup:
    """The least multiple of ``resolution_kPa`` at which the food is picked up.

    The first grasp tells how hard the fingers press. Where normal forces grow with the pressure and
    friction bears the weight, W = μ ΣN at the pressure that is sought; so the next grasp is there.
    Once that changes little, grasps on either side confirm it.

    Args:
        trials: grasps; the friction is that of their configuration.
        resolution_kPa: distance of pressures.
        start_kPa: pressure of the first grasp.
        highest_kPa: none above is tried.
        estimates: grasps at most from which the pressure is estimated; 0 where the start is near.
    """
    friction = trials.base.food.friction
    highest = int(highest_kPa / resolution_kPa + 1e-9)

    def trial(place: int) -> Trial:
        return trials.at(place * resolution_kPa, friction)

    place = min(max(round(start_kPa / resolution_kPa), 1), highest)
    for _ in range(estimates):
        made = trial(place)
        if friction <= 0 or made.normal_N <= 0:
            break
        guess = round(place * made.weight_N / (friction * made.normal_N))
        # not far beyond what this grasp has shown
        guess = min(guess, place) if made.picked_up else min(max(guess, place), 2 * place)
        guess = min(max(guess, 1), highest)
        if abs(guess - place) <= 1:
            break
        place = guess
    found = least(lambda at: trial(at).picked_up, place, 1, highest)
    return Pickup(*_scaled(found, resolution_kPa))


@dataclass(frozen=True, slots=True)
class FrictionFound:
    """The friction with which a pressure is the least that picks up.

    Attributes:
        low: least coefficient on the grid that picks up at that pressure.
        high: the largest that does not at the next lower one; between the two the least pressure
            that picks up is the measured one.
        tolerance: of both ends.
    """

    low: float
    high: float
    tolerance: float

    @property
    def friction(self) -> float:
        """The middle of the interval."""
        return (self.low + self.high) / 2


def friction(
    trials: Trials, pickup_kPa: float, resolution_kPa: float, tolerance: float
) -> FrictionFound:
    """The friction for which ``pickup_kPa`` is the least pressure that picks up.

    μ*(p) is the least friction with which pressure p picks up; it falls as p grows. A pick-up
    pressure that was found in steps of the resolution r says that μ*(p) ≤ μ < μ*(p − r). Both are
    searched for from μ = W/ΣN on, with ΣN of one grasp.

    Args:
        trials: grasps.
        pickup_kPa: p.
        resolution_kPa: r.
        tolerance: of μ*.

    Raises:
        ConfigError: one line, where no friction does.
    """
    first = trials.at(pickup_kPa, trials.base.food.friction)
    at_pressure = _least_friction(trials, pickup_kPa, first, tolerance)
    below = trials.at(pickup_kPa - resolution_kPa, at_pressure)
    at_lower = _least_friction(trials, pickup_kPa - resolution_kPa, below, tolerance)
    return FrictionFound(at_pressure, max(at_lower - tolerance, at_pressure), tolerance)


def narrowed(
    known: FrictionFound, trials: Trials, pickup_kPa: float, resolution_kPa: float
) -> FrictionFound:
    """What the pick-up pressure of another object leaves of an interval of friction.

    Objects whose weights differ by a part of what a step of pressure lifts tell μ more closely than
    the step does. Only grasps within the interval are made.

    Args:
        known: from other objects.
        trials: grasps of this one.
        pickup_kPa: its least pressure that picks up.
        resolution_kPa: the step in which it was found.
    """
    low, high = round(known.low / known.tolerance), round(known.high / known.tolerance)

    def least_at(pressure_kPa: float, start: int) -> Threshold:
        return least(
            lambda place: trials.at(pressure_kPa, place * known.tolerance).picked_up,
            start,
            low,
            high,
        )

    at_pressure = least_at(pickup_kPa, low)
    lowest = high if at_pressure.succeeds is None else at_pressure.succeeds
    at_lower = least_at(pickup_kPa - resolution_kPa, high)
    highest = low if at_lower.fails is None else at_lower.fails
    return replace(
        known,
        low=lowest * known.tolerance,
        high=max(lowest, highest) * known.tolerance,
    )


def _least_friction(trials: Trials, pressure_kPa: float, known: Trial, tolerance: float) -> float:
    """μ* at a pressure, on a grid of ``tolerance``; ``known`` is a grasp there."""
    start = known.weight_N / known.normal_N if known.normal_N > 0 else known.friction
    found = least(
        lambda place: trials.at(pressure_kPa, place * tolerance).picked_up,
        round(start / tolerance),
        1,
        round(LARGEST_FRICTION / tolerance),
    )
    if found.succeeds is None:
        raise ConfigError(
            f"--pickup-pressure {pressure_kPa:g}: no friction up to {LARGEST_FRICTION:g} picks the "
            "food up there; allowed: a higher pressure, or another pose"
        )
    return found.succeeds * tolerance


def _scaled(found: Threshold, unit: float) -> tuple[float | None, float | None]:
    fails, succeeds = (None if place is None else place * unit for place in found)
    return fails, succeeds
