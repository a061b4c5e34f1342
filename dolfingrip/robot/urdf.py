"""A finger as URDF: links, joints, damping, inertia and collision; control.py has the laws.

Damping is the simulator's: as a torque from outside, it would stand by itself on links that have a
thousandth of the mass, and need steps of 5 µs.
"""

from __future__ import annotations

import itertools
from typing import Final
from xml.etree.ElementTree import Element

import numpy as np

from dolfingrip.files.robot import Link, RobotFile
from dolfingrip.files.xml import add, text
from dolfingrip.robot.mjcf import M_PER_MM, damping

BETWEEN: Final = 1e-3
"""Part of a link's mass and inertia that each link between the joints of its place has, as most
readers refuse links without."""

KINDS: Final = {"slide": "prismatic", "hinge": "revolute"}

REACH: Final = {"slide": 0.05, "hinge": 3.1}
"""Limits of joints, in m and rad, which URDF must have; one joint may turn as the whole finger."""


def _massive(root: Element, name: str, link: Link, origin: np.ndarray, part: float) -> Element:
    """Add a link with a part of a link's mass and inertia."""
    made = add(root, "link", name=name)
    inertial = add(made, "inertial")
    add(inertial, "origin", xyz=(np.array(link.centre_mm) - origin) * M_PER_MM)
    add(inertial, "mass", value=part * link.mass_kg)
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = [part * moment * M_PER_MM**2 for moment in link.inertia_kg_mm2]
    add(inertial, "inertia", **dict(zip(names, values, strict=True)))
    return made


def _link(root: Element, name: str, link: Link, origin: np.ndarray, between: int = 0) -> None:
    made = _massive(root, name, link, origin, 1 - between * BETWEEN)
    outline = np.array(link.section_mm)
    low = np.array([*outline.min(axis=0), link.from_mm])
    high = np.array([*outline.max(axis=0), link.to_mm])
    for part in ("visual", "collision"):
        drawn = add(made, part)
        add(drawn, "origin", xyz=((low + high) / 2 - origin) * M_PER_MM)
        add(add(drawn, "geometry"), "box", size=(high - low) * M_PER_MM)


def finger(robot: RobotFile) -> str:
    """Return the model of one finger, in the axes of its clamp.

    Args:
        robot: chain with its laws.

    Returns:
        Text of the URDF file, in m and kg; joints have the names that robot.json has.
    """
    root = Element("robot", name="finger")
    _link(root, "link_0", robot.links[0], np.zeros(3))
    above = "link_0"
    origin: np.ndarray = np.zeros(3)
    for number, (joint, link) in enumerate(zip(robot.joints, robot.links[1:], strict=True), 1):
        place: np.ndarray = np.array(joint.place_mm)
        between = [f"link_{number}_{coordinate.name}" for coordinate in joint.coordinates[:-1]]
        chained = itertools.pairwise([above, *between, f"link_{number}"])
        for coordinate, (first, name) in zip(joint.coordinates, chained, strict=True):
            made = add(root, "joint", name=coordinate.name, type=KINDS[coordinate.kind])
            add(made, "parent", link=first)
            add(made, "child", link=name)
            add(made, "origin", xyz=(place - origin) * M_PER_MM)
            add(made, "axis", xyz=coordinate.axis)
            reach = REACH[coordinate.kind]
            add(made, "limit", lower=-reach, upper=reach, effort=1000, velocity=1000)
            add(made, "dynamics", damping=damping(robot, coordinate), friction=0)
            origin = place
        for name in between:  # only there as URDF's joints have one coordinate each
            _massive(root, name, link, place, BETWEEN)
        above = f"link_{number}"
        _link(root, above, link, place, len(between))
    return '<?xml version="1.0"?>\n' + text(root)
