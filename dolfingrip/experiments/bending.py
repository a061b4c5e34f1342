"""Free bending."""

from __future__ import annotations

from typing import ClassVar

from dolfingrip.channels import ANGLE, CHORD_ANGLE, PRESSURE, readings
from dolfingrip.experiments.experiment import Curve, Plot
from dolfingrip.experiments.finger_experiment import FingerExperiment


class Bending(FingerExperiment):
    """Bend the finger freely: the tip's angle against pressure.

    Example: dolfingrip bend --pressure 200 --render 0,200
    """

    name: ClassVar = "bending"
    command: ClassVar = "bend"
    title: ClassVar = "Free bending"
    parts: ClassVar = ("finger",)
    mesh_check: ClassVar = True
    table: ClassVar = (PRESSURE, *readings("finger"))
    plot: ClassVar = Plot(
        "Bending angle (°)",
        (Curve(ANGLE.name, "tip face"), Curve(CHORD_ANGLE.name, "chord, clamp to tip")),
    )
