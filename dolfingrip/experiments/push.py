"""Stiffness of the pressurised finger against a load at its tip."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from dolfingrip.channels import ANGLE, PRESSURE
from dolfingrip.experiments.experiment import MPI, Config, Curve, Plot, Profile
from dolfingrip.experiments.finger_experiment import WholeFingerExperiment
from dolfingrip.experiments.rigs.tip_load import STIFFNESSES, dead_loads, stiffness

if TYPE_CHECKING:
    from dolfingrip.experiments.rigs.finger_rig import FingerRig


class Push(WholeFingerExperiment):
    """Stiffness of the free finger's tip against loads in x and y, pressurised.

    Example: dolfingrip push --pressure 100

    A dead load f is spread evenly over the tip face, Π −= f · ∫u dA / A, so that it works on the
    face's mean displacement ū. The stiffness follows from the tangent K at each pressure:
    1/(bᵀK⁻¹b) with b = ∂ū/∂u, the ratio of a very small load to the displacement that it causes.
    x lies in the plane of bending and y across it, so the whole finger is meshed.
    """

    name: ClassVar = "push"
    command: ClassVar = "push"
    title: ClassVar = "Stiffness at the tip"
    parts: ClassVar = ("finger",)
    columns: ClassVar = STIFFNESSES
    table: ClassVar = (PRESSURE, ANGLE, *STIFFNESSES)
    plot: ClassVar = Plot(
        "Stiffness at the tip (N/mm)",
        (
            Curve(STIFFNESSES[0].name, "x, in the plane of bending"),
            Curve(STIFFNESSES[1].name, "y, sideways"),
        ),
    )

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> FingerRig:
        rig = self._rig(config, comm, profile, adds=dead_loads)
        rig.further = stiffness(rig.newton)
        return rig
