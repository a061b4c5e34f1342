"""Reduced models beside finite elements: errors, speed, and grasps in MuJoCo.

    scripts/run python -m benchmarks.robot [--only NAME …] [--out out/robot_models]

writes ``benchmarks/robot.csv``. Runs are kept in ``--out``, so that a second call goes on. A finger
takes two to five minutes of one core, a grasp two to four. References are the finite elements of
this package; those of food are rows of ``benchmarks/grasp_sweep.csv``, and a cube that is grasped
here.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

import mujoco
import numpy as np

from benchmarks.grasp_sweep import TABLE as GRASPS
from dolfingrip.config import Config, load
from dolfingrip.design.quantities.grasp import outputs_of
from dolfingrip.experiments.loop import run
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import simulate
from dolfingrip.files import table
from dolfingrip.files.robot import Accuracy
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.robot import runs
from dolfingrip.robot.build import Built, Simulated, build
from dolfingrip.robot.build import simulate as finite_elements
from dolfingrip.robot.mjcf import OTHERS
from dolfingrip.robot.robot import Robot
from dolfingrip.robot.write import room, write
from dolfingrip.sections.tables import assignments

TABLE: Final = Path(__file__).with_suffix(".csv")

ADOPTED: Final = "adopted finger"
"""A CAD file that ``dolfingrip adopt`` meshes with Gmsh's tetrahedra."""

MOVED: Final = "default finger, coarse mesh"
"""The finger whose motion in time is compared, too."""

FINGERS: Final = {
    "default finger": "experiment.min_pressure_kPa=-60",
    MOVED: "mesh.size_mm=6 mesh.edge_size_mm=6",
    "paper's design 1": "morph.xi1=0.28 morph.xi2=-0.25",
    "paper's design 2": "morph.xi1=-0.2 morph.xi2=0.25",
    "paper's design 3": "morph.xi1=0.52 morph.xi2=-0.5",
    "pneu-net": (
        "finger.kind=pneunet pneunet.chambers=4 plate.contact_length_mm=5 film.paper.model=layer "
        "film.paper.region=paper film.paper.Et_N_per_mm=50 experiment.max_pressure_kPa=100 "
        "solver.max_step_kPa=50"
    ),
    "round finger": (
        "finger.kind=round_bellows round_bellows.convolutions=4 plate.contact_length_mm=5 "
        "cavity.cavity_2.pressure_ratio=0 experiment.max_pressure_kPa=20 mesh.size_mm=4"
    ),
    "cast block": "cast_block.toml mesh.size_mm=4 mesh.edge_size_mm=4",
    ADOPTED: (
        "material.mu_MPa=0.15 film.paper.Et_N_per_mm=100 contact.self_contact=false "
        "experiment.max_pressure_kPa=30"
    ),
}

EXAMPLES: Final = Path(__file__).parents[1] / "examples"

PART: Final = EXAMPLES / "half_round_finger.step"

STATED_DEG: Final = {MOVED: (3.0, 1.0, 0.3), "pneu-net": (2.0, 0.2, 0.01)}
"""Errors of the angle for which the fewest joints are told."""

FOODS: Final = {
    "cube": ("food.kind=cube", 150.0),
    "sausage-short": ("food.kind=sausage-short gripper.alpha_deg=90 gripper.clearance_mm=4", 200.0),
    "sausage-long": ("food.kind=sausage-long gripper.alpha_deg=90 gripper.clearance_mm=4", 200.0),
    "potato-small": ("food.kind=potato-small gripper.alpha_deg=30 gripper.clearance_mm=4", 200.0),
    "potato-small, squeezed": (
        "food.kind=potato-small gripper.alpha_deg=30 gripper.clearance_mm=4", 250.0,
    ),
}  # fmt: skip

BEYOND: Final = ("default finger",)
"""Fingers that are loaded otherwise than their chains were fitted."""

BEYOND_GAPS: Final = (0.44, 0.6)
"""Gaps of the plate by the free tip's way, twice and three times the widest that is fitted."""

DIRECTIONS: Final = {
    "to the back": (-1, 0, 0), "away from the back": (1, 0, 0), "from clamp to tip": (0, 0, 1),
    "from tip to clamp": (0, 0, -1),
}  # fmt: skip

GOALS: Final = {
    "angle": 1.5, "tip path": 1.0, "force on the plate": 0.04, "stiffness of the tip, x": 0.07,
    "stiffness of the tip, y": 0.07, "pressure for an angle": 2.0,
    "pressure for a tip's force": 0.05, "speed, one finger": 20.0, "speed, gripper with food": 2.0,
    "normal forces": 0.15, "first natural frequency": 0.05, "time to 90 % of a step": 0.1,
}  # fmt: skip

BORN_S: Final = 2.0
"""Time (s) in which MuJoCo's finger shows that it stays finite at each input."""


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes:
        of: finger or food.
        quantity: what is compared.
        value: error, or figure.
        unit: of both.
        goal: that it is measured by; None: there is none.
        note: what else there is to say.
    """

    of: str
    quantity: str
    value: float | str
    unit: str
    goal: float | None = None
    note: str = ""


@cache
def adopted(folder: Path) -> Path:
    """Adopt the CAD file, and return the configuration."""
    command = ["dolfingrip", "adopt", str(PART), "--whole", "--size-mm", "5", "--order", "2"]
    subprocess.run([*command, "-o", str(folder)], check=True)
    return folder / "adopted.toml"


def configured(settings: str, folder: Path) -> Config:
    """Return the configuration of a finger with settings."""
    file = adopted(folder / "adopted") if settings.startswith(FINGERS[ADOPTED]) else None
    first, *others = settings.split()
    if first.endswith(".toml"):
        return load(EXAMPLES / first, assignments(others))
    return load(file, assignments([first, *others]))


@cache
def simulated(settings: str, folder: Path) -> Simulated:
    """Run a finger's finite elements."""
    with Pool(Where()) as pool:
        return finite_elements(configured(settings, folder), folder, pool)


@cache
def reduced(settings: str, folder: Path) -> Built:
    """Build a finger's reduced model."""
    return build(simulated(settings, folder))


def numbers(name: str, runs: Simulated) -> Iterator[Row]:
    """Fewest joints for a stated error of the angle."""
    for stated in STATED_DEG.get(name, ()):
        built = build(runs, Accuracy(angle_deg=stated))
        file = built.robot.file
        reached = f"{stated * file.excess:.3g}°, with chains of up to {built.tried} joints tried"
        yield Row(
            name, f"joints for {stated:g}° of angle",
            len(file.joints) if file.excess <= 1 else "none", "", None,
            reached if file.excess <= 1 else f"nearest: {len(file.joints)} joints, {reached}",
        )  # fmt: skip


def made(settings: str, folder: Path, food: str = "") -> tuple[Robot, Config]:
    """Build a finger's reduced model, and write its files with food."""
    built = reduced(settings, folder)
    config = configured(f"{settings} {food}", folder)
    try:
        placed = room(config)
    except ValueError as error:
        print(error)
        placed = None
    write(built, config, placed, folder)
    return built.robot, config


def errors(name: str, robot: Robot) -> Iterator[Row]:
    """Errors at states that were not fitted."""
    for each in robot.file.comparisons:
        unit = "relative" if each.unit in ("N", "N/mm") else each.unit
        yield Row(name, each.quantity, each.error, unit, GOALS[each.quantity], each.title)


def beyond(name: str, robot: Robot, config: Config) -> Iterator[Row]:
    """Errors of the angle and the force beyond what was fitted: wider gaps, gravity."""
    asked, largest_kPa = runs.prepared(config), robot.file.valid.pressure_kPa[1]
    way = robot.file.valid.gaps_mm[0] / runs.FITTED_GAPS[0]
    for share in BEYOND_GAPS:
        pressed = asked.changed(plate={"gap_mm": round(share * way, 2)})
        found, gap = run("blocked_force", pressed), pressed.plate.gap_mm
        p, force = found.column("pressure_kPa"), found.column("force_N")
        wrong = np.abs(robot.angle_deg(p, gap) - found.column("angle_deg")).max()
        note = f"plate at {gap:g} mm, {100 * share:.0f} % of the free tip's way"
        yield Row(name, "angle", wrong, "deg", GOALS["angle"], note)
        relative = np.abs(robot.force_N(p, gap) - force).max() / force.max()
        yield Row(
            name, "force on the plate", relative, "relative", GOALS["force on the plate"], note
        )
    free = run("bending", asked).column("angle_deg")
    for towards, direction in DIRECTIONS.items():
        gravity = runs.HANGING | {"direction": direction}
        found = run("bending", asked.changed(gravity=gravity))
        p, turned = found.column("pressure_kPa"), found.column("angle_deg")
        ours = robot.angle_deg(p, gravity_m_s2=9.81 * np.array(direction))
        wrong = np.abs(ours - ours[p == 0] - turned).max()
        yield Row(
            name, "angle", wrong, "deg", GOALS["angle"],
            f"gravity {towards}, which changes it by {np.abs(turned - free).max():.1f}° up to "
            f"{largest_kPa:g} kPa",
        )  # fmt: skip


def inverse(name: str, robot: Robot, config: Config) -> Iterator[Row]:
    """Give finite elements the pressures that the chain found."""
    asked = runs.prepared(config)
    wanted = 0.45 * float(robot.angle_deg(robot.file.valid.pressure_kPa[1])[0])
    pressure = robot.pressure_for(angle_deg=wanted)
    step = {"max_pressure_kPa": pressure, "step_kPa": pressure}
    found = run("bending", asked.changed(experiment=step)).column("angle_deg")[-1]
    yield Row(
        name, "pressure for an angle", abs(found - wanted), "deg", GOALS["pressure for an angle"],
        f"{pressure:.1f} kPa for {wanted:.1f}°, which finite elements bend by {found:.1f}°",
    )  # fmt: skip
    gap = robot.file.valid.gaps_mm[-1]
    force = 0.55 * float(robot.force_N(robot.file.valid.pressure_kPa[1], gap)[0])
    pressure = robot.pressure_for(tip_force_N=force, gap_mm=gap)
    step = {"max_pressure_kPa": pressure, "step_kPa": pressure}
    pressed = asked.changed(experiment=step, plate={"gap_mm": gap})
    found = run("blocked_force", pressed).column("force_N")[-1]
    yield Row(
        name, "pressure for a tip's force", abs(found / force - 1), "relative",
        GOALS["pressure for a tip's force"],
        f"{pressure:.1f} kPa for {force:.3f} N at {gap:g} mm: {found:.3f} N",
    )  # fmt: skip


def speed(name: str, folder: Path) -> Iterator[Row]:
    """Time of MuJoCo's finger, with inputs that must not blow it up."""
    model = mujoco.MjModel.from_xml_path(str(folder / "finger.xml"))
    low, high = model.actuator_ctrlrange[0]
    levels = np.unique([low, *np.linspace(0, high, 6)])
    inputs = {f"constant {p:.0f} kPa": [(BORN_S, p)] for p in levels}
    inputs["0, highest, 0"] = [(0.5, 0), (0.5, high), (0.5, 0)]
    inputs["a fifth, four fifths"] = [(0.5, 0.2 * high), (0.5, 0.8 * high)]
    inputs["5 Hz"] = [(0.1, high * (i % 2)) for i in range(20)]
    blown, steps, begun = [], 0, time.process_time()
    for said, parts in inputs.items():
        data = mujoco.MjData(model)
        for duration, pressure in parts:
            data.ctrl[0] = pressure
            for _ in range(round(duration / model.opt.timestep)):
                mujoco.mj_step(model, data)
                steps += 1
        if any(each.number for each in data.warning) or np.abs(data.qpos[1:]).max() > 2:
            blown.append(said)
    factor = steps * model.opt.timestep / (time.process_time() - begun)
    note = f"steps of {1e3 * model.opt.timestep:g} ms; blown up: {', '.join(blown) or 'none'}"
    yield Row(
        name, "speed, one finger", factor, "times real time", GOALS["speed, one finger"], note
    )


STEP_KPA, RISE_S, END_S, EVERY_S = 100.0, 0.05, 0.12, 0.005


def motion(name: str, robot: Robot, config: Config, folder: Path) -> Iterator[Row]:
    """Natural frequencies, and a step of pressure that rises in 50 ms, both without gravity."""
    asked = runs.prepared(config)
    times = np.arange(0, END_S + EVERY_S / 2, EVERY_S)
    risen = STEP_KPA * np.minimum(times / RISE_S, 1.0)
    protocol = {"time_s": times.tolist(), "pressure_kPa": risen.tolist()}
    moving = asked.changed(
        experiment={"dynamic": True}, solver={"time_error_mm": 0.1}, protocol=protocol
    )
    with Pool(Where()) as pool:
        swinging, moved = simulate(
            [Request.of("vibration", asked), Request.of("bending", moving)], folder / "motion", pool
        )
    pressures = np.array(swinging.columns["pressure_kPa"])
    found = np.array(swinging.columns["frequency_1_Hz"])
    ours = np.array([robot.frequencies_Hz(each)[0] for each in pressures])
    yield Row(
        name, "first natural frequency", float(np.abs(ours / found - 1).max()), "relative",
        GOALS["first natural frequency"],
        f"{ours[0]:.2f} to {ours[-1]:.2f} Hz, finite elements {found[0]:.2f} to {found[-1]:.2f} Hz",
    )  # fmt: skip
    wanted = 0.9 * float(robot.angle_deg(STEP_KPA)[0])
    model = mujoco.MjModel.from_xml_path(str(folder / "finger.xml"))
    model.opt.gravity[:] = 0
    data, tip = mujoco.MjData(model), len(robot.file.joints)
    angles = []
    for time_s in np.arange(0, END_S, model.opt.timestep):
        data.qpos[0], data.qvel[0] = STEP_KPA * min(time_s / RISE_S, 1.0), 0.0
        mujoco.mj_step(model, data)
        turned = data.body(f"link_{tip}").xmat.reshape(3, 3) @ (0, 0, 1)
        angles.append(np.degrees(np.arctan2(-turned[0], -turned[2])))
    reached = [
        float(np.interp(wanted, angle[: rising + 1], at[: rising + 1]))
        for at, angle in (
            (np.arange(len(angles)) * model.opt.timestep, np.array(angles)),
            (np.array(moved.columns["time_s"]), np.array(moved.columns["angle_deg"])),
        )
        if (rising := int(angle.argmax()))
    ]
    yield Row(
        name, "time to 90 % of a step", abs(reached[0] / reached[1] - 1), "relative",
        GOALS["time to 90 % of a step"],
        f"{1e3 * reached[0]:.1f} ms, finite elements {1e3 * reached[1]:.1f} ms, to "
        f"{STEP_KPA:g} kPa in {1e3 * RISE_S:g} ms",
    )  # fmt: skip


AWAY_MM: Final = 15.0
"""Way from which on food that nothing holds was ejected."""


class Lifted(NamedTuple):
    """A grasp in MuJoCo: outcome, normal forces before the lift, and speed by real time."""

    outcome: str
    normal_N: float
    factor: float


def lifted(folder: Path, config: Config, pressure_kPa: float) -> Lifted:
    """Grasp in MuJoCo as the experiment does: pressurise, wait, lift, wait.

    In the experiment fingers do not feel the table, so they do not here.
    """
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    table_only = model.geom("table")
    table_only.contype, table_only.conaffinity = 2 * OTHERS, OTHERS  # it bears food alone
    data, gripper = mujoco.MjData(model), config.gripper
    rise, wait = gripper.pressurise_s, gripper.settle_s
    lift = gripper.lift_mm / gripper.lift_mm_per_s
    times = np.cumsum([0.0, rise, wait, lift, wait])
    start, lifted_m, before = None, None, time.process_time()
    normal: dict[str, float] = {}
    while data.time < times[-1]:
        share = np.interp(data.time, times, [0, 1, 1, 1, 1])
        data.actuator("pressure_kPa").ctrl = pressure_kPa * share
        height = np.interp(data.time, times, [0, 0, 0, 1, 1])
        data.actuator("lift_m").ctrl = 1e-3 * gripper.lift_mm * height
        mujoco.mj_step(model, data)
        if start is None and data.time >= times[2]:
            start, normal = data.body("food").xpos.copy(), normals(model, data)
        if lifted_m is None and data.time >= times[3]:
            lifted_m = data.body("food").xpos[2]
    used = time.process_time() - before
    after = normals(model, data)
    assert start is not None
    assert lifted_m is not None
    sank = 1e3 * (lifted_m - data.body("food").xpos[2])
    moved = 1e3 * (data.body("food").xpos - start)
    held = any(name in after for name in "ABC") and "table" not in after
    if held:
        outcome = "picked up" if sank < 1 else "slipped"
    else:
        outcome = "ejected" if np.abs(moved).max() > AWAY_MM else "not lifted"
    factor = float(times[-1]) / used
    return Lifted(outcome, sum(normal.get(name, 0.0) for name in "ABC"), factor)


def normals(model: Any, data: Any) -> dict[str, float]:
    """Normal forces on the food by finger, and of the table (N)."""
    found: dict[str, float] = {}
    for number, contact in enumerate(data.contact):
        names = {model.geom(contact.geom1).name, model.geom(contact.geom2).name}
        if "food" in names:
            (other,) = names - {"food"}
            force = np.zeros(6)
            mujoco.mj_contactForce(model, data, number, force)
            found[other.split("_")[0]] = found.get(other.split("_")[0], 0.0) + float(force[0])
    return found


def reference(food: str, settings: str, pressure_kPa: float, folder: Path) -> tuple[str, float]:
    """Outcome, and the sum of normal forces before the lift (N), by finite elements."""
    with GRASPS.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            same = float(row["experiment.max_pressure_kPa"]) == pressure_kPa
            if row["food.kind"] == food.split(",")[0] and same:
                return row["outcome"], float(row["normal_N"])
    keys = f"{settings} gripper.preset=coarse experiment.max_pressure_kPa={pressure_kPa}"
    asked = Request.of("grasp", load(None, assignments(keys.split())))
    with Pool(Where()) as pool:
        (answer,) = simulate([asked], folder / "grasps", pool)
    assert answer.outcome is not None
    return answer.outcome["kind"], outputs_of(answer)["normal_N"]


def grasp(food: str, folder: Path) -> Iterator[Row]:
    """Food in MuJoCo, by the default finger, beside finite elements on the coarse preset.

    The coarse preset bends by 2 % less than the default mesh.
    """
    keys, pressure = FOODS[food]
    _, config = made(FINGERS["default finger"], folder, keys)
    found = lifted(folder, config, pressure)
    outcome, normal = reference(food, keys, pressure, folder)
    said = f"{found.outcome}, {found.normal_N:.3g} N; finite elements: {outcome}, {normal:.3g} N"
    yield Row(
        food, "outcome", "the same" if outcome == found.outcome else "another", "", None, said
    )
    if normal:
        error = abs(found.normal_N / normal - 1)
        yield Row(food, "normal forces", error, "relative", GOALS["normal forces"], said)
    speed = "speed, gripper with food"
    yield Row(food, speed, found.factor, "times real time", GOALS[speed])


def main() -> None:
    """Compute the rows, and write those that are there."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--out", type=Path, default=Path("out/robot_models"))
    asked = parser.parse_args()
    known: dict[str, list[dict[str, Any]]] = {}
    if TABLE.exists():
        with TABLE.open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                known.setdefault(row["of"], []).append(row)
    for name in [*FINGERS, *FOODS]:
        if asked.only and name not in asked.only:
            continue
        if name in FINGERS:
            folder = asked.out / name.replace(" ", "_").replace("'", "")
            robot, config = made(FINGERS[name], folder)
            rows = [
                *errors(name, robot), *inverse(name, robot, config), *speed(name, folder),
                Row(name, "joints", len(robot.file.joints), "", None,
                    f"finite elements took {robot.file.simulated_s:.0f} s"),
                *numbers(name, simulated(FINGERS[name], folder)),
            ]  # fmt: skip
            if name in BEYOND:
                rows += beyond(name, robot, config)
            if name == MOVED:
                rows += motion(name, robot, config, folder)
        else:
            rows = list(grasp(name, asked.out / "default_finger"))
        known[name] = [
            vars(each)
            | {"value": each.value if isinstance(each.value, str) else f"{each.value:.3g}"}
            for each in rows
        ]
        for each in rows:
            print(each, flush=True)
        order = [each for each in [*FINGERS, *FOODS] if each in known]
        table.write(TABLE, [row for each in order for row in known[each]])


if __name__ == "__main__":
    main()
