"""Three fingers grasp food from a table and lift it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Final

from dolfingrip.channels import CHANNELS, PRESSURE, TIME
from dolfingrip.experiments.experiment import (
    DYNAMIC_OPTION,
    MPI,
    PRESSURE_OPTION,
    SUCTION_OPTION,
    Config,
    Curve,
    Experiment,
    Option,
    Plot,
    Profile,
    Readings,
    Rig,
)
from dolfingrip.experiments.finger_experiment import notes
from dolfingrip.experiments.protocol import Stop, grasp_stops, lift_starts_s
from dolfingrip.sections.errors import ConfigError

COARSE_MM: Final = 8.4
"""Size of the elements of the coarse preset, inside and at edges. It is half of a chamber's width,
so that a whole finger is meshed as half a finger and its mirror image. It bends 2 % less than the
default mesh. With 7 mm it had a fifth more elements, none of them with a side on the plane of
symmetry, and bent 3.5 % less. Fingers with thick walls stay graded to their edges."""

LEAST_STEP: Final = 0.004
"""Shortest step, as a part of the longest one. A sausage that slips out of three curled fingers
needs steps of 0.6 ms: with 0.02 its grasp ended there before its class was decided."""

DYNAMIC_S: Final = 0.02
"""Step in time that :data:`LEAST_STEP` is a part of where fingers have inertia."""

DYNAMIC_STEP_S: Final = 0.002
"""Usual step in time where fingers have inertia; it serves the time left alone."""

MOST_ITERATIONS: Final = 20
"""Newton iterations after which a step is halved; it is not solved in another way before."""

TIME_LIMIT_S: Final = 7200.0
"""Time limit of a grasp if none is configured; a grasp that takes longer ends as a failure."""

WAIT_EFFORT: Final = 0.25
"""Cost of a step in a wait, by that of a step while fingers are pressurised. Like
:data:`LIFT_EFFORT` it serves the time left alone; both are of a cube on the coarse preset."""

LIFT_EFFORT: Final = 2.5
"""Cost of a step in the lift, by the same."""

RTOL: Final = 1e-5
"""Relative tolerance of the residual: 1e-5 of the force that a step's change of pressure exerts is
a thousandth of the food's weight."""


class Grasp(Experiment):
    """Grasp food from a table with three fingers, and lift it.

    Example: dolfingrip grasp --food cube --pose pinch --pressure 150

    With suction (``experiment.min_pressure_kPa``) the fingers open before they approach the food.
    The gripper stands still and the table moves. Fingers are quasi-static, or have inertia from the
    lift on (``experiment.dynamic``); the food is rigid and has inertia.
    Friction on fingers and table has a memory.
    """

    name: ClassVar = "grasp"
    command: ClassVar = "grasp"
    title: ClassVar = "Grasp"
    parts: ClassVar = ("gripper",)
    does_without: ClassVar = (
        *Experiment.does_without, "material.elongation_at_break", "experiment.snaps",
        "experiment.unload", "experiment.cycles", "experiment.rate_kPa_per_s",
        "experiment.hold_s", "experiment.rest_s", "experiment.hold_readings",
        "experiment.max_volume_ratio", "experiment.step_volume_ratio",
    )  # fmt: skip
    table: ClassVar = (
        PRESSURE,
        replace(TIME, form=".2f"),
        CHANNELS["angle_A_deg"].called("Thumb angle"),
        CHANNELS["angle_B_deg"].called("Finger angle"),
        CHANNELS["normal_A_N"].called("Thumb force"),
        CHANNELS["normal_B_N"].called("Finger force"),
        CHANNELS["table_N"],
        CHANNELS["object_height_mm"],
        CHANNELS["slip_mm"],
    )
    plot: ClassVar = Plot(
        "Normal force (N)",
        (
            Curve("normal_A_N", "thumb A"),
            Curve("normal_B_N", "finger B"),
            Curve("normal_C_N", "finger C"),
            Curve("table_N", "table"),
        ),
        over=TIME,
    )
    options: ClassVar = (
        Option("--food", str, None, "Food that is grasped.", "food.kind"),
        Option("--pose", str, None, "How fingers are turned.", "gripper.pose"),
        PRESSURE_OPTION,
        SUCTION_OPTION,
        DYNAMIC_OPTION,
        Option("--friction", float, None, "Friction of fingers on food.", "food.friction"),
        Option("--preset", str, None, "Mesh of the fingers.", "gripper.preset"),
    )
    protocol: ClassVar = False
    drawable: ClassVar = False
    measured: ClassVar = False
    gradients: ClassVar = False
    dynamic: ClassVar = True
    pictures: ClassVar = "gripper"

    def settings(self, config: Config) -> Config:
        config.cavity.refuse_own("a grasp")
        config.release.refuse("a grasp")
        config.base.refuse("a grasp")
        if config.supply is not None and config.supply.source == "syringe":
            raise ConfigError('supply.source = "syringe": a grasp: allowed: another source')
        dynamic, gripper = config.experiment.dynamic, config.gripper
        if dynamic and gripper.lift_acceleration_m_s2 is None:
            raise ConfigError(
                "gripper.lift_acceleration_m_s2: none; allowed with experiment.dynamic = true: "
                "above 0 to 100 m/s²"
            )
        least = LEAST_STEP * min(DYNAMIC_S / gripper.step_s if dynamic else 1.0, 1.0)
        solver = {
            "time_limit_s": config.solver.time_limit_s or TIME_LIMIT_S,
            "max_iterations": min(config.solver.max_iterations, MOST_ITERATIONS),
            "rtol": max(config.solver.rtol, RTOL),
            "min_step_kPa": max(
                0.0 if dynamic else config.solver.min_step_kPa, least * config.solver.max_step_kPa
            ),
        }
        mesh: dict[str, Any] = {"half": False}
        sized = config.mesh.size_mm is not None or config.mesh.edge_size_mm is not None
        if config.mesh.file is not None and config.gripper.preset == "coarse":
            words = 'a size of elements; allowed: "default" with mesh.file'
            raise ConfigError(f'gripper.preset = "coarse": {words}')
        if config.gripper.preset == "coarse" and not sized:
            mesh["size_mm"] = COARSE_MM
            if config.geometry.thin:
                mesh["edge_size_mm"] = COARSE_MM
        return config.changed(mesh=mesh, solver=solver, gravity={"acceleration_m_s2": 0.0})

    def schedule(self, config: Config) -> Sequence[Stop]:
        return grasp_stops(config)

    def efforts(self, config: Config) -> list[float]:
        """The steps to each reading, those of the lift and of waits by their cost."""
        waits = dict.fromkeys(("hold", "approach"), WAIT_EFFORT)
        by_branch = {**waits, "lift": LIFT_EFFORT}
        stops, longest_s = self.schedule(config), config.gripper.step_s
        lifted_s = lift_starts_s(config) if config.experiment.dynamic else math.inf
        ways = [after.time_s - before.time_s for before, after in itertools.pairwise(stops)]
        return [
            1.0,
            *(
                math.ceil(way_s / (DYNAMIC_STEP_S if stop.time_s > lifted_s else longest_s))
                * by_branch.get(stop.branch, 1.0)
                for way_s, stop in zip(ways, stops[1:], strict=True)
            ),
        ]

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        from dolfingrip.experiments.rigs.grasp_rig import GraspRig

        return GraspRig.built(config, comm, profile)

    def setup(self, config: Config) -> dict[str, Any]:
        return {
            **config.drawn(),
            "gripper": config.gripper.model_dump(exclude_defaults=True),
            "food": config.food.model_dump(mode="json", exclude_none=True),
        }

    def notes(self, config: Config) -> list[str]:
        return notes(config)

    def conclude(self, result: Readings, rig: Rig) -> None:
        from dolfingrip.experiments.rigs.grasp_rig import GraspRig

        assert isinstance(rig, GraspRig)
        result.outcome = rig.outcome(complete=result.failure is None and not rig.over())

    def remarks(self, result: Readings) -> list[str]:
        if result.outcome is None:
            return []
        return [f"{result.outcome.kind}: {result.outcome.sentence}"]
