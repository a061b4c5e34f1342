"""Natural frequencies of the pressurised finger."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from dolfingrip.channels import ANGLE, PRESSURE
from dolfingrip.experiments.experiment import (
    MPI,
    PRESSURE_OPTION,
    SUCTION_OPTION,
    Config,
    Curve,
    Plot,
    Profile,
)
from dolfingrip.experiments.finger_experiment import WholeFingerExperiment
from dolfingrip.experiments.rigs.natural_frequencies import FREQUENCIES, frequencies

if TYPE_CHECKING:
    from dolfingrip.experiments.rigs.finger_rig import FingerRig


class Vibration(WholeFingerExperiment):
    """Natural frequencies of the free finger, pressurised.

    They are those of small vibrations about the state at each pressure, which is held constant:
    K φ = ω² M φ with the tangent K and the consistent mass M. The finger vibrates in the plane of
    bending and across it, so the whole finger is meshed.
    """

    name: ClassVar = "vibration"
    command: ClassVar = "vibrate"
    title: ClassVar = "Natural frequencies"
    parts: ClassVar = ("finger",)
    columns: ClassVar = FREQUENCIES
    options: ClassVar = (PRESSURE_OPTION, SUCTION_OPTION)
    dynamic: ClassVar = False
    table: ClassVar = (PRESSURE, ANGLE, *FREQUENCIES)
    plot: ClassVar = Plot(
        "Natural frequency (Hz)",
        tuple(Curve(each.name, each.title) for each in FREQUENCIES),
    )
    lacking: ClassVar = "vibration across"

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> FingerRig:
        rig = self._rig(config, comm, profile)
        rig.further = frequencies(rig)
        return rig
