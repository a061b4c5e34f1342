"""Grasps of one gripper and food by pressure and friction, each computed once.

Each grasp is an answer in a spool, so that a search that was killed goes on where it was.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign.plan import OBJECTIVE, Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.jobs.job import REFUSED, Answer
from dolfingrip.jobs.pool import Unfinished
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.work import work

PRESSURE: Final = "experiment.max_pressure_kPa"
FRICTION: Final = "food.friction"

WANTED: Final = ("picked_up", "normal_N", "weight_N", "outcome_s", "margin")


@dataclass(frozen=True, slots=True)
class GraspTrial:
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


class GraspTrials:
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
        progress: Callable[[GraspTrial], None] = lambda trial: None,
        objective: str = OBJECTIVE,
    ) -> None:
        self.base = base
        self._known: dict[str, GraspTrial] = {}
        self._spool = Spool((out / "spool").absolute())
        self._progress = progress
        self._objective = objective

    @property
    def made(self) -> list[GraspTrial]:
        """All trials so far, each once, in order."""
        return list(self._known.values())

    def at(self, pressure_kPa: float, friction: float) -> GraspTrial:
        """Return the grasp at a pressure and with a coefficient of friction.

        Args:
            pressure_kPa: of the fingers.
            friction: of fingers on food.

        Returns:
            The grasp, computed where it is not known.

        Raises:
            ConfigError: there is no such gripper.
            Unfinished: the machine did not let the grasp come to an end.
        """
        inputs: Inputs = {PRESSURE: round(pressure_kPa, 9), FRICTION: round(friction, 9)}
        step = min(self.base.experiment.step_kPa, pressure_kPa)
        base = self.base.changed(experiment={"step_kPa": step})
        plan = Plan(base, (PRESSURE, FRICTION), (inputs,), WANTED, self._objective)
        (job,) = plan.jobs()
        if job.key in self._known:
            return self._known[job.key]
        self._spool.folder.mkdir(parents=True, exist_ok=True)
        known = self._spool.read(job.key) is not None
        answer = work(job, self._spool.folder)
        if answer.status == "broken":
            raise Unfinished(
                f"{pressure_kPa:g} kPa, μ = {friction:.4g} could not be computed on this machine: "
                f"{answer.failure}; the same call goes on from there"
            )
        if answer.failure_class == REFUSED:
            self._spool.forget(job.key)
            raise ConfigError(answer.failure or "there is no such gripper")
        trial = _trial(pressure_kPa, friction, answer, computed=not known)
        self._known[job.key] = trial
        self._progress(trial)
        return trial


def _trial(pressure_kPa: float, friction: float, answer: Answer, *, computed: bool) -> GraspTrial:
    result: dict[str, Any] = answer.result or {"outputs": {}, "curve": {}}
    outputs = result["outputs"]
    outcome = result["curve"].get("outcome") or f"failure: {answer.failure_class}"
    return GraspTrial(
        pressure_kPa,
        friction,
        outputs.get("picked_up") == 1.0,
        str(outcome),
        float(outputs.get("normal_N", 0.0)),
        float(outputs.get("weight_N", 0.0)),
        computed,
        answer.wall_s or 0.0,
    )
