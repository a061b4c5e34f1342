"""Abaqus input decks (.inp): tetrahedra or hexahedra, and groups of their faces.

A group is read from the first of these that has its name, in any case of letters:

- ``*SURFACE, TYPE=ELEMENT``: faces S1 to S6 of elements or element sets,
- ``*ELSET``: triangles or quadrilaterals on the solid's surface, as Gmsh exports,
- ``*NSET``: faces with all corners in the set.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.meshes import groups
from dolfingrip.meshes.cells import BY_NODES, from_vtk, to_vtk
from dolfingrip.meshes.solid import (
    Ints,
    MeshError,
    SolidMesh,
    assemble,
    boundary,
    faces,
    joined,
    match,
)

ELEMENT_TYPES: Final = {4: "C3D4", 10: "C3D10", 8: "C3D8", 20: "C3D20R"}
"""Abaqus' element type for each number of nodes."""

_SOLIDS: Final = {"C3D4": 4, "C3D10": 10, "C3D8": 8, "C3D20": 20}
_SURFACES: Final = {
    "CPS3": 3, "CPE3": 3, "S3": 3, "STRI3": 3, "R3D3": 3, "M3D3": 3, "SFM3D3": 3,
    "CPS4": 4, "CPE4": 4, "S4": 4, "R3D4": 4, "M3D4": 4, "SFM3D4": 4,
    "CPS6": 6, "CPE6": 6, "S6": 6, "STRI65": 6, "M3D6": 6, "SFM3D6": 6,
    "CPS8": 8, "CPE8": 8, "S8": 8, "S8R5": 8, "M3D8": 8, "SFM3D8": 8,
}  # fmt: skip
_IGNORED: Final = ("T3D", "T2D", "B3", "MASS", "SPRING")
_REFUSED: Final = ("INCLUDE", "SYSTEM", "NGEN", "ELGEN", "NCOPY", "ELCOPY", "NFILL")
_FIRST: Final = (groups.CLAMP, groups.TIP, groups.SYMMETRY)
"""Groups whose node sets claim faces first; a node set has a face if it has all corners."""


@dataclass
class _Deck:
    """The mesh of a deck, in its own numbering."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    solids: dict[int, list[int]] = field(default_factory=dict)
    facets: dict[int, list[int]] = field(default_factory=dict)
    elsets: dict[str, list[int]] = field(default_factory=dict)
    nsets: dict[str, list[int]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[str, str]]] = field(default_factory=dict)

    def elements(self, name: str) -> list[int]:
        """Elements of a set, or the element with this number."""
        if name.isdigit():
            return [int(name)]
        key = _plain(name)
        if key not in self.elsets:
            raise MeshError(f"no element set {name}")
        return self.elsets[key]


def read(path: Path) -> SolidMesh:
    """Read a deck with the groups that it has.

    Args:
        path: the deck, .inp.

    Returns:
        The mesh, in the deck's unit of length.

    Raises:
        MeshError: one line, if the deck cannot be understood.
        OSError: if the file cannot be read.
    """
    deck = _parse(path.read_text(encoding="utf-8", errors="replace"))
    if not deck.solids:
        raise MeshError(f"no solid elements; allowed types: {', '.join(_SOLIDS)}")
    numbers = sorted(deck.nodes)
    ids = np.array(numbers, dtype=np.int64)
    points = np.array([deck.nodes[number] for number in numbers])
    row = {element: i for i, element in enumerate(deck.solids)}
    sizes = {len(nodes) for nodes in deck.solids.values()}
    if len(sizes) > 1:
        mixed = " and ".join(kind for kind, nodes in _SOLIDS.items() if nodes in sizes)
        raise MeshError(f"{mixed} mixed; allowed: one of them")
    cells = from_vtk(_indices(list(deck.solids.values()), ids))
    facets: dict[str, Ints] = {}
    for name in groups.surfaces({*deck.surfaces, *deck.elsets}):
        if name in deck.surfaces:
            facets[name] = _of_surface(deck, name, row, cells)
        elif elements := [deck.facets[e] for e in deck.elsets.get(name, ()) if e in deck.facets]:
            kinds = {len(nodes) for nodes in elements}
            parts = [_indices([n for n in elements if len(n) == kind], ids) for kind in kinds]
            facets[name] = joined(name, parts, cells)
    every = faces(cells)
    free = np.setdiff1d(
        boundary(cells),
        np.concatenate([[-1], *(match(group, cells) for group in facets.values())]),
    )
    corners = BY_NODES[cells.shape[1]].facet_corners
    for name in (*_FIRST, *groups.cavities(deck.nsets), groups.SKIN):
        if name in deck.nsets and name not in facets:
            members = np.searchsorted(ids, deck.nsets[name])
            claimed = np.isin(every[free, :corners], members).all(axis=1)
            facets[name] = every[free[claimed]]
            free = free[~claimed]
    regions = {}
    for name, listed in deck.elsets.items():
        inside = np.array([row[element] for element in listed if element in row], dtype=np.int64)
        if name != groups.SOLID and len(inside):
            regions[name] = np.unique(inside)
    return assemble(points, cells, facets, regions)


def deck(mesh: SolidMesh, *, full: bool = False) -> str:
    """Nodes, elements (:data:`ELEMENT_TYPES`), a node set and a surface for each group, as a deck.

    Abaqus and CalculiX can read the deck: it has no elements but those of the solid.

    Args:
        mesh: mesh in mm.
        full: whether hexahedra of 20 nodes have all 27 integration points (C3D20), not 8.

    Returns:
        Content of an .inp file.
    """
    kind = ELEMENT_TYPES[mesh.cells.shape[1]]
    numbers = np.arange(1, len(mesh.cells) + 1)
    elements = np.column_stack([numbers, to_vtk(mesh.cells) + 1])
    lines = ["*HEADING\nwritten by dolfingrip\nlengths in mm\n*NODE\n"]
    # CalculiX reads no number of more than 20 characters
    lines += [f"{i}, {x:.13e}, {y:.13e}, {z:.13e}\n" for i, (x, y, z) in enumerate(mesh.points, 1)]
    lines.append(f"*ELEMENT, TYPE={kind.removesuffix('R') if full else kind}\n")
    lines += [data(element) for element in elements]
    for name, rows in {groups.SOLID: np.arange(len(mesh.cells)), **mesh.regions}.items():
        lines.append(f"*ELSET, ELSET={name}\n{data(rows + 1)}")
    for name, facets in mesh.facets.items():
        lines.append(f"*NSET, NSET={name}\n{data(np.unique(facets) + 1)}")
    for name, facets in mesh.facets.items():
        lines.append(f"*SURFACE, NAME={name}, TYPE=ELEMENT\n")
        places = np.divmod(match(facets, mesh.cells), len(mesh.shape.faces))
        lines += [f"{element + 1}, S{face + 1}\n" for element, face in zip(*places, strict=True)]
    return "".join(lines)


def data(numbers: Ints) -> str:
    """Lines of whole numbers, 16 in each, as Abaqus allows; a comma tells that a line goes on.

    Args:
        numbers: of nodes or elements, shape (n,).

    Returns:
        The lines, each with its end.
    """
    texts = [str(number) for number in numbers]
    return ",\n".join(",".join(texts[i : i + 16]) for i in range(0, len(texts), 16)) + "\n"


def _of_surface(deck: _Deck, name: str, row: dict[int, int], cells: Ints) -> Ints:
    """Corners of the faces of a ``*SURFACE``, shape (k, corners)."""
    shape = BY_NODES[cells.shape[1]]
    corners: list[Ints] = [np.empty((0, shape.facet_corners), dtype=np.int64)]
    names = [f"S{i + 1}" for i in range(len(shape.faces))]
    for of, face in deck.surfaces[name]:
        if face not in names:
            raise MeshError(f"surface {name}: face {face!r}; allowed: S1 to {names[-1]}")
        rows = [row[element] for element in deck.elements(of) if element in row]
        corners.append(cells[rows][:, shape.face_corners[names.index(face)]])
    return np.concatenate(corners)


def _indices(nodes: list[list[int]], ids: Ints) -> Ints:
    """Positions in ``ids`` of the node numbers of elements."""
    numbers = np.array(nodes, dtype=np.int64)
    positions = np.minimum(np.searchsorted(ids, numbers), len(ids) - 1)
    if len(ids) == 0 or (ids[positions] != numbers).any():
        raise MeshError("an element has a node that is not there")
    return positions


def _plain(name: str) -> str:
    """A set's name without instance, quotes and case."""
    return name.strip().strip('"').rpartition(".")[2].lower()


def _parse(text: str) -> _Deck:
    """Collect the blocks of a deck that define its mesh."""
    deck = _Deck()
    keyword, start = "", 0
    options: dict[str, str] = {}
    data: list[str] = []
    for number, line in enumerate([*text.splitlines(), "*END"], 1):
        stripped = line.strip()
        if not stripped or stripped.startswith("**"):
            continue
        if not stripped.startswith("*"):
            data.append(stripped)
            continue
        try:
            _take(deck, keyword, options, data)
        except (ValueError, IndexError) as error:
            if isinstance(error, MeshError):
                raise MeshError(f"line {start}: *{keyword}: {error}") from None
            raise MeshError(f"line {start}: *{keyword}: not understood") from None
        words = [word.strip() for word in stripped[1:].split(",")]
        keyword, data, start = words[0].upper(), [], number
        pairs = (word.partition("=") for word in words[1:])
        options = {key.strip().upper(): value.strip() for key, _, value in pairs}
    return deck


def _take(deck: _Deck, keyword: str, options: dict[str, str], data: list[str]) -> None:
    """Add one block, from its keyword line to the next, to the deck."""
    if keyword in _REFUSED:
        raise MeshError("not supported")
    if keyword == "NODE":
        for line in data:
            number, *coordinates = line.rstrip(",").split(",")
            if int(number) in deck.nodes:
                raise MeshError(f"node {int(number)} twice; allowed: one part")
            x, y, z = (float(value) for value in coordinates[:3])
            deck.nodes[int(number)] = [x, y, z]
    elif keyword == "ELEMENT":
        _take_elements(deck, options, data)
    elif keyword in ("ELSET", "NSET"):
        sets = deck.elsets if keyword == "ELSET" else deck.nsets
        members = sets.setdefault(_plain(options[keyword]), [])
        members += _members(sets, "GENERATE" in options, data)
    elif keyword == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
        lines = [[word.strip() for word in line.split(",")] for line in data]
        deck.surfaces[_plain(options["NAME"])] = [(w[0], w[1].upper()) for w in lines]


def _take_elements(deck: _Deck, options: dict[str, str], data: list[str]) -> None:
    kind = options["TYPE"].upper()
    if kind.startswith(_IGNORED):
        return
    corner_kind = kind.rstrip("HIMTRS")
    if corner_kind in _SOLIDS:
        size, into = _SOLIDS[corner_kind], deck.solids
    elif corner_kind in _SURFACES:
        size, into = _SURFACES[corner_kind], deck.facets
    else:
        raise MeshError(
            f"element type {kind}; allowed: {', '.join(_SOLIDS)}, "
            "and triangles or quadrilaterals on the surface"
        )
    # an element may go on in the next line, so lines mean nothing here
    numbers = [int(word) for line in data for word in line.split(",") if word.strip()]
    if len(numbers) % (size + 1):
        raise MeshError(f"{len(numbers)} numbers; allowed: {size + 1} for each {kind}")
    names = numbers[:: size + 1]
    for i, name in enumerate(names):
        if name in deck.solids or name in deck.facets:
            raise MeshError(f"element {name} twice; allowed: one part")
        into[name] = numbers[i * (size + 1) + 1 : (i + 1) * (size + 1)]
    if "ELSET" in options:
        deck.elsets.setdefault(_plain(options["ELSET"]), []).extend(names)


def _members(sets: dict[str, list[int]], generate: bool, data: list[str]) -> list[int]:
    """Numbers in a set's data lines: plain, as a range, or by the names of other sets."""
    members: list[int] = []
    for line in data:
        words = [word.strip() for word in line.split(",") if word.strip()]
        if generate:
            first, last, step = [*(int(word) for word in words), 1][:3]
            members += range(first, last + 1, step)
            continue
        for word in words:
            if word.isdigit():
                members.append(int(word))
            elif _plain(word) in sets:
                members += sets[_plain(word)]
            else:
                raise MeshError(f"no set {word}")
    return members
