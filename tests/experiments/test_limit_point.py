"""The thin-walled bellows of examples/: pressure control ends where volume control goes on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.mechanics.path.failure import FailureKind

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "thin_bellows.toml"
COARSE = ("mesh.size_mm=6",)
READINGS = ("experiment.max_volume_ratio=6", "experiment.step_volume_ratio=0.5")
LONG = ("experiment.max_pressure_kPa=300", "experiment.step_kPa=150", "solver.min_step_kPa=1")


def test_bellows_pass_their_greatest_pressure() -> None:
    """Under volume control the pressure rises, turns and falls; pressure control ends at the turn.

    The greatest pressure among readings is below that of the curve between them by no more than
    a parabola through the three highest has it, and pressure control stops within its smallest
    step of that.
    """
    inflated = run("bending", config.load(EXAMPLE, [*COARSE, *READINGS]))
    assert inflated.failure is None
    pressure = inflated.column("pressure_kPa")
    top = int(pressure.argmax())
    print(f"greatest of the readings {pressure[top]:.3f} kPa, last {pressure[-1]:.3f} kPa")
    assert 2 < top < len(pressure) - 2
    assert (np.diff(pressure[: top + 1]) > 0).all()
    assert (np.diff(pressure[top:]) < 0).all()
    a, b, c = np.polyfit([-1, 0, 1], pressure[top - 1 : top + 2], 2)
    greatest = c - b**2 / (4 * a)

    settings = config.load(EXAMPLE, [*COARSE, *LONG, "experiment.control=pressure"])
    stopped = run("bending", settings)
    assert stopped.failure is not None
    assert stopped.failure.kind is FailureKind.LIMIT_POINT
    last = stopped.failure.last_good["pressure_kPa"]
    print(f"greatest {greatest:.3f} kPa, pressure control stopped at {last:.3f} kPa")
    assert last == pytest.approx(greatest, abs=2 * settings.solver.min_step_kPa)
