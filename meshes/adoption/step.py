"""A part from a STEP file, in the OpenCASCADE kernel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np
from scipy.spatial.transform import Rotation

from dolfingrip.meshes import groups
from dolfingrip.meshes.adoption.capping import capped
from dolfingrip.meshes.adoption.facets import OPTIONS, meshed, outward, triangulated
from dolfingrip.meshes.adoption.formats import CAD
from dolfingrip.meshes.adoption.hollows import Opening
from dolfingrip.meshes.adoption.roles import Asked, Box, Roles, assign, said_of
from dolfingrip.meshes.adoption.sizes import MeshRequest, WallSizes, measured
from dolfingrip.meshes.adoption.sound import check_crossings, check_watertight, place
from dolfingrip.meshes.adoption.stl import meshed_triangles
from dolfingrip.meshes.adoption.surface import Faces, united
from dolfingrip.meshes.gmsh_model import import_shapes, session
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh

UNNAMED = "Open CASCADE STEP translator"
"""How OpenCASCADE names solids that have no name."""

FINENESS = (1.0, 3.0)
"""Meshes that show the faces: the second, finer one is made where the first crosses itself."""


def adopt_step(
    path: Path, hints: Asked, wanted: MeshRequest, scale: float
) -> tuple[SolidMesh, Roles, WallSizes]:
    """The mesh of the solids in a STEP or BREP file.

    Raises:
        MeshError: one line, without the file's name.
    """
    try:
        return _adopted(path, hints, wanted, scale)
    except HalfError:
        mesh, roles, sizes = _adopted(path, replace(hints, whole=True), wanted, scale)
        return mesh, roles.as_whole("its half cannot be meshed; the whole is computed"), sizes


class HalfError(MeshError):
    """One line about half a part that cannot be meshed."""


def _adopted(
    path: Path, hints: Asked, wanted: MeshRequest, scale: float
) -> tuple[SolidMesh, Roles, WallSizes]:
    with session("not meshed", OPTIONS):
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
        solids = _imported(path, scale)
        for file in hints.cavity_files:
            if file.suffix.lower() in CAD:
                solids = _hollowed(solids, file, scale)
        solids, interface = _released(solids, hints.held)
        drawn, tags = _faces(solids)
        surface = united(drawn)
        united_to = np.zeros(len(tags), dtype=np.int64)
        united_to[drawn.face] = surface.face
        at = np.array([tag in interface for tag in tags])

        def known(drawn: Faces) -> dict[str, np.ndarray]:
            return {groups.CLAMP: at[drawn.face]} if hints.held else {}

        roles = assign(surface, hints, known(drawn), _centre(solids))
        sizes = measured(roles, wanted)
        if len(solids) == 1 and not all(opening.flat for opening in roles.caps):
            # facets are the elements' sides: those that told the walls are several times finer
            drawn, _ = _faces(solids, sizes.size_mm)
            closed = assign(united(drawn), hints, known(drawn), _centre(solids))
            closed = capped(closed, sizes.cap_mm)
            closed.said["cap"] += "; in a curved face, so plane facets are meshed"
            return meshed_triangles(closed, sizes, wanted)
        _place(solids, roles)
        for opening in roles.caps:
            near = [tags[i] for i in np.flatnonzero(united_to == opening.face)]
            solids = _capped(solids, opening, near, roles, sizes)
        _cut(solids, roles)
        try:
            mesh = meshed(roles, sizes, wanted, curved=True)
            check(mesh)
        except Exception as error:
            if roles.half and (type(error) is Exception or isinstance(error, MeshError)):
                raise HalfError(str(error)) from None
            raise
    return mesh, roles, sizes


def _imported(path: Path, scale: float) -> dict[int, str]:
    """Tags of the solids and their names; those that touch share faces."""
    try:
        import_shapes(path, highest_only=True)
    except Exception as error:
        if type(error) is not Exception:
            raise
        raise MeshError(
            f"not readable: {str(error).splitlines()[0]}; allowed: a STEP file"
        ) from None
    tags = [tag for dimension, tag in gmsh.model.occ.getEntities(3)]
    if not tags:
        loose = gmsh.model.occ.getEntities(2)
        gmsh.model.occ.healShapes(loose, sewFaces=True, makeSolids=True)
        tags = [tag for dimension, tag in gmsh.model.occ.getEntities(3)]
    if not tags:
        raise MeshError("not watertight: faces without a solid; allowed: a closed solid")
    if scale != 1.0:
        gmsh.model.occ.dilate([(3, tag) for tag in tags], 0, 0, 0, scale, scale, scale)
    gmsh.model.occ.synchronize()
    names = {tag: gmsh.model.getEntityName(3, tag).rpartition("/")[2] for tag in tags}
    names = {tag: "" if name.startswith(UNNAMED) else name for tag, name in names.items()}
    if len(tags) == 1:
        return names
    solids = [(3, tag) for tag in tags]
    _, parts = gmsh.model.occ.fragment(solids[:1], solids[1:])
    gmsh.model.occ.synchronize()
    result: dict[int, str] = {}
    for number, (old, pieces) in enumerate(zip(tags, parts, strict=True), 1):
        for _, new in pieces:
            if new in result:
                raise MeshError(
                    "two solids overlap; allowed: solids that touch (cut one out of the other)"
                )
            result[new] = _name(names[old], number, result)
    return result


def _hollowed(solids: dict[int, str], file: Path, scale: float) -> dict[int, str]:
    """The solids without what the solids of a file fill.

    Raises:
        MeshError: one line, if nothing is left or a solid falls into parts.
    """
    before = set(gmsh.model.occ.getEntities(3))
    import_shapes(file, highest_only=True)
    tools = [pair for pair in gmsh.model.occ.getEntities(3) if pair not in before]
    if not tools:
        raise MeshError(f"--cavity {file}: no solid; allowed: a solid that fills the cavity")
    if scale != 1.0:
        gmsh.model.occ.dilate(tools, 0, 0, 0, scale, scale, scale)
    left = {}
    for tag, name in solids.items():
        made, _ = gmsh.model.occ.cut([(3, tag)], tools, removeTool=False)
        if len(made) != 1:
            raise MeshError(f"--cavity {file}: leaves {len(made)} parts; allowed: one solid")
        left[made[0][1]] = name
    gmsh.model.occ.remove(tools, recursive=True)
    gmsh.model.occ.synchronize()
    return left


def _released(solids: dict[int, str], held: Sequence[Box | str]) -> tuple[dict[int, str], set[int]]:
    """The solids without what is held, and the faces at which they are held.

    Raises:
        MeshError: one line, if nothing is held, or everything.
    """
    interface: set[int] = set()
    for region in held:
        if isinstance(region, str):
            gone = [(3, tag) for tag, name in solids.items() if name == region]
            if not gone:
                allowed = ", ".join(filter(None, solids.values())) or "X,Y,Z,X,Y,Z"
                raise MeshError(f"--clamp-region {region}: no such solid; allowed: {allowed}")
            solids = {tag: name for tag, name in solids.items() if name != region}
        else:
            low, high = np.minimum(region[:3], region[3:]), np.maximum(region[:3], region[3:])
            box = [(3, gmsh.model.occ.addBox(*low, *(high - low)))]
            every = [(3, tag) for tag in solids]
            _, parts = gmsh.model.occ.fragment(every, box)
            inside = set(parts[-1])
            of = {p: solids[t] for (_, t), mine in zip(every, parts, strict=False) for p in mine}
            gone = [pair for pair in of if pair in inside]
            solids = {pair[1]: name for pair, name in of.items() if pair not in inside}
            gmsh.model.occ.remove([pair for pair in inside if pair not in of], recursive=True)
        gmsh.model.occ.synchronize()
        if not solids or not gone:
            raise MeshError(
                f"--clamp-region {said_of(region)}: holds {'all' if gone else 'nothing'} of "
                "the part; allowed: a box, by two corners, around the piece that is held"
            )
        faces, others = (
            {tag for _, tag in gmsh.model.getBoundary(of_them, combined=False, oriented=False)}
            for of_them in (gone, [(3, tag) for tag in solids])
        )
        interface |= faces & others
        gmsh.model.occ.remove(gone, recursive=True)
        gmsh.model.occ.synchronize()
    return solids, interface


def _name(given: str, number: int, taken: dict[int, str]) -> str:
    """A region's name: lower case, no other signs than letters, digits and _."""
    plain = "".join(c if c.isalnum() else "_" for c in given.lower()).strip("_")
    surface = groups.surface_tag(plain) is not None
    return f"part_{number}" if surface or plain in {groups.SOLID, *taken.values(), ""} else plain


def _faces(solids: dict[int, str], size_mm: float = 0.0) -> tuple[Faces, list[int]]:
    """The solids' outside in triangles, each face with its place among the tags of faces.

    Args:
        solids: tags of the solids.
        size_mm: of the triangles where faces do not curve; by the part's length where that is more.
    """
    volumes = [(3, tag) for tag in solids]
    tags = [tag for _, tag in gmsh.model.getBoundary(volumes, combined=True, oriented=False)]
    box = np.array([gmsh.model.getBoundingBox(3, tag) for tag in solids])
    extent = float((box[:, 3:].max(axis=0) - box[:, :3].min(axis=0)).max())
    for fineness in FINENESS:
        gmsh.model.mesh.clear()
        gmsh.option.setNumber("Mesh.MeshSizeMax", max(extent / 40, size_mm) / fineness)
        gmsh.option.setNumber("Mesh.MeshSizeMin", extent / (2000 * fineness))
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 24 * fineness)
        gmsh.model.mesh.generate(2)
        plain = triangulated(tags)
        check_watertight(plain.points, plain.triangles)
        try:
            check_crossings(plain.points, plain.triangles)
            break
        except MeshError:
            if fineness == FINENESS[-1]:
                raise
    surface = outward(plain)
    gmsh.model.mesh.clear()
    return surface, tags


def _centre(solids: dict[int, str]) -> np.ndarray:
    """Exact centre of gravity (3,), without rounding errors where it lies in a seam's plane."""
    volumes = [gmsh.model.occ.getMass(3, tag) for tag in solids]
    centres = [gmsh.model.occ.getCenterOfMass(3, tag) for tag in solids]
    return np.asarray(np.average(centres, axis=0, weights=volumes))


def _place(solids: dict[int, str], roles: Roles) -> None:
    """Bring the solids into the finger's frame; tags of faces stay."""
    every = [(3, tag) for tag in solids]
    gmsh.model.occ.translate(every, *(-roles.origin_mm))
    turn = Rotation.from_matrix(roles.rotation).as_rotvec()
    angle = float(np.linalg.norm(turn))
    if angle > 1e-12:
        gmsh.model.occ.rotate(every, 0, 0, 0, *(turn / angle), angle)
    gmsh.model.occ.synchronize()


def _capped(
    solids: dict[int, str], opening: Opening, faces: list[int], roles: Roles, sizes: WallSizes
) -> dict[int, str]:
    """The solids with an opening in some faces closed by a plug of the wall's material.

    The plug reaches into the wall around it, so that it closes a hollow that turns or widens, too.

    Raises:
        MeshError: one line, if the opening is not plane.
    """
    at = place(opening.centre_mm)
    if not opening.flat:
        raise MeshError(
            f"the opening at {at} is in a curved face; allowed: in a plane face, at the clamp, or "
            "a part of one solid"
        )
    normal = roles.rotation @ opening.normal
    rim = roles.surface.points[opening.rim]
    every = gmsh.model.getBoundary([(2, face) for face in faces], combined=True, oriented=False)
    curves = [tag for _, tag in every if _away(tag, rim) < roles.surface.near_mm]
    loop = gmsh.model.occ.addCurveLoop(curves)
    disc = gmsh.model.occ.addPlaneSurface([loop])
    centre = roles.rotation @ (opening.centre_mm - roles.origin_mm)
    farthest = float(np.linalg.norm(rim - centre, axis=2).max())
    larger = 1 + sizes.reach_mm / farthest
    gmsh.model.occ.dilate([(2, disc)], *centre, larger, larger, larger)
    plug = [pair for pair in gmsh.model.occ.extrude([(2, disc)], *(-sizes.cap_mm * normal))
            if pair[0] == 3]  # fmt: skip
    owner = next(
        tag for tag in solids
        if faces[0] in [t for _, t in gmsh.model.getBoundary([(3, tag)], oriented=False)]
    )  # fmt: skip
    made, _ = gmsh.model.occ.fuse([(3, owner)], plug)
    gmsh.model.occ.remove([(2, disc)], recursive=False)
    if len(made) != 1:
        raise MeshError(f"the opening at {at} cannot be closed; allowed: --clamp there")
    gmsh.model.occ.synchronize()
    return {(made[0][1] if tag == owner else tag): name for tag, name in solids.items()}


def _away(curve: int, rim: np.ndarray) -> float:
    """Distance of a curve's middle from a rim, (k, 2, 3)."""
    low, high = gmsh.model.getParametrizationBounds(1, curve)
    middle = np.array(gmsh.model.getValue(1, curve, [(low[0] + high[0]) / 2]))
    along = rim[:, 1] - rim[:, 0]
    share = np.einsum("ij,ij->i", middle - rim[:, 0], along) / np.einsum("ij,ij->i", along, along)
    foot = rim[:, 0] + np.clip(share, 0, 1)[:, None] * along
    return float(np.linalg.norm(foot - middle, axis=1).min())


def _cut(solids: dict[int, str], roles: Roles) -> None:
    """Keep y ≥ 0 of a half, and make physical groups of several solids."""
    every = [(3, tag) for tag in solids]
    parts = [[pair] for pair in every]
    if roles.half:
        size = 4 * roles.surface.extent
        box = gmsh.model.occ.addBox(-size, 0.0, -size, 2 * size, size, 2 * size)
        _, mapped = gmsh.model.occ.intersect(every, [(3, box)])
        parts = mapped[: len(every)]
        gmsh.model.occ.synchronize()
    left = [tag for pieces in parts for _, tag in pieces]
    if not left:
        raise MeshError("no half is left of it; allowed: --whole")
    if len(solids) > 1:
        numbers = groups.volume_tags(list(solids.values()))
        for name, pieces in zip(solids.values(), parts, strict=True):
            gmsh.model.addPhysicalGroup(3, [tag for _, tag in pieces], numbers[name], name)
    for dimension in (2, 1, 0):  # what no solid has, such as a cap's disc
        used = {tag for d, tag in _below(left) if d == dimension}
        loose = [pair for pair in gmsh.model.getEntities(dimension) if pair[1] not in used]
        gmsh.model.removeEntities(loose)


def _below(volumes: list[int]) -> set[tuple[int, int]]:
    """Faces, curves and points of volumes."""
    below: set[tuple[int, int]] = set()
    level = [(3, tag) for tag in volumes]
    for _ in range(3):
        level = gmsh.model.getBoundary(level, combined=False, oriented=False)
        below |= set(level)
    return below
