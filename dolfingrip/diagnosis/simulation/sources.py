"""Digests of the code that simulations are computed by: syntax trees, comments and texts aside."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Final

CORE: Final = ("dolfingrip.forms", "dolfingrip.meshes", "dolfingrip.mechanics",
               "dolfingrip.experiments")  # fmt: skip
"""Packages that every simulation of a finger depends on."""


@cache
def core_digest() -> str:
    """Of what every simulation is computed by."""
    return _digest(file for name in CORE for file in sorted(_folder(name).rglob("*.py")))


@cache
def effect_digest(name: str) -> str:
    """Of an effect's file, and of the files of this package that it imports itself."""
    own = _folder("dolfingrip.extensions") / f"{name}.py"
    imported = {
        node.module
        for node in ast.walk(ast.parse(own.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module
    }
    files = [_file(each) for each in sorted(imported) if each.startswith("dolfingrip.")]
    return _digest([own, *(file for file in files if file is not None)])


def _folder(package: str) -> Path:
    spec = importlib.util.find_spec(package)
    assert spec is not None
    assert spec.submodule_search_locations
    return Path(next(iter(spec.submodule_search_locations)))


def _file(module: str) -> Path | None:
    spec = importlib.util.find_spec(module)
    return Path(spec.origin) if spec and spec.origin else None


def _digest(files: Iterable[Path]) -> str:
    found = hashlib.sha256()
    for file in files:
        found.update(file.name.encode())
        found.update(structure(file.read_text(encoding="utf-8")).encode())
    return found.hexdigest()


def structure(text: str) -> str:
    """The syntax tree without docstrings."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [each for each in body if not _is_text(each)]  # type: ignore[attr-defined]
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
