"""The least pressure that picks food up, and the friction that it tells of, by grasps.

Each grasp, by pressure and friction, is computed once.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign.policy import ESTIMATES, LARGEST_FRICTION
from dolfingrip.design.quantities.grasp import GRASP, NO_CLASS, outputs_of
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import Compute
from dolfingrip.jobs.job import ERROR, REFUSED
from dolfingrip.jobs.pool import Unfinished
from dolfingrip.sections.gripper import HIGHEST_KPA


@dataclass(frozen=True, slots=True)
class GraspTrial:
    """One grasp of a search.

    Attributes:
        pressure_kPa: highest pressure.
        friction: coefficient of fingers on food.
        picked_up: whether the food was; None where the grasp ended before that was decided.
        outcome: class of the grasp; ``failure: …`` where it ended before one was known.
        normal_N: sum of the fingers' normal forces before the lift; 0 where it ended early.
        weight_N: the food's.
        wall_s: time of the computation.
    """

    pressure_kPa: float
    friction: float
    picked_up: bool | None
    outcome: str
    normal_N: float
    weight_N: float
    wall_s: float

    @property
    def why(self) -> str:
        """Why its end is not known."""
        at = f"{self.pressure_kPa:g} kPa and μ = {self.friction:.4g}"
        return f"the grasp at {at} ended before that was decided ({self.outcome})"


class GraspTrials:
    """Grasps of one gripper and food by pressure and friction, each computed once.

    Args:
        base: configuration; its pressure and friction are those of each grasp.
        compute: computes requests, and keeps their answers.
        progress: called with each trial.
    """

    def __init__(
        self,
        base: Config,
        compute: Compute,
        progress: Callable[[GraspTrial], None] = lambda trial: None,
    ) -> None:
        self.base = base
        self._compute, self._progress = compute, progress
        self._known: dict[str, GraspTrial] = {}

    @property
    def made(self) -> list[GraspTrial]:
        """All trials so far, each once, in order."""
        return list(self._known.values())

    def at(self, pressure_kPa: float, friction: float) -> GraspTrial:
        """Return the grasp at a pressure and with a coefficient of friction.

        Args:
            pressure_kPa: highest pressure; a shorter one than a step is reached in one.
            friction: of fingers on food.

        Raises:
            ConfigError: where there is no such gripper or food.
            Unfinished: the machine did not let it come to an end, or the program has a fault,
                which others would meet, too.
        """
        pressure = round(pressure_kPa, 9)
        steps = {"step_kPa": min(self.base.experiment.step_kPa, pressure)}
        config = self.base.changed(
            experiment={"max_pressure_kPa": pressure, **steps},
            food={"friction": round(friction, 9)},
        )
        request = Request.of(GRASP, config)
        key = request.key
        if key not in self._known:
            (answer,) = self._compute([request])
            if answer.failure_class == REFUSED:
                raise ConfigError(answer.failure or "there is no such gripper")
            if answer.failure_class == ERROR:
                raise Unfinished(f"{answer.failure}; this is a fault of dolfingrip")
            self._known[key] = _trial(pressure_kPa, friction, answer)
            self._progress(self._known[key])
        return self._known[key]


def _trial(pressure_kPa: float, friction: float, answer: Answer) -> GraspTrial:
    outputs: dict[str, float] = {}
    outcome = f"failure: {answer.failure_class or NO_CLASS}"
    if answer.outcome is not None:
        outputs, outcome = outputs_of(answer), str(answer.outcome["kind"])
    return GraspTrial(
        pressure_kPa,
        friction,
        outputs["picked_up"] == 1.0 if outputs else None,
        outcome,
        outputs.get("normal_N", 0.0),
        outputs.get("weight_N", 0.0),
        answer.wall_s or 0.0,
    )


@dataclass(frozen=True, slots=True)
class Pickup:
    """The least pressure that picks up.

    Attributes:
        fails_kPa: highest pressure below that was tried and does not; None where there is none.
        least_kPa: that pressure; None where none up to the highest does.
        undecided: a grasp that counts as one that does not, and that ended before that was decided,
            so that the other numbers are not known; None where there is none.
    """

    fails_kPa: float | None
    least_kPa: float | None
    undecided: GraspTrial | None = None


def pickup_pressure(
    trials: GraspTrials,
    resolution_kPa: float,
    start_kPa: float,
    highest_kPa: float = HIGHEST_KPA,
) -> Pickup:
    """Find the least multiple of ``resolution_kPa`` at which the food is picked up.

    Each grasp tells how hard the fingers press. Where friction bears the weight, W = μ ΣN at the
    pressure that is sought; so the next grasp is there, by the normal forces of those before it.
    Then grasps on either side confirm it.

    Args:
        trials: grasps; the friction is that of their configuration.
        resolution_kPa: distance of pressures.
        start_kPa: pressure of the first grasp.
        highest_kPa: pressure above which none is tried.

    Returns:
        That pressure, and the highest one below that was tried.
    """
    friction = trials.base.food.friction
    highest = int(highest_kPa / resolution_kPa + 1e-9)

    def trial(place: int) -> GraspTrial:
        return trials.at(place * resolution_kPa, friction)

    place = min(max(round(start_kPa / resolution_kPa), 1), highest)
    made: dict[int, GraspTrial] = {}
    fails, succeeds = 0, highest + 1
    for _ in range(ESTIMATES):
        made[place] = trial(place)
        if made[place].picked_up:
            succeeds = min(succeeds, place)
        else:
            fails = max(fails, place)
        # not far beyond what grasps have shown
        guess = min(max(_bearing(made, friction), fails + 1), succeeds - 1, 2 * place, highest)
        if succeeds <= fails + 1 or guess in made:
            break
        place = guess
    low, high = max(fails, 1), min(succeeds, highest)
    threshold = least(lambda at: trial(at).picked_up is True, place, low, high)
    fails_kPa, least_kPa = (None if at is None else at * resolution_kPa for at in threshold)
    return Pickup(fails_kPa, least_kPa, _undecided(threshold, trial, trials.made))


def _undecided(
    threshold: Threshold, trial: Callable[[int], GraspTrial], made: Sequence[GraspTrial]
) -> GraspTrial | None:
    """A grasp that was counted as no success and ended before that was decided.

    Args:
        threshold: of places, which rests on the largest place that failed, or on all trials.
        trial: the one at a place.
        made: all trials of the search.
    """
    counted = [] if threshold.fails is None else [trial(threshold.fails)]
    counted = list(made) if threshold.succeeds is None else counted
    return next((grasp for grasp in counted if grasp.picked_up is None), None)


def _bearing(made: Mapping[int, GraspTrial], friction: float) -> int:
    """The place at which μ ΣN is the weight: ΣN straight between grasps, and beyond the last."""
    places = [0, *sorted(made)]
    normals = np.maximum.accumulate([0.0, *(made[place].normal_N for place in places[1:])])
    wanted = made[places[1]].weight_N / max(friction, 1e-9)
    if wanted <= normals[-1]:
        return round(float(np.interp(wanted, normals, places)))
    if normals[-1] <= 0:
        return 2 * places[-1]
    return round(min(places[-1] * wanted / normals[-1], 2 * places[-1]))


@dataclass(frozen=True, slots=True)
class FrictionFound:
    """The friction with which a pressure is the least that picks up.

    Attributes:
        low: least coefficient on the grid that picks up at that pressure.
        high: the largest that does not at the next lower one; between the two the least pressure
            that picks up is the measured one.
    """

    low: float
    high: float

    @property
    def friction(self) -> float:
        """The middle of the interval."""
        return (self.low + self.high) / 2


def friction(
    trials: GraspTrials, pickup_kPa: float, resolution_kPa: float, tolerance: float
) -> FrictionFound:
    """Find the friction for which ``pickup_kPa`` is the least pressure that picks up.

    μ*(p) is the least friction with which pressure p picks up; it falls as p grows. A pick-up
    pressure that was found in steps of the resolution r says that μ*(p) ≤ μ < μ*(p − r). Both are
    searched for from μ = W/ΣN on, with ΣN of one grasp.

    Args:
        trials: grasps.
        pickup_kPa: p.
        resolution_kPa: r.
        tolerance: of μ*.

    Returns:
        The interval that the friction lies in.

    Raises:
        ConfigError: one line, where no friction does at one of the two pressures.
        Unfinished: one line, where that is not known, as grasps ended before it was decided.
    """
    none = f"no friction up to {LARGEST_FRICTION:g} picks the food up"
    first = trials.at(pickup_kPa, trials.base.food.friction)
    at_pressure = _least_friction(trials, pickup_kPa, first, tolerance)
    if at_pressure is None:
        gripper = trials.base.gripper
        raise ConfigError(
            f"--pickup-pressure {pickup_kPa:g}: {none} there; allowed: a higher pressure, or other "
            f"fingers (--pose {gripper.pose}, gripper.clearance_mm = {gripper.clearance:g} mm)"
        )
    lower_kPa, place = pickup_kPa - resolution_kPa, round(at_pressure / tolerance)
    below = trials.at(lower_kPa, at_pressure)
    at_lower = _least_friction(trials, lower_kPa, below, tolerance, place)
    if at_lower is None:
        raise ConfigError(
            f"--resolution {resolution_kPa:g}: {none} one step below, at {lower_kPa:g} kPa, so "
            f"μ is {at_pressure:.3g} or any above; allowed: smaller steps"
        )
    return FrictionFound(at_pressure, max(at_lower - tolerance, at_pressure))


def _least_friction(
    trials: GraspTrials, pressure_kPa: float, first: GraspTrial, tolerance: float, low: int = 1
) -> float | None:
    """μ* at a pressure, on a grid of ``tolerance``; None where no friction picks up.

    Args:
        trials: grasps.
        pressure_kPa: the pressure.
        first: a grasp there.
        tolerance: distance of places.
        low: place that no answer is below, as of a higher pressure.
    """
    start = first.weight_N / first.normal_N if first.normal_N > 0 else first.friction

    def trial(place: int) -> GraspTrial:
        return trials.at(pressure_kPa, place * tolerance)

    threshold = least(
        lambda place: trial(place).picked_up is True,
        round(start / tolerance), low, round(LARGEST_FRICTION / tolerance),
    )  # fmt: skip
    made = [grasp for grasp in trials.made if grasp.pressure_kPa == pressure_kPa]
    if ended := _undecided(threshold, trial, made):
        raise Unfinished(f"μ is not known: {ended.why}")
    return None if threshold.succeeds is None else threshold.succeeds * tolerance


# -- the least place of a grid -------------------------------------------------------------------


class Threshold(NamedTuple):
    """Two neighbours on the grid, or a range's end.

    Attributes:
        fails: largest place that failed below; None where the lowest one allowed succeeds.
        succeeds: that least place; None where the highest one allowed fails.
    """

    fails: int | None
    succeeds: int | None


def least(passes: Callable[[int], bool], start: int, low: int, high: int) -> Threshold:
    """Find the least place of a grid at which a costly trial succeeds, from ``start`` on.

    Strides double until a success and a failure lie on either side; halving them leaves neighbours.
    So a start that is near costs two trials. Where success does not rise with the place, it is the
    boundary nearest to the start in the direction of the first trial.

    Args:
        passes: a trial at a place.
        start: of the search, moved to between ``low`` and ``high``.
        low: least place.
        high: largest place.

    Returns:
        That place, and the largest that failed below.
    """
    place = min(max(start, low), high)
    success = passes(place)
    ends = _last_alike(passes, place, low if success else high, success=success)
    fails, succeeds = reversed(ends) if success else ends
    if fails is not None and succeeds is not None:
        fails += bisect_left(range(fails + 1, succeeds), True, key=passes)
        succeeds = fails + 1
    return Threshold(fails, succeeds)


def _last_alike(
    passes: Callable[[int], bool], place: int, end: int, *, success: bool
) -> tuple[int, int | None]:
    """Go towards an end in strides that double, as long as trials come out as that at the place.

    Returns:
        The last place where they do, and the first one where they do not; None: there is none.
    """
    stride = 1 if end > place else -1
    while place != end:
        ahead = min(place + stride, end) if stride > 0 else max(place + stride, end)
        if passes(ahead) is not success:
            return place, ahead
        place, stride = ahead, 2 * stride
    return place, None
