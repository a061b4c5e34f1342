"""The numbers that decide what a part's faces are taken for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FacePolicy:
    """How faces and openings are recognised, and taken for clamp, tip and sides.

    Attributes:
        flat_deg: angle between neighbouring triangles, and from a face's mean, up to which a face
            is plane.
        crease_deg: angle between neighbouring triangles from which they are two faces.
        wider: width of a plane face, by that of what follows it without a crease.
        near: distance, relative to a part's extent, up to which points lie in one plane.
        rim: length of an opening's rim on a curved face, by that of the face's longest edge.
        convex: share of a rim's length that must be a convex edge.
        directions: ways in which the outermost points are sought, which tell out from in.
        faces: area vector of a clamp by its area, above which it faces one way.
        end_deg: angle between an end's face and the long axis's normal plane.
        mouth: area of an opening by the smallest one's of the same hollow, from which it is no air
            supply but a cup's mouth.
        supplied: weight of an end's face into which air can be led.
        alike_area: relative difference up to which two ends' faces are as large.
        tip_share: part of the length at the free end that is the tip where no face ends it.
        lines: lines along the part, across its widest side, along which its walls are read.
        ends: share of the cavity's length at either end that these lines leave out.
        bearing: power of a line's share in the solid that weights what the line bears.
        same_side: lever of the pressure about the walls, by the width across, from which it tells
            the side that bends outwards.
        snap_deg: angle within which that side is taken along an axis of the file or of inertia.
        even: distance of a mirror image, relative to the extent, up to which a part is symmetric.
        small: volume of a hollow, by the largest's, below which it is not taken for a cavity.
        alike: the same of hollows with openings.
    """

    flat_deg: float = 0.5
    crease_deg: float = 30.0
    wider: float = 3.0
    near: float = 1e-3
    rim: float = 0.5
    convex: float = 0.9
    directions: int = 500
    faces: float = 0.1
    end_deg: float = 25.0
    mouth: float = 2.0
    supplied: float = 1.5
    alike_area: float = 1e-3
    tip_share: float = 0.05
    lines: int = 150
    ends: float = 0.05
    bearing: float = 100.0
    same_side: float = 0.005
    snap_deg: float = 10.0
    even: float = 1e-3
    small: float = 0.02
    alike: float = 0.5


@dataclass(frozen=True, slots=True)
class CapPolicy:
    """How caps close openings of a surface of triangles.

    Attributes:
        thickness: thicknesses that are tried, by the one that is asked for.
        about: depths that are as good as the one that is tried, by that one.
        miss: distance of the cap's plane from all corners, by its depth, below which cutting there
            leaves slivers.
        widens: area of a cap's inner side by the opening's, up to which a passage is even.
    """

    thickness: tuple[float, ...] = (1.0, 0.7, 0.5, 0.35, 0.25)
    about: tuple[float, ...] = (1.0, 0.98, 1.02, 0.96, 1.04, 0.94, 1.06, 0.92, 1.08)
    miss: float = 2e-3
    widens: float = 1.5


@dataclass(frozen=True, slots=True)
class SizePolicy:
    """How the size of elements follows from a part's walls.

    Attributes:
        samples: places at which walls and gaps are measured.
        opposite_deg: angle within which two sides of a wall face away from one another.
        thin: share of the surface that may belong to thinner walls than the thinnest one counted.
        by_wall: size of elements by the thinnest wall.
        most_by_wall: largest size by the thinnest wall: one quadratic element bears the bending of
            a wall if it is not much flatter than that.
        across: least number of elements across the part.
        curved: elements around a full turn of a curved face.
        most: largest number of elements that is made unasked.
        filled: volume of a tetrahedron by the cube of its size.
        cap_walls: thickness of a cap by the thinnest wall.
        into_wall: how far a cap reaches into the wall around it, by that wall's thickness.
        sliver: quality of tetrahedra (inscribed by circumscribed radius, 1 at best) below which
            another size is tried.
        poor: least scaled Jacobian below which half a part of triangles is not taken.
        tried: sizes that are tried, by the one that the walls ask for.
    """

    samples: int = 3000
    opposite_deg: float = 45.0
    thin: float = 0.01
    by_wall: float = 1.5
    most_by_wall: float = 2.5
    across: float = 4.0
    curved: float = 12.0
    most: int = 300_000
    filled: float = 0.118
    cap_walls: float = 1.5
    into_wall: float = 0.4
    sliver: float = 0.05
    poor: float = 0.01
    tried: tuple[float, ...] = (1.0, 0.93, 0.86, 0.8)
