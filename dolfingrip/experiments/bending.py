"""Free bending."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from dolfingrip.channels import ANGLE, CHORD_ANGLE, PRESSURE, readings
from dolfingrip.experiments.description import Curve, Plot
from dolfingrip.experiments.finger_experiment import FingerExperiment

if TYPE_CHECKING:
    from mpi4py import MPI

    from dolfingrip.config import Config
    from dolfingrip.experiments.rigs.rig import Rig
    from dolfingrip.mechanics.model.profile import Profile


class Bending(FingerExperiment):
    """Bend the finger freely: the tip's angle against pressure."""

    name: ClassVar = "bending"
    command: ClassVar = "bend"
    title: ClassVar = "Free bending"
    parts: ClassVar = ("finger",)
    table: ClassVar = (PRESSURE, *readings("finger"))
    plot: ClassVar = Plot(
        "Bending angle (°)",
        (Curve(ANGLE.name, "tip face"), Curve(CHORD_ANGLE.name, "chord, clamp to tip")),
    )

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        from dolfingrip.experiments.rigs.finger_rig import FingerRig

        return FingerRig.built(config, comm, profile, plate=False, made_for=self.made_for)
