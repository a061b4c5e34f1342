"""What the faces of a part are taken for: cavities, clamp, tip, sides, symmetry.

The finger's frame: the clamp is the plane z = 0, the tip lies towards +z, the side that limits
strain is the lowest x, and what is symmetric is so in y = 0.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from dolfingrip.meshes.adoption.hollows import Hollow, Opening, hollow_of, hollows
from dolfingrip.meshes.adoption.sound import bearing_centre, place
from dolfingrip.meshes.adoption.surface import FacePolicy, Faces
from dolfingrip.meshes.closed_surface import nearest
from dolfingrip.meshes.groups import CLAMP, SKIN, TIP, cavity_names
from dolfingrip.meshes.groups import cavities as cavities_of
from dolfingrip.meshes.solid import Floats, MeshError

Point = tuple[float, float, float]
Box = tuple[float, float, float, float, float, float]


def said_of(region: Box | str) -> str:
    """A held region as it is given."""
    return region if isinstance(region, str) else ",".join(f"{value:g}" for value in region)


@dataclass(frozen=True, slots=True)
class Asked:
    """Corrections by the user, in the file's coordinates (mm).

    Attributes:
        cavities: of each cavity a point in or on it, (3,), or points all over its walls, (k, 3);
            the largest hollow where empty, or all closed ones.
        cavity_files: files with the walls of further cavities.
        held: boxes (two corners), or names of solids or regions, whose content is held: it stays
            where it is, and what borders on it is the clamp.
        clamp, tip: points on these faces.
        back: direction that the side that limits strain faces.
        whole: keep both halves of a symmetric part.
        repair: close the holes of triangles.
    """

    cavities: Sequence[Point | Floats] = ()
    cavity_files: Sequence[Path] = ()
    held: Sequence[Box | str] = ()
    clamp: Point | None = None
    tip: Point | None = None
    back: Point | None = None
    whole: bool = False
    repair: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Roles:
    """Roles that a part's faces are taken for.

    Attributes:
        asked: corrections by the user.
        surface: the part in the finger's frame.
        groups: (m,) name of each triangle's group.
        rotation: (3, 3) R, and
        origin_mm: (3,) o: a point X of the file lies at R (X − o).
        cavities: one or several.
        caps: openings that must be closed, in the file's coordinates.
        even: whether it is its own mirror image in y = 0.
        tip_from_mm: z from which the outer side is the tip, where no face ends it.
        said: what was taken for what, in sentences, by name.
    """

    asked: Asked
    surface: Faces
    groups: np.ndarray
    rotation: Floats
    origin_mm: Floats
    cavities: list[Hollow]
    caps: list[Opening]
    even: bool
    tip_from_mm: float | None = None
    said: dict[str, str] = field(default_factory=dict)

    @property
    def named(self) -> dict[str, Hollow]:
        """The cavities by name."""
        return dict(zip(cavity_names(len(self.cavities)), self.cavities, strict=True))

    @property
    def half(self) -> bool:
        """True if the half y ≥ 0 is meshed."""
        return self.even and not self.asked.whole

    def as_whole(self, why: str) -> Roles:
        """These roles for a mesh of both halves."""
        said = {**self.said, "symmetry": why}
        return replace(self, asked=replace(self.asked, whole=True), said=said)


def assign(
    surface: Faces,
    hints: Asked,
    masks: Mapping[str, np.ndarray] | None = None,
    centre: Floats | None = None,
) -> Roles:
    """Take the faces of a part for cavities, clamp and tip, and find its frame.

    Args:
        surface: the part, closed, in the file's coordinates.
        hints: corrections.
        masks: (m,) triangles of the groups that the file itself has.
        centre: (3,) centre of gravity, if it is known better than from the triangles.

    Raises:
        MeshError: one line, if there is no face to clamp, or no cavity where one is asked for.
    """
    said: dict[str, str] = {}
    masks = masks or {}
    clamp, held = masks.get(CLAMP), -1
    if clamp is not None:
        held = int(surface.face.max()) + 1
        surface = replace(surface, face=np.where(clamp, held, surface.face))
    voids, shell = hollows(surface, held)
    outer = shell == np.bincount(shell, surface.volumes).argmax()
    of_file = _known_cavities(surface, masks, said)
    cavities = of_file or _cavities(surface, voids, hints, said)
    if clamp is None:
        inside = np.zeros(len(outer), dtype=bool)
        for hollow in cavities:
            inside[hollow.triangles] = True
        clamp = _clamp(surface, outer & ~inside, cavities, hints, said)
    z = _axis(surface, clamp)
    if cavities and not (of_file or hints.cavities):  # of as large ones the nearest to the clamp
        most = cavities[0].volume_mm3
        cavities.sort(key=lambda one: (-round(one.volume_mm3 / most, 2), one.centre_mm @ z))
    names = cavity_names(max(len(cavities), 1))
    for name, hollow in zip(names, cavities, strict=False):
        said.setdefault(name, _of_hollow(hollow))
    x = _front(surface, cavities, z, hints, said)
    rotation, base = np.stack([x, np.cross(z, x), z]), _base(surface, clamp, z)
    centre = _centroid(surface) if centre is None else centre
    origin = _origin(surface.points[np.unique(surface.triangles[outer])], rotation, centre, base)
    framed = surface.moved(rotation, origin)
    groups = np.full(len(outer), SKIN, dtype="<U16")
    groups[clamp] = CLAMP
    for name, hollow in zip(names, cavities, strict=False):
        groups[hollow.triangles] = name
    tip, start = masks.get(TIP), None
    if tip is None:
        tip, start = _tip(framed, groups == SKIN, hints, rotation, origin, said)
    groups[tip] = TIP
    said |= {name: "group of the file" for name in (CLAMP, TIP) if name in masks}
    if CLAMP in masks and not _is_plane(surface, clamp, z):
        said[CLAMP] += f"; what it surrounds gives way (--clamp-region {CLAMP} holds it as a whole)"
    if hints.held:
        area = surface.areas[clamp].sum()
        said[CLAMP] = f"{area:.4g} mm² where what --clamp-region holds ends, at {place(base)}"
    caps = _caps(surface, clamp, cavities, said)
    even = _is_even(framed, groups, hints, said)
    said = {name: said[name] for name in names} | said
    return Roles(hints, framed, groups, rotation, origin, cavities, caps, even, start, said)


def _base(surface: Faces, clamp: np.ndarray, z: Floats) -> Floats:
    """A point of the clamp, (3,), from whose level on the part is free."""
    base = np.average(surface.middles[clamp], axis=0, weights=surface.areas[clamp])
    if not _is_plane(surface, clamp, z):
        base += z * ((surface.points[surface.triangles[clamp]] - base) @ z).max()
    return np.asarray(base)


def _origin(outside: Floats, rotation: Floats, centre: Floats, base: Floats) -> Floats:
    """The origin, (3,): the lowest x of the outside, the y of the centre, the z of the clamp.

    A plane that misses a part's own seam by rounding errors would cut off slivers.
    """
    lowest = (outside @ rotation.T)[:, 0].min()
    level = np.array([lowest, (rotation @ centre)[1], (rotation @ base)[2]])
    return np.asarray(rotation.T @ np.round(level, 6))


def _caps(
    surface: Faces, clamp: np.ndarray, cavities: list[Hollow], said: dict[str, str]
) -> list[Opening]:
    """The openings away from the clamp."""
    of_clamp = surface.triangles[clamp]
    openings = [opening for hollow in cavities for opening in hollow.openings]
    caps = [opening for opening in openings if not np.isin(opening.rim, of_clamp).all()]
    for opening in caps:
        across = 2 * np.sqrt(opening.area_mm2 / np.pi)
        said["cap"] = (
            f"closes {len(caps)} opening{'s' if len(caps) > 1 else ''} away from the clamp, one of "
            f"{across:.3g} mm at {place(opening.centre_mm)}"
        )
    return caps


def _is_even(framed: Faces, groups: np.ndarray, hints: Asked, said: dict[str, str]) -> bool:
    """Return whether a part is its own mirror image in y = 0."""
    off_mm, near_mm = _off_mm(framed, groups), framed.policy.even * framed.extent
    even = off_mm <= near_mm
    said["symmetry"] = f"{_of_symmetry(even, hints)}; {_compared(off_mm, near_mm)}"
    return even


def _of_symmetry(even: bool, hints: Asked) -> str:
    if even and hints.whole:
        return "is there, but the whole is asked for (--whole)"
    return "the half y ≥ 0 is computed (--whole: both)" if even else "none; the whole is computed"


def _centroid(surface: Faces) -> Floats:
    return np.asarray(0.75 * surface.middles.T @ surface.volumes / surface.volumes.sum())


def _axis(surface: Faces, clamp: np.ndarray) -> Floats:
    """The direction z from the clamp into the part, (3,)."""
    vector = -surface.vectors[clamp].sum(axis=0)
    if np.linalg.norm(vector) < surface.policy.faces * surface.areas[clamp].sum():
        # it faces all ways, such as a collar's outside
        centre = _centroid(surface)
        spread = (surface.middles - centre) * np.sqrt(surface.areas)[:, None]
        along = np.linalg.svd(spread, full_matrices=False)[2][0]
        vector = along * np.sign((centre - surface.middles[clamp].mean(axis=0)) @ along)
    z = vector / np.linalg.norm(vector)
    return z if _is_plane(surface, clamp, z) else snapped(z)


def _is_plane(surface: Faces, clamp: np.ndarray, z: Floats) -> bool:
    level = surface.points[surface.triangles[clamp]] @ z
    return bool(np.ptp(level) <= 2 * surface.near_mm)


def _compared(off_mm: float, near_mm: float) -> str:
    """How far a part is from its mirror image, beside what is allowed."""
    if not np.isfinite(off_mm):
        return "its cavities are not one another's mirror images"
    return f"{off_mm:.2g} mm from its mirror image, where up to {near_mm:.2g} mm counts as one"


def _cavities(
    surface: Faces, voids: list[Hollow], hints: Asked, said: dict[str, str]
) -> list[Hollow]:
    """The hollows that are asked for; else all closed ones, or the largest with an opening."""
    if not voids:
        none = "no closed shell inside, and no opening with a sharp rim"
        if hints.cavities:
            raise MeshError(f"no cavity: {none}; allowed: a solid with a hollow")
        said["cavity"] = f"none: {none}; it is a solid body, which no pressure moves"
        return []
    if hints.cavities:
        chosen = [_nearest(surface, voids, np.atleast_2d(point)) for point in hints.cavities]
        if len({id(hollow) for hollow in chosen}) < len(chosen):
            raise MeshError("--cavity: two points at one hollow; allowed: one point for each")
    else:
        large = [h for h in voids if h.volume_mm3 > surface.policy.small * voids[0].volume_mm3]
        closed = [h for h in large if not h.openings]
        alike = [h for h in large if h.volume_mm3 > surface.policy.alike * large[0].volume_mm3]
        chosen = closed or alike
    others = [h for h in voids if all(h is not c for c in chosen)]
    if others:
        said["other hollows"] = (
            f"{len(others)}, the largest of {others[0].volume_mm3:.3g} mm³ around "
            f"{place(others[0].centre_mm)}: skin (--cavity: a cavity); the smallest cavity has "
            f"{min(h.volume_mm3 for h in chosen) / others[0].volume_mm3:.2g} times as much"
        )
    return chosen


def _of_hollow(hollow: Hollow) -> str:
    """A hollow in words."""
    kind = "closed"
    if hollow.openings:
        kind = "with an opening at " + " and ".join(place(o.centre_mm) for o in hollow.openings)
    return f"{hollow.volume_mm3:.4g} mm³ around {place(hollow.centre_mm)}, {kind}"


def _known_cavities(
    surface: Faces, masks: Mapping[str, np.ndarray], said: dict[str, str]
) -> list[Hollow]:
    """The cavities that the file has groups of."""
    cavities = []
    for name in cavities_of(masks):
        cavities.append(hollow_of(surface, np.flatnonzero(masks[name])))
        said[name] = "group of the file"
    return cavities


def _nearest(surface: Faces, voids: list[Hollow], points: Floats) -> Hollow:
    """The hollow that a point is in or on, or that has most of some points on its walls."""
    distance = [
        float(nearest(surface.points, surface.triangles[hollow.triangles], points)[1].mean())
        for hollow in voids
    ]
    return voids[int(np.argmin(distance))]


def _clamp(
    surface: Faces, free: np.ndarray, cavities: list[Hollow], hints: Asked, said: dict[str, str]
) -> np.ndarray:
    """Mask, (m,): whether a triangle is clamped: all plane faces in one plane."""
    near = surface.near_mm
    if hints.clamp is not None:
        row = _nearest_triangle(surface, free, np.asarray(hints.clamp))
        if not surface.plane[surface.face[row]]:
            raise MeshError(
                f"--clamp {place(np.asarray(hints.clamp))}: a curved face; allowed: a plane one"
            )
        chosen, margin = surface.face[row], "as asked"
    else:
        chosen, margin = _largest_end(surface, free, cavities)
    normal = surface.face_vectors[chosen] / np.linalg.norm(surface.face_vectors[chosen])
    level = surface.middles[surface.face == chosen].mean(axis=0) @ normal
    flat = surface.plane[surface.face] & (surface.normals @ normal > np.cos(np.radians(1.0)))
    clamped = np.asarray(free & flat & (np.abs(surface.middles @ normal - level) <= near))
    area = surface.areas[clamped].sum()
    at = np.average(surface.middles[clamped], axis=0, weights=surface.areas[clamped])
    said["clamp"] = f"plane face of {area:.4g} mm² at {place(at)}, {margin}"
    if (surface.points[surface.triangles[free]] @ normal).max() > level + near:
        said["clamp"] += ", not at an end"
    return clamped


def _largest_end(surface: Faces, free: np.ndarray, cavities: list[Hollow]) -> tuple[int, str]:
    """The plane face with all of the part on one side, across the long axis, and largest.

    Of two that are as large, it is the one that is nearer to the file's origin.

    Returns:
        Its number, and how clear the choice is.
    """
    near = surface.near_mm
    length = np.linalg.norm(surface.face_vectors, axis=1)
    faces = [f for f in np.unique(surface.face[free]) if surface.plane[f]]
    points = surface.points[np.unique(surface.triangles)]
    middle = np.average(surface.middles, axis=0, weights=surface.areas)
    spread = (surface.middles - middle) * np.sqrt(surface.areas)[:, None]
    along = np.linalg.svd(spread, full_matrices=False)[2][0]
    supplies: list[Opening] = []
    mouths: list[Opening] = []
    for hollow in cavities:
        least = min((opening.area_mm2 for opening in hollow.openings), default=0.0)
        for opening in hollow.openings:
            wide = opening.area_mm2 > surface.policy.mouth * least
            (mouths if wide else supplies).append(opening)
    ends: dict[bool, list[tuple[float, float, int]]] = defaultdict(list)
    for face in faces:
        normal = surface.face_vectors[face] / length[face]
        middles = surface.middles[surface.face == face]
        level = middles[0] @ normal
        if (points @ normal).max() > level + near:
            continue
        area = length[face]
        into = [o for o in supplies if abs(o.centre_mm @ normal - level) <= near]
        if not into and any(abs(o.centre_mm @ normal - level) <= near for o in mouths):
            continue
        if into:
            area = surface.policy.supplied * (area + sum(opening.area_mm2 for opening in into))
        end = bool(abs(normal @ along) > np.cos(np.radians(surface.policy.end_deg)))
        away = float(np.linalg.norm(middles.mean(axis=0)))
        ends[end].append((area, away, int(face)))
    if not ends:
        raise MeshError(
            "no plane face at an end to clamp; allowed: such a face, or --clamp with a point on "
            "another"
        )
    order = sorted(ends.get(True, ends[False]), reverse=True)
    alike = [one for one in order if one[0] > (1 - surface.policy.alike_area) * order[0][0]]
    if len(alike) > 1:
        face = min(alike, key=lambda one: one[1])[2]
        return face, "nearer to the file's origin than one as large (--clamp: another)"
    if len(order) == 1:
        return order[0][2], "the only one at an end"
    return order[0][2], f"{order[0][0] / order[1][0]:.3g} times as likely as the next, by its area"


def _nearest_triangle(surface: Faces, among: np.ndarray, point: Floats) -> int:
    """The triangle that is nearest to a point."""
    rows = np.flatnonzero(among)
    return int(rows[nearest(surface.points, surface.triangles[rows], point[None])[0][0]])


def _front(
    surface: Faces, cavities: list[Hollow], z: Floats, hints: Asked, said: dict[str, str]
) -> Floats:
    """The direction x from the side that limits strain to the other, (3,)."""
    across = np.eye(3) - np.outer(z, z)
    centre = _centroid(surface)
    around = across @ np.cov((surface.middles - centre).T, aweights=surface.areas) @ across
    principal = np.linalg.eigh(around)[1].T[::-1][:2]
    axes = [a / np.linalg.norm(a) for a in np.eye(3) @ across if np.linalg.norm(a) > 0.5]
    sides = _plane_sides(surface, z)
    of_file = [snapped(a, sides) for a in axes]
    axes = [*of_file, *sides, *principal]
    if hints.back is not None:
        given = across @ -np.asarray(hints.back, dtype=float)
        if np.linalg.norm(given) < 1e-3 * np.linalg.norm(hints.back):
            raise MeshError(f"--back {hints.back}: along the finger; allowed: a direction across")
        x = snapped(given / np.linalg.norm(given), sides, surface.policy.flat_deg)
        said["back"] = f"faces {direction_said(-x)}, as asked"
        return np.asarray(x)
    away: Floats = np.zeros(3)
    aside, reason = away, "nothing presses on it"
    if cavities:
        rows = np.concatenate([hollow.triangles for hollow in cavities])
        level = surface.middles[rows] @ z
        along = np.stack([principal[0], np.cross(z, principal[0]), z])
        bearing = bearing_centre(surface, (level.min(), level.max()), along)
        volume = sum(hollow.volume_mm3 for hollow in cavities)
        hollow = sum(h.volume_mm3 * h.centre_mm for h in cavities) / volume
        away = across @ (hollow - (centre if bearing is None else bearing))
        aside = across @ (cavities[0].centre_mm - centre)
    width = float(np.ptp(surface.points @ principal.T, axis=0).min())
    least = surface.policy.same_side * width
    if cavities:
        reason = (
            "the pressure's lever about the walls that run through is "
            f"{np.linalg.norm(away):.2g} mm, where {least:.2g} mm tell a side"
        )
    if np.linalg.norm(away) < least < np.linalg.norm(aside):
        away, reason = aside, f"opposite to the first cavity, as {reason}"
    if np.linalg.norm(away) < least:
        # the axes of the file come first, and another one must be clearly better
        narrow = [float(np.ptp(surface.points @ a)) for a in axes]
        x = axes[next(i for i, mm in enumerate(narrow) if mm < 1.05 * min(narrow))]
        said["back"] = (
            f"faces {direction_said(-x)}, by its shape: it does not bend by itself, as {reason} "
            "(--back: another direction)"
        )
        return np.asarray(x)
    x = away = away / np.linalg.norm(away)
    for some in (sides, of_file, principal):
        x = snapped(away, some)
        if x is not away:
            break
    said["back"] = f"faces {direction_said(-x)}: {reason} (--back: another direction)"
    return np.asarray(x)


def _plane_sides(surface: Faces, z: Floats) -> list[Floats]:
    """Unit normals of plane faces along z that the whole part lies behind, the largest first."""
    normals, points = [], surface.points[np.unique(surface.triangles)]
    steepest = np.radians(surface.policy.flat_deg)
    for face in np.argsort(-surface.face_areas, kind="stable"):
        vector = surface.face_vectors[face]
        along = abs(float(vector @ z)) < steepest * surface.face_areas[face]
        if along and surface.plane[face]:
            normal = vector - (vector @ z) * z
            normal /= np.linalg.norm(normal)
            on_face = surface.points[surface.triangles[surface.face == face]] @ normal
            if (points @ normal).max() - on_face.min() <= surface.near_mm:
                normals.append(normal)
    return normals


def snapped(
    vector: Floats,
    directions: Sequence[Floats] | Floats | None = None,
    deg: float = FacePolicy().snap_deg,
) -> Floats:
    """Return the nearest of some directions and their opposites, if it is near enough.

    Args:
        vector: (3,) unit vector in the file's coordinates.
        directions: (k, 3) unit vectors; None: the file's axes.
        deg: angle up to which one of them is near enough.

    Returns:
        (3,) unit vector; the vector itself, where none is.
    """
    axes = np.eye(3) if directions is None else directions
    both = [sign * axis for axis in axes for sign in (1, -1)]
    nearest = max(both, key=lambda way: float(way @ vector), default=vector)
    return nearest if nearest @ vector > np.cos(np.radians(deg)) else vector


def direction_said(vector: Floats) -> str:
    """A direction in words.

    Args:
        vector: (3,) unit vector in the file's coordinates.

    Returns:
        The axis of the file that it is along, or its coordinates.
    """
    for i, letter in enumerate("xyz"):
        if abs(vector[i]) > 1 - 1e-6:
            return f"{'+' if vector[i] > 0 else '−'}{letter} of the file"
    return "(" + ", ".join(f"{round(value, 3) + 0.0:g}" for value in vector) + ") of the file"


def _tip(
    framed: Faces, skin: np.ndarray, hints: Asked, rotation: Floats, origin: Floats,
    said: dict[str, str],
) -> tuple[np.ndarray, float | None]:  # fmt: skip
    """Triangles (m,) of the tip: the face at the free end, or the end's last part and its start."""
    z = framed.points[:, 2]
    length = float(z[framed.triangles[skin]].max())
    if hints.tip is not None:
        point = (np.asarray(hints.tip) - origin) @ rotation.T
        row = _nearest_triangle(framed, skin, point)
        chosen = skin & (framed.face == framed.face[row])
        said["tip"] = f"face of {framed.areas[chosen].sum():.4g} mm², as asked"
        return chosen, None
    top = z[framed.triangles].min(axis=1) > length * (1 - framed.policy.near)
    across = framed.normals[:, 2] > np.cos(np.radians(framed.policy.end_deg))
    flat = skin & top & across & framed.plane[framed.face]
    if flat.any():
        said["tip"] = f"plane face of {framed.areas[flat].sum():.4g} mm² at the free end"
        return flat, None
    faces = np.unique(framed.face[skin & (z[framed.triangles].max(axis=1) > length * 0.999)])
    ends = [f for f in faces if framed.face_vectors[f, 2] > 0.7 * framed.face_areas[f]]
    curved = skin & np.isin(framed.face, ends)
    if len(ends) and z[framed.triangles[curved]].min() > 0.7 * length:
        said["tip"] = f"curved face of {framed.areas[curved].sum():.4g} mm² at the free end"
        return curved, None
    share = framed.policy.tip_share
    while not (late := skin & (framed.middles[:, 2] > (1 - share) * length)).any():
        share *= 2
    said["tip"] = f"the last {share * length:.3g} mm of the free end (--tip: a face)"
    return late, (1 - share) * length


def _off_mm(framed: Faces, groups: np.ndarray) -> float:
    """Distance of a part from its mirror image in y = 0; infinite if a group is another one's."""
    from dolfingrip.meshes.closed_surface import ClosedSurface

    used = np.unique(framed.triangles)
    rng = np.random.default_rng(0)
    chosen = rng.choice(used, min(len(used), 3000), replace=False)
    image = framed.points[chosen] * [1.0, -1.0, 1.0]
    near = framed.policy.even * framed.extent
    away = ClosedSurface(framed.points, framed.triangles).distances_mm(image)
    for name in (CLAMP, *cavities_of(np.unique(groups))):
        mine = groups == name
        image = framed.middles[mine] * [1.0, -1.0, 1.0]
        _, off = nearest(framed.points, framed.triangles[mine], image)
        if framed.areas[mine][off < near].sum() < 0.9 * framed.areas[mine].sum():
            return float("inf")
    return float(np.abs(away).max())
