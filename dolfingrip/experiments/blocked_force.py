"""Blocked force."""

from __future__ import annotations

from typing import Any, ClassVar

from dolfingrip.channels import FORCE, PRESSURE, readings
from dolfingrip.experiments.experiment import Config, Curve, Plot, Readings, Rig
from dolfingrip.experiments.finger_experiment import FingerExperiment

BLOCKED = FORCE.called("Blocked force")


class BlockedForce(FingerExperiment):
    """Press the tip on the force sensor's plate: blocked force against pressure.

    Example: dolfingrip force --set plate.gap_mm=5
    """

    name: ClassVar = "blocked_force"
    command: ClassVar = "force"
    title: ClassVar = "Blocked force"
    parts: ClassVar = ("plate", "finger")
    mesh_check: ClassVar = True
    table: ClassVar = (PRESSURE, *(BLOCKED if c is FORCE else c for c in readings("plate")))
    plot: ClassVar = Plot(BLOCKED.label, (Curve(FORCE.name, "simulation"),))

    def setup(self, config: Config) -> dict[str, Any]:
        plate = config.plate.model_dump(include={"gap_mm", "tilt_deg"})
        return {**super().setup(config), "plate": plate}

    def conclude(self, result: Readings, rig: Rig) -> None:
        """Find the turning point of the loading branch."""
        from dolfingrip.experiments.results import turning_point

        result.plate = rig.plate
        pressure = result.column(PRESSURE.name)
        branch = [row["branch"] for row in result.rows]
        loading = [i for i, name in enumerate(branch) if name == "loading" and pressure[i] >= 0]
        result.turning_point = turning_point.find(
            pressure[loading],
            result.column(FORCE.name)[loading],
            [rig.gaps_mm[i] for i in loading],
            result.config.contact.barrier_mm,
        )

    def remarks(self, result: Readings) -> list[str]:
        turning = result.turning_point
        return [*([] if turning is None else [turning.sentence()]), *super().remarks(result)]
