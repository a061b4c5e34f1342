"""Free bending."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from dolfingrip.config import Config
from dolfingrip.experiments.description import PRESSURE, Column, Curve, Plot
from dolfingrip.experiments.finger_experiment import FingerExperiment

if TYPE_CHECKING:
    from mpi4py import MPI

    from dolfingrip.experiments.rigs.rig import Rig
    from dolfingrip.mechanics.model.profile import Profile


class Bending(FingerExperiment):
    """Bend the finger freely: the tip's angle against pressure."""

    name: ClassVar = "bending"
    command: ClassVar = "bend"
    title: ClassVar = "Free bending"
    table: ClassVar = (
        PRESSURE,
        Column("angle_deg", "Angle (°)", ".1f"),
        Column("chord_angle_deg", "Chord angle (°)", ".1f"),
        Column("tip_x_mm", "Tip x (mm)", ".2f"),
        Column("tip_z_mm", "Tip z (mm)", ".2f"),
    )
    plot: ClassVar = Plot(
        "Bending angle (°)",
        (Curve("angle_deg", "tip face"), Curve("chord_angle_deg", "chord, clamp to tip")),
    )

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        from dolfingrip.experiments.rigs.finger_rig import FingerRig

        return FingerRig.built(config, comm, profile, plate=False)
