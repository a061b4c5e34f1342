r"""Parts as other people's programs write them: CAD by build123d, triangles by manifold3d.

The package draws with Gmsh; these files come from other kernels. Only this script needs these:

    python -m venv /tmp/cad && /tmp/cad/bin/pip install build123d==0.13.0 manifold3d==3.5.4 \
        trimesh==5.2.0 networkx lxml
    /tmp/cad/bin/python tests/meshes/parts/make.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import trimesh
from build123d import (
    Align,
    Box,
    Cylinder,
    Location,
    Part,
    Plane,
    Pos,
    Rot,
    export_step,
)
from manifold3d import CrossSection, Manifold

HERE = Path(__file__).parent
CENTRE, LOW = Align.CENTER, Align.MIN


def box(x: float, y: float, z: float, at: tuple[float, float, float]) -> Part:
    """A box centred in x and y on a place, and from there up in z."""
    return Pos(*at) * Box(x, y, z, align=(CENTRE, CENTRE, LOW))


def slit_finger() -> Part:
    """A bar along z with a channel at x = 0, and slits from the side +x down between chambers.

    The back is the side −x. A thick roof brings the chambers' centre to the back's side.
    """
    bar = box(20, 18, 56, (0, 0, 0))
    bar -= box(4, 4, 51, (-6, 0, 0))
    for i in range(4):
        bar -= box(9, 13, 6, (-3.5, 0, 6 + 12 * i))
    for i in range(3):
        bar -= box(15, 20, 1.6, (4.5, 0, 14.2 + 12 * i))
    return bar


def half_round() -> Part:
    """A half-round tube of 2 mm walls all around; the flat side −x is 2.6 mm thick."""
    half = box(20, 40, 80, (10, 0, 0))
    outer = half & Cylinder(11, 80, align=(CENTRE, CENTRE, LOW))
    inner = (half & Cylinder(9, 76, align=(CENTRE, CENTRE, LOW))) & box(20, 40, 76, (12.6, 0, 0))
    return outer - inner


def three_chambers() -> Part:
    """A round bar with three closed round chambers, 120° apart, none of them in a file's plane."""
    bar = Cylinder(13, 70, align=(CENTRE, CENTRE, LOW))
    for i in range(3):
        at = math.radians(17 + 120 * i)
        bar -= Pos(7 * math.cos(at), 7 * math.sin(at), 4) * Cylinder(
            3.5, 62, align=(CENTRE, CENTRE, LOW)
        )
    return bar


def thick_back() -> Part:
    """A square tube of 2 mm walls, of which the one at +x has 2.3 mm."""
    return box(18.3, 18, 80, (0.15, 0, 0)) - box(14, 14, 76, (0, 0, 0))


def suction_cup() -> Manifold:
    """A bellows cup of two folds, with an opening of 3 mm in its neck and a wide mouth."""
    outer = [(4, 0), (4, 6), (11, 10), (7, 14), (13, 20), (14, 24)]
    inner = [(12.2, 24), (11.2, 20.6), (5.2, 14), (9, 10), (3, 7.6), (1.5, 6), (1.5, 0)]
    return Manifold.revolve(CrossSection([[*outer, *inner]]), 32)


def collared_tube() -> Manifold:
    """A round tube with an end, on a wide collar."""
    tube = Manifold.cylinder(60, 8, circular_segments=32)
    collar = Manifold.cylinder(6, 13, circular_segments=32)
    bore = Manifold.cylinder(57, 5.5, circular_segments=32).translate((0, 0, -1))
    return (tube + collar) - bore


def triangles(solid: Manifold) -> trimesh.Trimesh:
    """The surface of a solid."""
    mesh = solid.to_mesh()
    return trimesh.Trimesh(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts))


def main() -> None:
    """Write all parts."""
    # along x, slits up; along y, slits towards −x: one of them turned against the other
    export_step(Rot(0, 90, 0) * Rot(0, 0, 180) * slit_finger(), HERE / "slits_up.step")
    export_step(
        Location((30, -5, 12)) * Rot(-90, 0, 0) * Rot(0, 0, 180) * slit_finger(),
        HERE / "slits_left.step",
    )
    export_step(half_round().moved(Location(Plane.XY)), HERE / "half_round.step")
    export_step(three_chambers(), HERE / "three_chambers.step")
    export_step(thick_back(), HERE / "thick_back.step")
    triangles(suction_cup()).export(HERE / "suction_cup.stl")
    triangles(collared_tube()).export(HERE / "collared_tube.3mf")


if __name__ == "__main__":
    main()
