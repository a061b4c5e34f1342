"""Docstrings stand alone, and the doors of rooms say what their arguments are.

A room is forms, meshes, or a package or module directly in ``dolfingrip``.
"""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from support.checkout import needs_checkout

ROOT = Path(__file__).resolve().parents[1]

LEANS_ON_OTHERS = re.compile(
    r"(The same|Likewise|As|Of|What|That|Those|Its|Whether|Also|Again)\b", re.IGNORECASE
)
"""Beginnings of a first line that cannot be read without the lines around it."""

REPLACED = re.compile(r"(setattr|patch)[\w.]*\([^()]*\bPOLICY\b|\w\.POLICY = ")
"""Where a module's policy is replaced by another, not given to what decides by it."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


@cache
def modules(folders: tuple[str, ...] = ("dolfingrip", "forms", "meshes")) -> dict[str, ast.Module]:
    """Sources by their dotted names: those of the package, unless others are asked for."""
    found = {}
    for folder in folders:
        for file in sorted((ROOT / folder).rglob("*.py")):
            parts = file.relative_to(ROOT).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name] = ast.parse(file.read_text(encoding="utf-8"))
    return found


def room(name: str) -> str:
    parts = name.split(".")
    if parts[:2] in (["dolfingrip", "forms"], ["dolfingrip", "meshes"]):
        parts = parts[1:]
    return ".".join(parts[:2]) if parts[0] == "dolfingrip" else parts[0]


def used_elsewhere() -> set[str]:
    """Names that one room takes from another, by import or as attributes of what it imported."""
    names: set[str] = set()
    for name, tree in modules().items():
        foreign, attributes = set(), []
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    if room(f"{node.module}.{alias.name}") != room(name):
                        names.add(alias.name)
                        foreign.add(alias.asname or alias.name)
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                attributes.append((node.value.id, node.attr))
        names |= {attribute for owner, attribute in attributes if owner in foreign}
    return names


def definitions(node: ast.AST) -> Iterator[Function | ast.ClassDef]:
    """Classes and functions, however deep; expressions, which have none, are not looked through."""
    for each in ast.iter_child_nodes(node):
        if isinstance(each, Function | ast.ClassDef):
            yield each
        if isinstance(each, ast.stmt | ast.excepthandler | ast.match_case):
            yield from definitions(each)


def undocumented(node: Function) -> list[str]:
    """Parameters that the Args of a docstring lack."""
    given = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
    section = (ast.get_docstring(node) or "").partition("Args:")[2]
    return [
        each.arg
        for each in given
        if not re.search(rf"^\s+.*\b{each.arg}\b.*:", section, re.MULTILINE)
    ]


def test_first_lines_stand_alone() -> None:
    leaning = [
        f"{name}.{node.name}: {first}"
        for folders in (("dolfingrip", "forms", "meshes"), ("benchmarks", "examples", ".ci"))
        for name, tree in modules(folders).items()
        for node in definitions(tree)
        for first in [(ast.get_docstring(node) or "").partition("\n")[0]]
        if LEANS_ON_OTHERS.match(first)
    ]
    assert leaning == []


def test_doors_of_rooms_have_args() -> None:
    """Commands are left out: their settings have help texts."""
    used = used_elsewhere()
    bare = [
        f"{name}.{node.name}: {', '.join(lacking)}"
        for name, tree in modules().items()
        if room(name) != "dolfingrip.cli"
        for node in tree.body
        if isinstance(node, Function) and node.name in used
        for lacking in [undocumented(node)]
        if lacking
    ]
    assert bare == []


@needs_checkout
def test_class_names_are_given_once() -> None:
    places = defaultdict(list)
    for name, tree in modules().items():
        for node in definitions(tree):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(name)
    twice = {name: found for name, found in places.items() if len(found) > 1}
    assert twice == {}


def test_no_test_replaces_a_policy() -> None:
    """It is an argument with a default."""
    found = [
        str(file.relative_to(ROOT))
        for file in sorted((ROOT / "tests").rglob("*.py"))
        if REPLACED.search(file.read_text(encoding="utf-8"))
    ]
    assert found == []
    ways = ('patch.setattr(guard, "{}", other)', 'patch("explore.{}")', "guard.{} = other")
    assert all(REPLACED.search(way.format("POLICY")) for way in ways)
