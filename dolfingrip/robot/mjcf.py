"""MuJoCo's files: a finger, a gripper of three, and a scene with a table and food.

Lengths are in m, forces in N. The pressure is the place of a slide, 1 m for 1 kPa, that follows the
input; so tendons with springs of second order give the terms p, p w and p² of every law.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from scipy.spatial.transform import Rotation

from dolfingrip.experiments.rigs.food import GraspedBody
from dolfingrip.files.robot import JointCoordinate, Law, Link, RobotFile
from dolfingrip.files.xml import add, text
from dolfingrip.foods.food import Food
from dolfingrip.mechanics.contact.distance import Capsule, TurnedShape
from dolfingrip.meshes.gripper import Stand
from dolfingrip.robot.links import BoundSkin

M_PER_MM: Final = 1e-3

STEP_S: Final = 0.001
"""Time step."""

GRASPING: Final = {"integrator": "discrete", "impratio": 5}
"""How a gripper is integrated: contact forces are found with the springs and damping of a step,
which are up to twenty times the inertia of a light link. Other integrators find them without, so
that contacts tremble, and steps have to be half as long. A potato that jumped up between the
fingers is held with 2.2 N at ``impratio`` 10, with 2.5 N at 5, as friction creeps more."""

SWINGING: Final = {"integrator": "implicitfast"}
"""How one finger is integrated: the other way damps its swinging as much as its material does."""

_STEPS: Final = """\
<!-- Integrator implicitfast holds in steps of up to {largest_ms:.3g} ms: twice the least time by
     which damping multiplies a stiffness. Longer steps need integrator discrete, which damps more.
     RK4 takes damping explicitly, and needs steps of 0.005 ms. -->
"""

ARM: Final = 1e-3
"""Coefficient of the pressure's slide in tendons."""

SUPPLY_N_PER_M: Final = 1e3
"""Stiffness with which the pressure's slide follows its input; all tendons pull it by some mN."""

SUPPLY_KG: Final = 1e-3

LIFT_N_S_PER_M: Final = 2000.0
"""Damping of the base, which with the largest force of its actuator limits its speed: an input that
jumps would throw off food that is held by little."""

CONTACT: Final = {"solref": "0.004 1", "solimp": "0.95 0.99 0.0005", "condim": "4"}

TURNING: Final = (0.002, 0.0001)
"""Coefficients of friction against turning and rolling (m)."""

OTHERS: Final = 8
"""Collision type of what is no finger; those of fingers are 1, 2 and 4, and meet all but their own,
so that links of one finger do not touch one another."""

ALL: Final = 2 * OTHERS - 1

MOST_CORNERS: Final = 1000
"""Corners of the hull of food: with 200 a sausage that is pressed rolls on its flat faces."""

ORDER: Final = (
    "compiler", "option", "include", "asset", "worldbody", "deformable", "tendon", "actuator",
    "sensor",
)  # fmt: skip
"""Sections of a model."""


def _law_si(coordinate: JointCoordinate) -> Law:
    """A law in N or N·m by m or rad."""
    a, b, c, d = coordinate.law
    if coordinate.kind == "hinge":
        return a * M_PER_MM, b * M_PER_MM, c * M_PER_MM, d * M_PER_MM
    return a, b / M_PER_MM, c / M_PER_MM, d


def damping(robot: RobotFile, coordinate: JointCoordinate) -> float:
    """Return the damping of a coordinate, by its largest stiffness.

    Simulators integrate it implicitly, and the springs of the laws explicitly. At any inertia these
    are stable in steps of up to twice the time that a stiffness is multiplied by.

    Args:
        robot: chain, with the pressures that it is valid for.
        coordinate: of it.

    Returns:
        N·s/m of a slide, N·m·s/rad of a hinge.
    """
    _, b, c, _ = _law_si(coordinate)
    return _damping_s(coordinate) * max(-(b * p + c) for p in robot.valid.pressure_kPa)


def _damping_s(coordinate: JointCoordinate) -> float:
    return max(coordinate.damping_s, STEP_S)


class _Model:
    """A model, whose sections are made as they are asked for."""

    def __init__(self, name: str, options: Mapping[str, Any] = GRASPING) -> None:
        self.root = Element("mujoco", model=name)
        self.add("", "compiler", angle="radian", autolimits="true")
        self.add("", "option", timestep=STEP_S, cone="elliptic", **options)

    def section(self, name: str) -> Element:
        if not name:
            return self.root
        child = self.root.find(name)
        return SubElement(self.root, name) if child is None else child

    def add(self, section: str, tag: str, **attributes: Any) -> Element:
        return add(self.section(section), tag, **attributes)

    def text(self) -> str:
        self.root[:] = sorted(self.root, key=lambda child: ORDER.index(child.tag))
        return text(self.root)


def _supply(model: _Model, robot: RobotFile) -> None:
    """Add the input (kPa) and the slide that follows it."""
    body = model.add("worldbody", "body", name="supply", gravcomp=1)
    add(body, "inertial", pos=np.zeros(3), mass=SUPPLY_KG, diaginertia=np.full(3, 1e-6))
    damping = SUPPLY_N_PER_M * robot.line_s
    add(body, "joint", name="pressure_kPa", type="slide", axis=(1, 0, 0), damping=damping)
    model.add(
        "actuator", "general", name="pressure_kPa", joint="pressure_kPa", gainprm=SUPPLY_N_PER_M,
        biastype="affine", biasprm=(0, -SUPPLY_N_PER_M, 0), ctrlrange=robot.valid.pressure_kPa,
    )  # fmt: skip
    model.add("sensor", "jointpos", name="pressure_kPa", joint="pressure_kPa")


def _springs(model: _Model, joint: Element, robot: RobotFile, coordinate: JointCoordinate) -> None:
    """Let a joint and two tendons to the pressure's slide give a law.

    With L = w ± s P, springs −k₁ L − k₂ L² of both tendons and of the joint sum to it.
    """
    a, b, c, d = _law_si(coordinate)
    name, first = joint.get("name", ""), -a / ARM
    both, apart = -d / ARM**2, -b / (2 * ARM)
    joint.set("damping", f"{damping(robot, coordinate):.7g}")
    joint.set("stiffness", f"{-c - first:.7g} {-both:.7g} 0")
    for sign, linear, square in ((1, first, (both + apart) / 2), (-1, 0.0, (both - apart) / 2)):
        if linear or square:
            tendon = model.add(
                "tendon", "fixed", name=f"{name}{'+' if sign > 0 else '-'}", springlength=0,
                stiffness=(linear, square, 0),
            )  # fmt: skip
            add(tendon, "joint", joint=name, coef=1)
            add(tendon, "joint", joint="pressure_kPa", coef=sign * ARM)


def _geom(
    model: _Model, body: Element, link: Link, origin: np.ndarray, bits: int, friction: float
) -> None:
    """Add the prism of a link: a box where its outline is a rectangle."""
    outline, name = np.array(link.section_mm), body.get("name", "")
    low = np.array([*outline.min(axis=0), link.from_mm])
    high = np.array([*outline.max(axis=0), link.to_mm])
    middle, half = (low + high) / 2, (high - low) / 2
    shape: dict[str, Any] = {"type": "box", "size": half * M_PER_MM}
    if not np.allclose(np.abs(outline - middle[:2]), half[:2]):
        corners = [(*corner, z) for z in (link.from_mm, link.to_mm) for corner in outline]
        model.add("asset", "mesh", name=name, vertex=(np.array(corners) - middle) * M_PER_MM)
        shape = {"type": "mesh", "mesh": name}
    add(
        body, "geom", name=name, pos=(middle - origin) * M_PER_MM, mass=0, group=3,
        rgba=(0.3, 0.5, 0.8, 0.5), contype=bits, conaffinity=ALL & ~bits,
        friction=(friction, *TURNING), **CONTACT, **shape,
    )  # fmt: skip


def _finger(
    model: _Model, parent: Element, robot: RobotFile, skin: BoundSkin, stand: Stand, prefix: str,
    bits: int, friction: float,
) -> None:  # fmt: skip
    """Add a finger below a body."""
    turned = Rotation.from_matrix(stand.rotation).as_quat(scalar_first=True)
    origins = [np.zeros(3), *(np.array(joint.place_mm) for joint in robot.joints)]
    body = add(parent, "body", name=f"{prefix}link_0", pos=stand.origin_mm * M_PER_MM, quat=turned)
    add(body, "site", name=f"{prefix}clamp", size=0.001)
    for number, (link, origin) in enumerate(zip(robot.links, origins, strict=True)):
        if number:
            step = (origin - origins[number - 1]) * M_PER_MM
            body = add(body, "body", name=f"{prefix}link_{number}", pos=step)
            for dof in robot.joints[number - 1].coordinates:
                joint = add(body, "joint", name=f"{prefix}{dof.name}", type=dof.kind, axis=dof.axis)
                _springs(model, joint, robot, dof)
        add(
            body, "inertial", pos=(np.array(link.centre_mm) - origin) * M_PER_MM,
            mass=link.mass_kg, fullinertia=np.array(link.inertia_kg_mm2) * M_PER_MM**2,
        )  # fmt: skip
        _geom(model, body, link, origin, bits, friction)
    tip = (np.array(robot.tip_mm) - origins[-1]) * M_PER_MM
    add(body, "site", name=f"{prefix}tip", pos=tip, size=0.001)
    model.add(
        "sensor", "framepos", name=f"{prefix}tip_m", objtype="site", objname=f"{prefix}tip",
        reftype="site", refname=f"{prefix}clamp",
    )  # fmt: skip

    def placed(points: np.ndarray) -> np.ndarray:
        places_m: np.ndarray = (points @ stand.rotation.T + stand.origin_mm) * M_PER_MM
        return places_m

    drawn = model.add(
        "deformable", "skin", name=f"{prefix}skin", rgba=(0.85, 0.45, 0.2, 1),
        vertex=placed(skin.points_mm), face=skin.triangles,
    )  # fmt: skip
    for number, (origin, weights) in enumerate(zip(origins, skin.weights, strict=True)):
        moved = np.flatnonzero(weights)
        if len(moved):  # a short link may have no corner of its own
            add(
                drawn, "bone", body=f"{prefix}link_{number}", bindpos=placed(origin),
                bindquat=turned, vertid=moved, vertweight=weights[moved],
            )  # fmt: skip


def finger(robot: RobotFile, skin: BoundSkin, friction: float) -> str:
    """Return the model of one finger that hangs down from its clamp.

    Args:
        robot: chain with its laws.
        skin: bound to its links.
        friction: of the finger on other bodies.

    Returns:
        Text of the MJCF file; its one input is the pressure in kPa.
    """
    model = _Model("finger", SWINGING)
    _supply(model, robot)
    height = 1.2 * robot.tip_mm[2]
    stand = Stand("finger", np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, height]))
    _finger(model, model.section("worldbody"), robot, skin, stand, "", 1, friction)
    least = min(_damping_s(dof) for joint in robot.joints for dof in joint.coordinates)
    return _STEPS.format(largest_ms=2e3 * least) + model.text()


def gripper(
    robot: RobotFile, skin: BoundSkin, stands: Sequence[Stand], friction: float,
    lift_mm_per_s: float,
) -> str:  # fmt: skip
    """Return the model of a gripper, whose base moves up and down.

    Args:
        robot: chain with its laws, of all fingers.
        skin: bound to its links.
        stands: places of the fingers.
        friction: of fingers on other bodies.
        lift_mm_per_s: speed up to which the base follows its input.

    Returns:
        Text of the MJCF file; its inputs are the pressure (kPa) of all fingers, and the height of
        the base above its start (m).
    """
    model = _Model("gripper")
    _supply(model, robot)
    base = model.add("worldbody", "body", name="base", gravcomp=1)
    add(base, "inertial", pos=np.zeros(3), mass=1, diaginertia=np.full(3, 0.01))
    add(base, "joint", name="lift_m", type="slide", axis=(0, 0, 1), damping=LIFT_N_S_PER_M)
    most_N = LIFT_N_S_PER_M * lift_mm_per_s * M_PER_MM
    model.add(
        "actuator", "position", name="lift_m", joint="lift_m", kp=100_000, ctrlrange=(-0.2, 0.5),
        forcerange=(-most_N, most_N),
    )  # fmt: skip
    for number, stand in enumerate(stands):
        prefix = f"{stand.name.split()[-1]}_"
        _finger(model, base, robot, skin, stand, prefix, 1 << number, friction)
    return model.text()


def _food(model: _Model, body: GraspedBody) -> dict[str, Any]:
    """Shape of the food's geom: a capsule where it is one, else the convex hull of its surface."""
    shape, turned = body.shape, np.eye(3)
    if isinstance(shape, TurnedShape):
        turned = shape.turn
        shape = shape.shape
    if isinstance(shape, Capsule):
        size = M_PER_MM * np.array([shape.radius_mm, shape.half_length_mm])
        quaternion = Rotation.from_matrix(turned).as_quat(scalar_first=True)
        return {"type": "capsule", "size": size, "quat": quaternion}
    model.add(
        "asset", "mesh", name="food", vertex=body.surface.points * M_PER_MM,
        face=body.surface.triangles, maxhullvert=MOST_CORNERS,
    )  # fmt: skip
    return {"type": "mesh", "mesh": "food"}


def scene(food: Food, body: GraspedBody, included: str) -> str:
    """Return the model of a gripper with a table and food.

    Args:
        food: with its friction.
        body: surface, mass and inertia.
        included: file of the gripper.

    Returns:
        Text of the MJCF file.
    """
    model = _Model("scene")
    model.add("", "include", file=included)
    model.add(
        "asset", "texture", type="skybox", builtin="gradient", rgb1=(1, 1, 1),
        rgb2=(0.75, 0.8, 0.88), width=64, height=384,
    )  # fmt: skip
    model.add("worldbody", "light", pos=(0, -0.5, 1), dir=(0, 0.5, -1))
    model.add(
        "worldbody", "camera", name="front", pos=(-0.232, -0.277, 0.177), fovy=35,
        xyaxes=(0.766, -0.643, 0, 0.199, 0.237, 0.951),
    )  # fmt: skip
    contact = {"contype": str(OTHERS), "conaffinity": str(ALL), **CONTACT}
    model.add(
        "worldbody", "geom", name="table", type="plane", size=(0.5, 0.5, 0.01),
        rgba=(0.8, 0.8, 0.8, 1), friction=(food.table_friction, *TURNING), **contact,
    )  # fmt: skip
    centre = np.array(body.body.centre_mm) * M_PER_MM
    held = model.add("worldbody", "body", name="food", pos=centre)
    add(held, "freejoint", name="food")
    inertia = body.body.inertia_kg_mm2[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]] * M_PER_MM**2
    add(held, "inertial", pos=np.zeros(3), mass=body.body.mass_kg, fullinertia=inertia)
    # of two bodies' coefficients MuJoCo takes the larger one, so the food's is 0
    add(
        held, "geom", name="food", rgba=(0.9, 0.8, 0.5, 1), mass=0, friction=(0, *TURNING),
        **contact, **_food(model, body),
    )  # fmt: skip
    return model.text()
