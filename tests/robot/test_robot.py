"""``dolfingrip robot`` on a short finger of two bellows, and its files in MuJoCo.

References are the runs of finite elements that the command makes, and the chain itself: MuJoCo's
rest is the chain's equilibrium.
"""

from __future__ import annotations

import importlib.util
import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from support.command import run_command
from support.small import SHORT, short

from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.files.result_file import ResultFileError
from dolfingrip.files.robot import Accuracy, RobotFile
from dolfingrip.meshes.measures import moments
from dolfingrip.report.page import sources
from dolfingrip.robot import build, mjcf, runs
from dolfingrip.robot.chain import COORDINATES
from dolfingrip.robot.control import RED
from dolfingrip.robot.fit import MOST_JOINTS
from dolfingrip.robot.links import skin, whole_solid
from dolfingrip.robot.robot import Robot
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.supply import AirLine

mujoco = pytest.importorskip("mujoco")

ASKED = (*SHORT, "experiment.min_pressure_kPa=-20")
OPTIONS = [text for each in ASKED for text in ("--set", each)]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The files of a short finger."""
    from distributed import LocalCluster

    from dolfingrip.jobs import pool
    from dolfingrip.jobs.cluster import Where, connected

    out = tmp_path_factory.mktemp("robot")
    with (
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
        ) as cluster,
        pytest.MonkeyPatch.context() as patch,
    ):
        here = Where(scheduler=cluster.scheduler_address)
        patch.setattr(pool, "connected", lambda where: connected(here))
        assert run_command("robot", "--out", out, *OPTIONS) == 0
        yield out


@pytest.fixture(scope="module")
def robot(made: Path) -> Robot:
    return Robot.read(made)


@pytest.mark.slow
def test_errors_at_states_that_were_not_fitted(robot: Robot) -> None:
    """As the targets for the default finger are: 1.5°, 1 mm, 4 % of force, 7 % of stiffness."""
    weightless = [each for each in robot.file.comparisons if not any(each.gravity_m_s2)]
    found = {(each.quantity, each.gap_mm is None): each for each in weightless}
    assert found["angle", True].largest < 1.5
    assert found["tip path", True].rms < 1.0
    assert found["force on the plate", False].relative < 0.04
    assert found["stiffness of the tip, x", True].relative < 0.07
    assert found["stiffness of the tip, y", True].relative < 0.07
    free = found["angle", True]
    assert free.finite_elements[-1] > 3.0
    assert free.finite_elements[0] < -1.0
    assert robot.file.valid.pressure_kPa == pytest.approx((-20.0, 50.0))
    fitted = np.linspace(0, 50, 6)
    assert not set(np.round(free.pressure_kPa, 6)) & set(np.round(fitted, 6))
    hanging = [each for each in robot.file.comparisons if any(each.gravity_m_s2)]
    assert [each.title for each in hanging] == [
        "angle, hanging, with its weight", "tip path, hanging, with its weight",
    ]  # fmt: skip
    assert hanging[0].gravity_m_s2 == (0.0, 0.0, 9.81)
    assert hanging[0].largest < 1.5
    assert hanging[1].rms < 1.0


@pytest.mark.slow
def test_the_file_is_what_the_command_found(robot: Robot, made: Path) -> None:
    mass = sum(link.mass_kg for link in robot.file.links)
    volume, moment = moments(whole_solid(short()))
    assert mass == pytest.approx(1190e-9 * volume)
    centre = sum(link.mass_kg * np.array(link.centre_mm) for link in robot.file.links) / mass
    assert centre == pytest.approx(moment / volume, abs=1e-6)
    data = json.loads((made / "robot.json").read_text(encoding="utf-8"))
    assert data["schema_version"] == 2
    data["schema_version"] = 99
    (made / "other.json").write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(ResultFileError, match="schema_version = 99"):
        RobotFile.read(made / "other.json")


def settled(
    folder: Path, inputs: dict[str, float], time_s: float = 1.0, gravity_m_s2: Any = (0, 0, 0)
) -> Any:
    """Let a finger come to rest in gravity along its own axes."""
    model = mujoco.MjModel.from_xml_path(str(folder / "finger.xml"))
    model.opt.gravity[:] = np.array(gravity_m_s2) * [1, -1, -1]
    data = mujoco.MjData(model)
    for name, value in inputs.items():
        data.actuator(name).ctrl[0] = value
    while data.time < time_s:
        mujoco.mj_step(model, data)
    return data


@pytest.mark.slow
def test_shapes_of_the_free_finger(robot: Robot) -> None:
    """The last link turns as the tip does, and lies where the finite elements have it."""
    shapes, link = robot.file.shapes, robot.file.links[-1]
    pressures = np.array([shape.pressure_kPa for shape in shapes])
    turns = np.degrees([shape.chain[-1][2] for shape in shapes])
    np.testing.assert_allclose(turns, robot.angle_deg(pressures), atol=1e-9)
    assert pressures[0] == robot.file.valid.pressure_kPa[0]
    for shape in shapes:
        x, z, turn = shape.chain[-1]
        along = robot.file.levels_mm[-1] - link.from_mm
        end = np.array([x - along * np.sin(turn), z + along * np.cos(turn)])
        np.testing.assert_allclose(end, shape.finite_elements[-1][:2], atol=1.0)


@pytest.mark.slow
def test_mujoco_rests_where_the_chain_does(robot: Robot, made: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(made / "finger.xml"))
    for pressure in (-20.0, 20.0, 50.0):
        data = settled(made, {"pressure_kPa": pressure})
        moved = 1e3 * data.sensor("tip_m").data - np.array(robot.file.tip_mm)
        assert moved[[0, 2]] == pytest.approx(robot.tip_mm(pressure)[0], abs=1e-3)
        assert data.sensor("pressure_kPa").data[0] == pytest.approx(pressure, abs=1e-3)
        assert abs(moved[1]) < 1e-6
    mass = sum(link.mass_kg for link in robot.file.links)
    assert model.body_mass.sum() - model.body("supply").mass[0] == pytest.approx(mass)


@pytest.mark.slow
def test_mujoco_hangs_as_the_chain_does(robot: Robot, made: Path) -> None:
    """The finger's z is MuJoCo's −z, and its y the other way. Ten times gravity, to see it."""
    for axis in np.eye(3):
        weightless, pulled = (
            settled(made, {"pressure_kPa": 50.0}, gravity_m_s2=each)
            for each in (np.zeros(3), 98.1 * axis)
        )
        moved = 1e3 * (pulled.sensor("tip_m").data - weightless.sensor("tip_m").data)
        w = robot.state(50.0, gravity_m_s2=98.1 * axis).w
        theirs = robot.chain.places(w, robot.tip)[0, 0] - robot.tip.rest_mm[0]
        theirs[[0, 2]] -= robot.tip_mm(50.0)[0]
        assert moved == pytest.approx(theirs, abs=1e-3)
        assert np.abs(moved).max() > 0.02


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "column"), [(0, 0), (1, 1)])
def test_mujoco_is_as_stiff_as_the_chain(axis: int, column: int, robot: Robot, made: Path) -> None:
    """A small force at the tip, in the finger's axes; the model hangs, so y is turned."""
    model = mujoco.MjModel.from_xml_path(str(made / "finger.xml"))
    model.opt.gravity[:] = 0
    tip = model.site("tip").id
    body, force = model.site_bodyid[tip], 1e-3
    found = []
    for sign in (1, -1):
        data = mujoco.MjData(model)
        data.actuator("pressure_kPa").ctrl[0] = 50.0
        push = np.eye(3)[axis] * sign * force
        while data.time < 1.0:
            arm = data.site_xpos[tip] - data.xipos[body]
            data.xfrc_applied[body] = [*push, *np.cross(arm, push)]
            mujoco.mj_step(model, data)
        found.append(1e3 * data.site_xpos[tip][axis])
    stiffness = 2 * force / (found[0] - found[1])
    assert stiffness == pytest.approx(robot.stiffness_N_per_mm(50.0)[0, column], rel=2e-3)


@pytest.mark.slow
def test_frequencies(robot: Robot, made: Path) -> None:
    """References: the finite elements' first one, to 5 %; all with MuJoCo's masses at rest."""
    at_rest = {"max_pressure_kPa": 1e-4, "step_kPa": 1e-4}
    request = Request.of("vibration", runs.prepared(short()).changed(experiment=at_rest))
    (first, *_) = compute(request).columns["frequency_1_Hz"]
    ours = robot.frequencies_Hz(0.0)
    assert ours[0] == pytest.approx(first, rel=0.05)
    model = mujoco.MjModel.from_xml_path(str(made / "finger.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    unit = np.ones(robot.chain.size)  # mm or rad by m or rad
    unit[robot.chain.of("slide", "shear")] = 1e3
    stiffness = 1e-3 * robot.state(0.0).stiffness[0] * unit[:, None] * unit
    squares = eigh(stiffness, mass[1:, 1:], eigvals_only=True)
    assert ours == pytest.approx(np.sqrt(squares) / (2 * np.pi), rel=1e-5)


@pytest.mark.slow
def test_damping_of_a_material_that_relaxes(robot: Robot) -> None:
    """The reference is the loss factor of a standard linear solid."""
    asked = short("extensions.prony.g=[0.3]", "extensions.prony.tau_s=[0.004]")
    omega = 2 * np.pi * robot.frequencies_Hz(0.0)[0]
    x = omega * 0.004
    loss = 0.3 * x / (1 + x * x) / (0.7 + 0.3 * x * x / (1 + x * x))
    assert build.damping_s(asked, robot)["twist"] == pytest.approx(loss / omega)
    assert build.damping_s(short(), robot) == build.DAMPING_S


def stated_step_s(folder: Path) -> float:
    """The largest step that finger.xml states."""
    found = re.search(r"steps of up to ([\d.]+) ms", (folder / "finger.xml").read_text("utf-8"))
    assert found is not None
    return float(found[1]) / 1e3


@pytest.mark.slow
@pytest.mark.parametrize("damping_s", [None, 1e-4])
def test_no_input_blows_it_up(damping_s: float | None, made: Path, tmp_path: Path) -> None:
    """Steps and a square wave of 5 Hz, with gravity: at the file's step and the largest it states.

    A material that relaxes much faster than the finger swings has a damping of less than a step.
    """
    file, mesh = RobotFile.read(made), whole_solid(short())
    if damping_s is None:
        shutil.copy(made / "finger.xml", tmp_path)
    else:
        joint = file.joints[0].model_copy(
            update={
                "coordinates": tuple(
                    each.model_copy(update={"damping_s": damping_s})
                    for each in file.joints[0].coordinates
                )
            }
        )
        ends = [file.links[0].from_mm, *(link.to_mm for link in file.links)]
        lightly = file.model_copy(update={"joints": (joint, *file.joints[1:])})
        (tmp_path / "finger.xml").write_text(mjcf.finger(lightly, skin(mesh, ends), 0.4), "utf-8")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "finger.xml"))
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert model.opt.timestep == 1e-3
    largest = stated_step_s(tmp_path)
    assert largest == pytest.approx(4e-3 if damping_s is None else 2e-3)
    for step in (1e-3, largest):
        model.opt.timestep = step
        data = mujoco.MjData(model)
        for number in range(12):
            data.ctrl[0] = (50.0, -20.0)[number % 2]
            for _ in range(round(0.1 / step)):
                mujoco.mj_step(model, data)
            assert np.isfinite(data.qpos).all()
            assert np.abs(data.qpos[1:]).max() < 1.0
        assert not any(each.number for each in data.warning)


@pytest.mark.slow
def test_the_scene_holds_still_food(made: Path) -> None:
    """Three fingers, a table and food that lies on it with its weight."""
    model = mujoco.MjModel.from_xml_path(str(made / "scene.xml"))
    data = mujoco.MjData(model)
    for _ in range(200):
        mujoco.mj_step(model, data)
    before = data.body("food").xpos.copy()
    data.actuator("pressure_kPa").ctrl[0] = 50.0
    data.actuator("lift_m").ctrl[0] = 0.02
    speeds = []
    for _ in range(800):
        mujoco.mj_step(model, data)
        speeds.append(data.joint("lift_m").qvel[0])
    # an input that jumps lifts as fast as finite elements do, less what the fingers weigh
    assert max(speeds) == pytest.approx(1e-3 * short().gripper.lift_mm_per_s, rel=0.03)
    assert data.body("food").xpos == pytest.approx(before, abs=5e-4)  # short fingers miss it
    assert data.body("base").xpos[2] == pytest.approx(0.02, abs=1e-3)
    names = {model.body(i).name for i in range(model.nbody)}
    assert {"A_link_1", "B_link_1", "C_link_1", "food"} <= names


def controlled(folder: Path) -> tuple[Any, Any]:
    """The URDF in MuJoCo without gravity and contacts, and the laws of control.py beside it."""
    found = importlib.util.spec_from_file_location("control", folder / "control.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    model = mujoco.MjModel.from_xml_path(str(folder / "finger.urdf"))
    model.opt.gravity[:] = 0
    model.geom_contype[:] = 0  # links of one place overlap
    return model, module.JointLaws(folder / "robot.json")


def stepped_deg(folder: Path, pressure_kPa: float, step_s: float, integrator: str) -> float:
    """Angle of the URDF's tip after a ramp of pressure, by steps as control.py says."""
    model, control = controlled(folder)
    model.opt.timestep = step_s
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    data = mujoco.MjData(model)
    while data.time < 1.5:
        pressure = pressure_kPa * min(data.time / 0.1, 1.0)
        data.qfrc_applied[:] = control.efforts(pressure_kPa=pressure, position=data.qpos)
        mujoco.mj_step(model, data)
    assert not any(each.number for each in data.warning)
    last = len(RobotFile.read(folder).joints)
    turned = data.body(f"link_{last}").xmat.reshape(3, 3)
    return float(np.degrees(np.arctan2(-turned[0, 2], turned[2, 2])))


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["EULER", "IMPLICITFAST"])
def test_urdf_rests_where_the_chain_does(integrator: str, robot: Robot, made: Path) -> None:
    """In steps of 1 ms, and of the largest that finger.xml states, in MuJoCo; to 0.01 %."""
    for step_s in (1e-3, stated_step_s(made)):
        for pressure in (-20.0, 50.0):
            found = stepped_deg(made, pressure, step_s, integrator)
            assert found == pytest.approx(float(robot.angle_deg(pressure)[0]), rel=1e-4)


@pytest.mark.slow
def test_urdf_and_control(robot: Robot, made: Path) -> None:
    """MuJoCo reads the URDF; the efforts of control.py vanish at the chain's equilibrium."""
    model, control = controlled(made)
    assert [model.joint(i).name for i in range(model.njnt)] == control.names
    # an equilibrium by the law alone: no effort where the chain rests
    w = robot.state(50.0).w[0]
    position = w.copy()
    position[robot.chain.of("slide", "shear")] *= 1e-3
    efforts = control.efforts(50.0, position)
    assert np.abs(efforts).max() < 1e-9
    data = mujoco.MjData(model)
    data.qpos[:] = position
    mujoco.mj_forward(model, data)
    angles = robot.angle_deg(50.0)
    turned = data.body(f"link_{len(robot.file.joints)}").xmat.reshape(3, 3)
    assert np.degrees(np.arctan2(-turned[0, 2], turned[2, 2])) == pytest.approx(angles[0])
    mass = sum(link.mass_kg for link in robot.file.links[1:])
    assert model.body_mass.sum() == pytest.approx(mass)  # the clamped link is the world's
    # at rest, all links of a place together turn as the one link of robot.json
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    number = len(robot.file.joints)
    last = [i for i in range(model.nbody) if model.body(i).name.startswith(f"link_{number}")]
    assert len(last) == len(COORDINATES)
    turns = [data.ximat[i].reshape(3, 3) for i in last]
    inertia = sum(
        turn * model.body_inertia[i] @ turn.T for i, turn in zip(last, turns, strict=True)
    )
    xx, yy, zz, xy, xz, yz = robot.file.links[-1].inertia_kg_mm2
    whole = 1e-6 * np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert inertia == pytest.approx(whole, rel=1e-5, abs=1e-13)
    assert data.xipos[last] == pytest.approx(
        np.tile(1e-3 * np.array(robot.file.links[-1].centre_mm), (len(last), 1)), abs=1e-9
    )


@pytest.mark.slow
def test_the_lines_of_the_report_load_it(
    robot: Robot, made: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """They end where the chain rests, in the colour of the highest pressure, and speed is known."""
    page = sources.build(sources.find([made]))
    ((_, lines),) = page.code
    held: dict[str, Any] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", list(sys.path))
        exec(lines, held)
    assert "tip from the clamp (m):" in capfd.readouterr().out
    moved = 1e3 * held["data"].sensor("tip_m").data - np.array(robot.file.tip_mm)
    hanging = robot.state(50.0, gravity_m_s2=(0.0, 0.0, 9.81)).w
    there = robot.chain.places(hanging, robot.tip)[0, 0] - robot.tip.rest_mm[0]
    assert moved == pytest.approx(there, abs=1e-3)
    assert held["model"].skin_rgba[0, :3] == pytest.approx(RED, abs=1e-3)
    assert robot.file.speed is not None
    assert robot.file.speed.times_real_time > 1.0
    assert robot.file.speed.step_s == 1e-3


@pytest.mark.slow
def test_pressure_for(robot: Robot) -> None:
    assert robot.angle_deg(robot.pressure_for(angle_deg=3.0)) == pytest.approx(3.0, abs=1e-3)
    gap = robot.file.valid.gaps_mm[-1]
    force = 0.3 * float(robot.force_N(50.0, gap)[0])
    pressure = robot.pressure_for(tip_force_N=force, gap_mm=gap)
    assert robot.force_N(pressure, gap) == pytest.approx(force, rel=1e-3)
    squeeze = robot.pressure_for(squeeze_N=force, gap_mm=gap)
    assert robot.force_N(squeeze, gap, full_back=True) == pytest.approx(force, rel=1e-3)
    with pytest.raises(
        ConfigError, match=r"angle_deg = 500: allowed: -.* to .* deg, from -20 to 50 kPa"
    ):
        robot.pressure_for(angle_deg=500.0)
    with pytest.raises(ConfigError, match=r"tip_force_N = nan: allowed: [\d.-]+ to [\d.]+ N, from"):
        robot.pressure_for(tip_force_N=np.nan)
    for wrong in (-1.0, np.nan):
        with pytest.raises(ConfigError, match=f"gap_mm = {wrong:g}: allowed: 0 mm or more"):
            robot.pressure_for(squeeze_N=0.1, gap_mm=wrong)
    with pytest.raises(ConfigError, match="allowed: one of angle_deg, tip_force_N, squeeze_N"):
        robot.pressure_for(angle_deg=1.0, tip_force_N=1.0)


@pytest.mark.slow
def test_a_supply_fills_it(robot: Robot) -> None:
    asked = [0.0, 0.01, 2.0], [20.0, 20.0, 20.0]
    found = robot.filled_kPa(*asked, AirLine(source="ideal"))
    assert found[0] == pytest.approx(0, abs=1e-3)  # its table is interpolated
    assert 0 < found[1] < 19
    assert found[2] == pytest.approx(20, abs=0.05)
    with pytest.raises(ConfigError, match=r'supply\.source = "syringe"'):
        robot.filled_kPa([0.0, 1.0], [0.0, 0.0], AirLine(source="syringe"))
    with pytest.raises(ConfigError, match=r"time_s = 2 times.*times that rise"):
        robot.filled_kPa([1.0, 1.0], [0.0, 0.0], AirLine())
    with pytest.raises(ConfigError, match=r"supply\.source = none"):
        robot.filled_kPa(*asked)
    pump = AirLine(source="pump", pump_kPa=(0.0, 60.0), pump_l_per_min=(2.0, 0.0))
    fed = Robot(robot.file.model_copy(update={"supply": pump.model_dump(mode="json")}))
    fills_s, times = fed.fills_s(), np.linspace(0.0, 3.0, 601)
    filled = np.interp(fills_s, times, fed.filled_kPa(times, np.full(601, 50.0)))
    assert filled == pytest.approx(0.95 * 50, rel=5e-3)
    kept = AirLine(source="tank", tank_cm3=10.0, tank_kPa=50.0)
    with pytest.raises(
        ConfigError, match=r"supply: the cavity never has 95 % of 50 kPa: [\d.]+ kPa"
    ):
        Robot(robot.file.model_copy(update={"supply": kept.model_dump(mode="json")})).fills_s()


def test_its_runs_are_at_rest() -> None:
    """A configuration in time makes the same runs as one without supply and protocol."""
    filled = short(
        "supply.board=programmable-air", "experiment.max_pressure_kPa=40",
        "protocol.time_s=[0,0,1]", "protocol.pressure_kPa=[0,40,40]",
    )  # fmt: skip
    alone = short("experiment.max_pressure_kPa=40")
    assert (
        runs.free_request(runs.prepared(filled)).key == runs.free_request(runs.prepared(alone)).key
    )


@pytest.mark.slow
def test_refusals(robot: Robot) -> None:
    with pytest.raises(ConfigError, match=r"experiment.max_pressure_kPa = -20: allowed: above 0"):
        runs.prepared(short("experiment.max_pressure_kPa=-20"))
    assert not runs.prepared(short("experiment.dynamic=true")).experiment.dynamic
    still = np.zeros(3)
    run = runs.FingerRun(
        None, np.arange(3.0), still, still, still, still, still, np.array([0.0, 50.0]), np.zeros(2),
        np.zeros((3, 2, 2)), np.zeros((3, 2)), np.zeros((1, 3)), 5.0, 1.0, 0.0, "",
    )  # fmt: skip
    with pytest.raises(ConfigError, match="allowed: a finger that bends to its back"):
        runs.gaps_mm(run, [0.1])


@pytest.mark.slow
def test_a_second_call_computes_nothing(
    made: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def solved(*arguments: object) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr(runs, "compute", solved)
    before = (made / "finger.xml").read_bytes()
    assert run_command("robot", "--out", made, *OPTIONS) == 0
    assert (made / "finger.xml").read_bytes() == before
    assert "States that were not" in capfd.readouterr().out


@pytest.mark.slow
def test_an_error_that_no_chain_has(
    made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The nearest chain, from the runs that are there; the finger has two bellows that bend."""
    shutil.copytree(made / "simulations", tmp_path / "simulations")
    asked = ("--angle-error-deg", "0.001", "--stiffness-error-percent", "50")
    assert run_command("robot", "--out", tmp_path, *OPTIONS, *asked) == 0
    file = RobotFile.read(tmp_path)
    assert file.accuracy == Accuracy(angle_deg=0.001, stiffness=0.5)
    angles = [each.largest for each in file.comparisons if each.quantity == "angle"]
    assert file.excess == pytest.approx(max(angles) / 0.001)
    said = " ".join(capfd.readouterr().out.split())
    found = re.search(r"no chain of up to (\d+) joints is within .* of (\d+) joint", said)
    assert found is not None
    most, nearest = map(int, found.groups())
    assert 1 < most <= MOST_JOINTS
    assert nearest == len(file.joints)
    assert all(link.mass_kg > 0 for link in file.links)
    # light links of many joints need no shorter steps
    angle = float(Robot(file).angle_deg(50.0)[0])
    assert stepped_deg(tmp_path, 50.0, 1e-3, "EULER") == pytest.approx(angle, rel=1e-3)


@pytest.mark.slow
def test_a_page_shows_it(made: Path) -> None:
    assert run_command("report", made, "--out", made / "page.html") == 0
    page = (made / "page.html").read_text(encoding="utf-8")
    assert "Reduced model: angle, free" in page
    assert "None of these states was fitted" in page
    assert f"python -m mujoco.viewer --mjcf={made / 'finger.xml'}" in page
