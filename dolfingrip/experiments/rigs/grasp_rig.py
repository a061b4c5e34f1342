"""The rig of a gripper that grasps food from a table and lifts it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from mpi4py import MPI

from dolfingrip.config import Config
from dolfingrip.experiments.protocol import (
    Stop,
    closing_starts_s,
    lift_starts_s,
    table_z_mm,
)
from dolfingrip.experiments.results.outcome import Ring, decided, judge
from dolfingrip.experiments.rigs.grasp_readings import GraspReadings
from dolfingrip.experiments.rigs.gripper import GraspSolution, GripperModel, build_gripper
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.files.run import GraspOutcome
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.policy import CorrectionPolicy, LagPolicy, NewtonPolicy, StepPolicy
from dolfingrip.mechanics.path.path import LoadPath, Observer
from dolfingrip.mechanics.path.policy import PathPolicy


class GraspRig(Rig):
    """Controls pressure and table, and reads fingers and food.

    Args:
        config: configuration that was asked for.
        gripper: model of the gripper.
        profile: takes the time of each phase.
        policy: numbers with which it is solved.
    """

    specimen_name: ClassVar = "gripper"

    def __init__(
        self,
        config: Config,
        gripper: GripperModel,
        profile: Profile,
        policy: GraspSolution = GraspSolution(),
    ) -> None:
        self._policy = policy
        solving = NewtonPolicy(
            steps=StepPolicy(shortest=policy.shortest, patience=policy.patience),
            lag=LagPolicy(tolerance=policy.lag_tolerance),
            correction=CorrectionPolicy(tolerance=policy.close),
            guess_residual_ratio=policy.guess_residual_ratio,
        )
        super().__init__(Newton(gripper.model, config.solver, profile, solving), gripper)
        self.readings = {}
        self._config = config
        self._gripper = gripper
        roots = [stand.origin_mm[:2] for stand in gripper.stands]
        self._ring = Ring(
            min(float(np.linalg.norm(root)) for root in roots),
            np.array([root / np.linalg.norm(root) for root in roots]),
        )
        self._reads = GraspReadings(
            gripper, lift_starts_s(config), policy.settling_s, closing_starts_s(config)
        )

    @classmethod
    def built(cls, config: Config, comm: MPI.Comm, profile: Profile) -> GraspRig:
        """The rig of a configuration's gripper.

        Raises:
            ConfigError: on every rank, one line.
        """
        with profile.phase("mesh and forms"):
            gripper = build_gripper(config, comm)
        return cls(config, gripper, profile)

    def longest(self) -> dict[str, float]:
        return {"time_s": self._config.gripper.step_s}

    def controls(self, stop: Stop) -> Mapping[str, float]:
        return {
            "pressure_kPa": stop.value,
            "time_s": self._policy.settling_s + stop.time_s,
            "table_z_mm": table_z_mm(self._config, stop.time_s),
        }

    def path(self, observers: Sequence[Observer]) -> LoadPath:
        return LoadPath(
            self.newton,
            self.longest(),
            observers=[*observers, self._reads],
            over=self.over,
            policy=PathPolicy(from_equilibrium=True, halves_first=True),
        )

    def read(self) -> dict[str, float]:
        model = self._gripper.model
        pressure = model.controls["pressure_kPa"].value
        time_s = model.time_s - self._policy.settling_s
        return {"time_s": time_s, "pressure_kPa": pressure, **self._reads.read()}

    def over(self) -> bool:
        """Return whether the food has left the fingers."""
        return decided(self._reads.moments, self._ring)

    def outcome(self, *, complete: bool) -> GraspOutcome | None:
        """The grasp's outcome; see :func:`~dolfingrip.experiments.results.outcome.judge`."""
        return judge(self._reads.moments, complete=complete, ring=self._ring)
