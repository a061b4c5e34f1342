"""A short finger that is filled through a valve, from a tank and by a syringe."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI
from support import small
from support.command import run_command

from dolfingrip.channels import AMBIENT_KPA
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign.objective import check_quantities
from dolfingrip.design.quantities.quantity import AskedDesign
from dolfingrip.experiments import run
from dolfingrip.experiments.derivatives.gradients import by_adjoint
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.result import Result
from dolfingrip.mechanics.model.pneumatics import Restriction

STEP = (
    "protocol.time_s=[0,0,0.1,0.3,3]",
    "protocol.pressure_kPa=[0,50,50,50,50]",
)
"""A sudden pressure of 50 kPa, and a wait until the finger has it."""


FEW = ("mesh.size_mm=12", "mesh.edge_size_mm=12")
"""Elements of a finger whose air alone is looked at, in many steps in time."""

SYRINGE = ("supply.source=syringe", "experiment.control=volume")
LET_GO = ("release.load_x_N=0.1", "experiment.dynamic=true")
"""A tip that is held before 0 s, and let go."""


def bent(settings: Config) -> Result:
    """The run, which comes to its end."""
    result = run("bending", settings, comm=MPI.COMM_SELF)
    assert result.failure is None
    return result


def test_follows_a_sudden_pressure_through_a_valve() -> None:
    """Air is kept to 1e-6, and the gauge in the tube runs ahead.

    Where the valve is choked, it lets in C p₁ of free air: at first for 0.1 s at most, as unchoked
    flow is less.
    """
    valve = 0.01
    filled = bent(small.short(*STEP, f"supply.valve_dm3_per_s_bar={valve}"))
    time_s, inside = filled.column("time_s"), filled.column("cavity_pressure_kPa")
    print(f"cavity {inside} kPa at {time_s} s, errors {filled.column('air_error')}")
    assert np.abs(filled.column("air_error")).max() < 1e-6
    assert (np.diff(inside[1:]) > 0).all()
    assert inside[1] == pytest.approx(0, abs=1e-6)
    assert (filled.column("tube_kPa")[2:4] > inside[2:4]).all()
    choked_mg = 1.185 * valve * 1e3 * (AMBIENT_KPA + 50) / 100 * 0.1
    came_mg = filled.column("air_mg")[2] - filled.column("air_mg")[1]
    assert 0.5 * choked_mg < came_mg <= choked_mg


@pytest.mark.slow
def test_steps_follow_the_allowed_error() -> None:
    """A tenth of the allowed error changes the pressure by no more than a few of the larger.

    The finger ends where pressure control does.
    """
    valve = (*FEW, *STEP, "supply.valve_dm3_per_s_bar=0.01")
    coarse, fine = (bent(small.short(*valve, f"supply.error_kPa={e}")) for e in (0.1, 0.01))
    plain = bent(small.short(*FEW, "experiment.step_kPa=50"))
    ends = (coarse.column("angle_deg")[-1], plain.column("angle_deg")[-1])
    assert ends[0] == pytest.approx(ends[1], rel=1e-4)
    off = coarse.column("cavity_pressure_kPa") - fine.column("cavity_pressure_kPa")
    print(f"differences {off} kPa")
    assert 1e-4 < np.abs(off).max() < 0.5


@pytest.mark.slow
def test_a_leak_empties_a_tank() -> None:
    """A leak's loss comes from the tank, and the balance holds, up and down again.

    While the finger waits, its valve is open as far as ISO 6358 needs to let in what leaks. That
    leaves out how much the tank's air has cooled, some per cent of 0.08 kPa.
    """
    leaking = bent(
        small.short(
            *FEW, "experiment.unload=true", "experiment.step_kPa=25", "experiment.hold_s=1",
            "supply.source=tank", "supply.tank_cm3=20", "supply.tank_kPa=150",
            "supply.leak_mm=0.1", "supply.exponent=1.2", "supply.gauge_part=0",
        )
    )  # fmt: skip
    tank, inside = leaking.column("source_kPa"), leaking.column("cavity_pressure_kPa")
    print(f"tank {tank} kPa, cavity {inside} kPa")
    assert (np.diff(tank) <= 1e-9).all()
    assert np.abs(leaking.column("air_error")).max() < 1e-6
    held = leaking.column("pressure_kPa") == 50
    leak, valve = Restriction.orifice(0.1), Restriction(1e6, 0.3)
    pressures = (inside[held][1:] + AMBIENT_KPA) / 1e3, (tank[held][1:] + AMBIENT_KPA) / 1e3
    lost = [leak.flow(p, AMBIENT_KPA / 1e3) for p in pressures[0]]
    opened = [valve.flow(source, p) for p, source in zip(*pressures, strict=True)]
    lacking = 10 * np.array(lost) / opened  # of the band of 10 kPa, so that the valve lets in both
    np.testing.assert_allclose(50 - inside[held][1:], lacking, atol=0.01)
    assert leaking.column("air_mg")[-1] < leaking.column("air_mg")[0]


def test_a_syringe_compresses_its_air() -> None:
    """p (V_finger + V_tube + V_barrel) stays, and more is displaced than the finger grows."""
    result = bent(
        small.short(
            "experiment.control=volume", "experiment.max_volume_ratio=3",
            "experiment.step_volume_ratio=1", "supply.source=syringe", "supply.syringe_cm3=20",
        )
    )  # fmt: skip
    volume, pressure = (result.column(n) for n in ("cavity_volume_mm3", "cavity_pressure_kPa"))
    displaced = volume[0] * np.array([0, 1, 2])
    air = (pressure + AMBIENT_KPA) * (volume + 5e3 + 20e3 - displaced)
    np.testing.assert_allclose(air, air[0], rtol=1e-6)
    assert (np.diff(volume) < 0.2 * np.diff(displaced)).all()
    assert np.abs(result.column("air_error")).max() < 1e-6


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (("supply.board=nobody's",), "supply.board = .*allowed: programmable-air"),
        (("supply.source=pump",), "supply.pump_kPa = none: allowed: two pressures"),
        (("supply.source=syringe",), 'experiment.control = "pressure": allowed with supply.source'),
        (("supply.source=tank", "supply.tank_kPa=40"), "supply.tank_kPa = 40: .* from 50 kPa on"),
        (("supply.valve_b=1",), r"supply.valve_b = 1.*"),
    ],
)
def test_refusals(overrides: tuple[str, ...], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        small.short(*overrides)


def test_a_board_gives_the_numbers_that_are_not_given() -> None:
    supply = small.short("supply.board=programmable-air", "supply.tube_cm3=9").supply
    assert supply is not None
    assert (supply.source, supply.tube_cm3, supply.pump_kPa) == ("pump", 9.0, (0.0, 50.0))


def test_experiments_that_prescribe_the_pressure_refuse_a_supply() -> None:
    for name in ("vibration", "push"):
        with pytest.raises(ConfigError, match="supply = a table: the pressure is prescribed here"):
            run(name, small.short("supply.source=ideal"), comm=MPI.COMM_SELF)


@pytest.mark.parametrize(
    ("source", "wanted", "said"),
    [
        ("syringe", {"gradients": ()}, 'supply.source = "syringe": allowed: another source with'),
        ("syringe", {"bands": {}}, 'supply.source = "syringe": allowed: another source with'),
        ("ideal", {"places": (Place("pressure_kPa", 20.0),)}, "allowed: without readings at a pla"),
    ],
)
def test_what_a_supply_refuses(source: str, wanted: dict[str, Any], said: str) -> None:
    """Before anything is computed; a coupon, which feels no supply, does not mind."""
    control = "volume" if source == "syringe" else "pressure"
    supplied = small.short(f"supply.source={source}", f"experiment.control={control}")
    with pytest.raises(ConfigError, match=said):
        Request.of("bending", supplied, **wanted)
    assert Request.of("coupon", supplied, **wanted).config.supply is not None


@pytest.mark.parametrize("key", ["supply.source=ideal", "experiment.dynamic=true"])
def test_designs_without_derivatives_may_have_a_supply_or_inertia(key: str) -> None:
    """A plain campaign derives by itself only where that is possible."""
    check_quantities(["angle_deg"], AskedDesign(small.short(key)))
    assert not by_adjoint(small.short(key))
    assert by_adjoint(small.short())


def test_derivatives_refuse_a_supply_to_a_finger_that_hangs() -> None:
    hanging = small.short("supply.source=ideal", "gravity.acceleration_m_s2=9.81")
    with pytest.raises(ConfigError, match="supply = a table: allowed: without gravity and"):
        run("bending", hanging, comm=MPI.COMM_SELF, gradients=["material.mu_MPa"])


@pytest.mark.parametrize(
    ("command", "further", "settings", "said"),
    [
        ("grasp", (), SYRINGE, "supply.source"),
        ("robot", (), SYRINGE, "supply.source"),
        ("push", (), ("supply.source=ideal",), "supply = a table"),
        ("vibrate", (), ("supply.source=ideal",), "supply = a table"),
        ("bend", ("--gradients",), SYRINGE, "supply.source"),
        ("coupon", (), ("supply.source=ideal",), "supply = a table"),
        ("doe", ("--gradients",), SYRINGE, "supply.source"),
        ("doe", ("--quantity", "pickup_margin"), SYRINGE, "supply.source"),
        ("export", ("{out}/a.inp",), ("supply.source=ideal",), "no supply of air"),
        ("export", ("{out}/a.inp",), LET_GO, "release.load_x_N"),
        ("robot", (), LET_GO, "release.load_x_N"),
        ("vibrate", (), LET_GO, "experiment.dynamic"),
        ("grasp", (), LET_GO, "release.load_x_N"),
    ],
)
def test_commands_refuse_what_they_would_not_follow(
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    command: str,
    further: tuple[str, ...],
    settings: tuple[str, ...],
    said: str,
) -> None:
    """In one line, with exit code 2."""
    options = [text for key in settings for text in ("--set", key)]
    files = [text.format(out=tmp_path) for text in further]
    folder = () if command == "export" else ("--out", tmp_path / "out")
    assert run_command(command, *files, *options, *folder) == 2
    error = capfd.readouterr().err
    assert said in error
    assert error.count("\n") == 1
