"""The thin-walled bellows of examples/: pressure control ends where volume control goes on."""

from __future__ import annotations

import numpy as np
import pytest
from support.example import EXAMPLES

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.mechanics.path.failure import FailureKind
from dolfingrip.sections.tables import assignments

EXAMPLE = EXAMPLES / "thin_bellows.toml"
COARSE = ("mesh.size_mm=14",)
READINGS = ("experiment.max_volume_ratio=6", "experiment.step_volume_ratio=0.5")
LONG = ("experiment.max_pressure_kPa=300", "experiment.step_kPa=150", "solver.min_step_kPa=1")


@pytest.mark.slow
def test_bellows_pass_their_greatest_pressure() -> None:
    """Under volume control the pressure rises, turns and falls; pressure control ends at the turn.

    The greatest pressure among readings is below that of the curve between them by no more than
    a parabola through the three highest has it, and pressure control stops within its smallest
    step of that.
    """
    inflated = run("bending", config.load(EXAMPLE, assignments([*COARSE, *READINGS])))
    assert inflated.failure is None
    pressure = inflated.column("pressure_kPa")
    top = int(pressure.argmax())
    print(f"greatest of the readings {pressure[top]:.3f} kPa, last {pressure[-1]:.3f} kPa")
    assert 2 < top < len(pressure) - 2
    assert (np.diff(pressure[: top + 1]) > 0).all()
    assert (np.diff(pressure[top:]) < 0).all()
    a, b, c = np.polyfit([-1, 0, 1], pressure[top - 1 : top + 2], 2)
    greatest = c - b**2 / (4 * a)

    settings = config.load(EXAMPLE, assignments([*COARSE, *LONG, "experiment.control=pressure"]))
    stopped = run("bending", settings)
    assert stopped.failure is not None
    assert stopped.failure.kind is FailureKind.LIMIT_POINT
    said = stopped.failure.sentence()
    assert said.endswith("as large as at rest; it can grow on with --set experiment.control=auto")
    said_first, last_row = repr(stopped).splitlines()
    assert said_first == f"<Result of bending: {len(stopped.rows)} readings, {said}>"
    assert "last row" in last_row
    last = stopped.failure.last_good["pressure_kPa"]
    print(f"greatest {greatest:.3f} kPa, pressure control stopped at {last:.3f} kPa")
    assert last == pytest.approx(greatest, abs=2 * settings.solver.min_step_kPa)

    at_once = run("bending", settings.changed(experiment={"snaps": False}))
    assert at_once.failure is not None
    assert at_once.failure.kind is FailureKind.LIMIT_POINT
    assert at_once.failure.last_good["pressure_kPa"] <= last
    np.testing.assert_allclose(at_once.column("angle_deg"), stopped.column("angle_deg"), rtol=1e-9)
    behind_a_gauge = settings.changed(
        experiment={"snaps": False}, extensions={"pressure_gain": {"gain": 1.0}}
    )
    stages = run("bending", behind_a_gauge)
    assert stages.failure is not None
    assert stages.failure.last_good["pressure_kPa"] == at_once.failure.last_good["pressure_kPa"]
    np.testing.assert_allclose(stages.column("angle_deg"), at_once.column("angle_deg"), rtol=1e-9)

    many, few = (each.facts.newton.iterations for each in (stopped, at_once))
    print(f"{many} iterations, {few} without a search for a state beyond")
    assert max(many, few) < 120  # neither halves its steps on and on


@pytest.mark.slow
def test_pressure_control_goes_on_by_volume() -> None:
    """With control = "auto" the pressure rises in steps, turns and falls, in one run."""
    asked = ("experiment.control=auto", "experiment.max_pressure_kPa=300")
    result = run(
        "bending",
        config.load(EXAMPLE, assignments([*COARSE, *READINGS, *asked, "experiment.step_kPa=75"])),
    )
    assert result.failure is None, result.failure
    pressure, volume = result.column("pressure_kPa"), result.column("cavity_volume_mm3")
    print("pressure", pressure, "volume", volume / volume[0])
    np.testing.assert_allclose(pressure[:3], [0, 75, 150])
    top = int(pressure.argmax())
    assert 2 < top < len(pressure) - 1
    assert (np.diff(pressure[top:]) < 0).all()
    assert (np.diff(volume) > 0).all()
    assert volume[-1] / volume[0] == pytest.approx(6.0, rel=1e-9)


def test_a_volume_that_cannot_be_reached_is_a_classified_failure() -> None:
    """Newton's method with one iteration reaches neither a pressure nor a volume."""
    hopeless = ("experiment.control=auto", "solver.max_iterations=1", "solver.min_step_kPa=5")
    result = run("bending", config.load(EXAMPLE, assignments([*COARSE, *READINGS, *hopeless])))
    assert result.failure is not None
    assert result.failure.kind in (FailureKind.ITERATION_LIMIT, FailureKind.LIMIT_POINT)
    assert "cavity_volume_mm3" in result.failure.last_good
    assert "mm3" in result.failure.sentence()
    assert len(result.rows) == 1
