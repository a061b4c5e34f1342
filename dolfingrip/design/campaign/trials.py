"""Grasps of one gripper and food by pressure and friction, each computed once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.quantities.grasp import GRASP, NO_CLASS, outputs_of
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import Compute
from dolfingrip.jobs.job import REFUSED


@dataclass(frozen=True, slots=True)
class GraspTrial:
    """One grasp of a search.

    Attributes:
        pressure_kPa: highest pressure.
        friction: coefficient of fingers on food.
        picked_up: whether the food was.
        outcome: class of the grasp; ``failure: …`` where it ended before one was known.
        normal_N: sum of the fingers' normal forces before the lift; 0 where it ended early.
        weight_N: the food's.
        wall_s: time of the computation.
    """

    pressure_kPa: float
    friction: float
    picked_up: bool
    outcome: str
    normal_N: float
    weight_N: float
    wall_s: float


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
            Unfinished: the machine did not let it come to an end.
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
        outputs.get("picked_up") == 1.0,
        outcome,
        outputs.get("normal_N", 0.0),
        outputs.get("weight_N", 0.0),
        answer.wall_s or 0.0,
    )
