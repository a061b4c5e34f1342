"""Free bending: how far a pressurised finger turns its tip.

A finger of bellows has a thick base layer on one side. Pressure inside pushes the bellows apart,
the base layer hardly stretches, and so the finger bends towards it. At equilibrium the total
potential

    Π(u) = ∫ ψ(E(u)) dX − p V(u)

is stationary. V is the volume of the cavity. So along a path of equilibria the work of the pressure
∫ p dV is what the walls store, and the angle follows from the rotation of the tip's face.

    scripts/run python examples/free_bending.py

prints angle and cavity by pressure, and draws the curve to ``out/free_bending``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dolfingrip import config
from dolfingrip.config import NO_CHANGE, Change
from dolfingrip.experiments import Result, run

COARSE = {
    "mesh.edge_size_mm": 7,
}
"""5 % too stiff, but it takes seconds."""

KPA_MM3 = 1e-3
"""mJ of a kPa times a mm³."""


def bend(overrides: Change = NO_CHANGE, out: Path | None = None) -> Result:
    """The reference finger, to 100 kPa."""
    finger = config.load(overrides={**COARSE, "experiment.max_pressure_kPa": 100, **overrides})
    return run("bending", finger, out=out)


def work_mJ(result: Result) -> float:
    """Work of the pressure, ∫ p dV, by trapezoids between the readings."""
    pressure, volume = result.column("pressure_kPa"), result.column("cavity_volume_mm3")
    return float(KPA_MM3 * np.trapezoid(pressure, volume))


def main() -> Result:
    """Bend and print."""
    result = bend(out=Path("out/free_bending"))
    for row in result.rows:
        print(
            f"{row['pressure_kPa']:5.0f} kPa  {row['angle_deg']:6.2f}°  "
            f"{row['cavity_volume_mm3']:8.0f} mm³"
        )
    print(f"work of the pressure: {work_mJ(result):.1f} mJ")
    return result


if __name__ == "__main__":
    main()
