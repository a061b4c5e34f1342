"""Compiler options of kernels: optimised for this processor, with a cache for each kind of it."""

from __future__ import annotations

import hashlib
import os
import platform
from functools import cache
from pathlib import Path
from typing import Any

import basix.ufl
import ffcx.codegeneration.jit
import numpy as np
import ufl
from ffcx.ir import representationutils
from ffcx.ir.analysis.valuenumbering import ValueNumberer

from dolfingrip.mechanics.model import element_matrices

LEVEL = "DOLFINGRIP_OPTIMISATION"
"""Environment variable with another level than 3: tests, whose meshes are small, compile for longer
than they run."""

PROCESSOR = os.environ.get("DOLFINGRIP_PROCESSOR", "native")
"""Processor that forms are compiled for, by gcc's name: this machine's own unless the environment
says another, such as x86-64. Each has its own forms in the cache."""

FLAGS = [
    f"-O{os.environ.get(LEVEL, '3')}",
    f"-march={PROCESSOR}",
    # sums may be reordered, which vectorises them: element tangents in half the time. Not-a-numbers
    # keep their meaning (no -ffinite-math-only).
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-signed-zeros",
    "-fassociative-math",
    "-freciprocal-math",
    # the last scheduling of instructions takes time with the square of a kernel's length, up to
    # 98 % of all (38 s for 0.9 s); kernels are no faster by it, their results bitwise the same
    "-fno-schedule-insns2",
    "-g0",
]

PATIENCE_s = 600
"""Time (s) to wait for another process that compiles the same form. FFCx' default of ten seconds is
less than the longest forms take on a busy machine."""


# Basix builds an element's cell anew, with all its edges and corners (0.8 ms for a hexahedron),
# whenever UFL asks for it: a fourth of a form's analysis. Cells do not change.
_cell = cache(ufl.Cell)
basix.ufl._ElementBase.cell = property(lambda element: _cell(element._cellname))


# FFCx lists the cache's folder and loads a module anew whenever a form is asked for: 2 ms with the
# forms of a few studies. What a process has loaded once stays as it is.
_loaded: dict[tuple[str, Path], tuple[Any, Any]] = {}
_from_cache = ffcx.codegeneration.jit.get_cached_module


def _loaded_once(module_name: str, names: list[str], cache_dir: Path, timeout: int) -> Any:
    key = module_name, Path(cache_dir)
    if key not in _loaded:
        found = _from_cache(module_name, names, cache_dir, timeout)
        if found[0] is None:  # to be compiled
            return found
        _loaded[key] = found
    return _loaded[key]


ffcx.codegeneration.jit.get_cached_module = _loaded_once


# FFCx looks each node of a form up among all of them, though it has their numbers in a table, and
# computes a facet's integration points anew for each of a form's tables: together a third of a long
# form's analysis.
def _symbols(numbers: Any, node: Any) -> Any:
    return numbers.V_symbols[numbers.G.e2i[node]]


ValueNumberer.get_node_symbols = _symbols

_points: dict[tuple[bytes, tuple[int, ...], int, str], np.ndarray] = {}
_facet_points = representationutils.map_facet_points


def _points_once(points: np.ndarray, facet: int, cell: str) -> np.ndarray:
    key = points.tobytes(), points.shape, facet, cell
    if key not in _points:
        _points[key] = _facet_points(points, facet, cell)
    return _points[key].copy()


representationutils.map_facet_points = _points_once


def _processor() -> str:
    """Instruction sets of this machine's processor, which the compiler may use."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="ignore").splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith(("flags", "Features"))), "")


def options() -> dict[str, Any]:
    """JIT options of dolfinx; a cache that unlike machines share keeps their kernels apart."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    made_for = f"{platform.machine()} {_processor()} {element_matrices.VERSION}"
    key = hashlib.sha256(made_for.encode()).hexdigest()[:12]
    return {
        "cffi_extra_compile_args": FLAGS,
        "cache_dir": str(cache / "fenics" / key),
        "timeout": PATIENCE_s,
    }
