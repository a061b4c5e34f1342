"""How forms are compiled: for this processor, each by one process, and with a quicker analysis.

Element matrices have FFCx' loops in an order that compilers turn into vector instructions. FFCx
adds each product of two basis functions' derivatives to the element matrix by itself, 81 for each
pair of a solid's nodes, and entries of one component lie three apart in the matrix, so that the
loops stay scalar. Here the trial function's derivatives are summed first, which leaves 27 products,
and each pair of components has a block of its own, whose rows are contiguous. The blocks are added
to the matrix once, after the last integration point. Results differ by rounding.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import sysconfig
from collections import defaultdict
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import basix.ufl
import dolfinx.jit
import ffcx
import ffcx.codegeneration.lnodes as L
import ffcx.naming
import numpy as np
import ufl
from ffcx.codegeneration.integral_generator import IntegralGenerator
from ffcx.codegeneration.optimizer import check_dependency, get_statements
from ffcx.ir import representationutils
from ffcx.ir.analysis.valuenumbering import ValueNumberer
from mpi4py import MPI
from ufl.core.expr import Expr

from dolfingrip.loading import elsewhere
from dolfingrip.mechanics.model.compatibility import patches_ffcx
from dolfingrip.mechanics.model.compilation import compiled
from dolfingrip.sections.private import cache_folder

# Both keep what they read of their first call's folder: libraries to be linked, flags of the
# compiler, types of numbers.
with elsewhere():
    ffcx.get_options()
    dolfinx.jit.get_options()

_MATRICES = 1 if patches_ffcx else 0
"""Part of the key of compiled forms: another number where :class:`Blocks` make other code."""


class Blocks(NamedTuple):
    """Code around the loop over integration points.

    Attributes:
        made: declarations of blocks of zeros.
        used: loops that add the blocks to the element matrix.
    """

    made: list[L.LNode]
    used: list[L.LNode]


def _by_blocks(section: L.Section, blocks: Blocks) -> L.Section:
    """The loops of ``section``, which add to an element matrix, with blocks in its place."""
    columns = section.statements[0]  # FFCx' outer loop is the last argument's
    rows = columns.body.statements[0]
    i, j, height, width = rows.index, columns.index, rows.end.value, columns.end.value

    sums: dict[Any, dict[tuple[Any, ...], list[Any]]] = defaultdict(lambda: defaultdict(list))
    for statement in rows.body.statements:
        for entry in get_statements(statement):
            factors = entry.rhs.args if isinstance(entry.rhs, L.Product) else [entry.rhs]
            of_row = tuple(factor for factor in factors if check_dependency(factor, i))
            others = [factor for factor in factors if not check_dependency(factor, i)]
            sums[entry.lhs][of_row].append(L.float_product(others))

    declared: list[L.LNode] = []
    summed, added, used = [], [], []
    for entry, by_row in sums.items():
        terms = []
        for of_row, products in by_row.items():
            name = L.Symbol(f"sum_{len(declared)}", L.DataType.SCALAR)
            declared.append(L.ArrayDecl(name, width))
            total = L.ArrayAccess(name, [j])
            summed.append(L.Assign(total, L.Sum(products)))
            terms.append(L.float_product([*of_row, total]))
        name = L.Symbol(f"block_{len(blocks.made)}", L.DataType.SCALAR)
        blocks.made.append(L.ArrayDecl(name, (height, width), np.zeros((1, 1))))
        place = L.ArrayAccess(name, [i, j])
        row = L.ForRange(j, 0, width, [L.AssignAdd(place, L.Sum(terms))])
        added.append(L.ForRange(i, 0, height, [row]))
        used.append(L.AssignAdd(entry, place))
    blocks.used.append(L.ForRange(i, 0, height, [L.ForRange(j, 0, width, used)]))
    code = [*declared, L.ForRange(j, 0, width, summed), *added]
    return L.Section(section.name, code, [], section.input, section.output)


_partition = IntegralGenerator.generate_dofblock_partition
_loop = IntegralGenerator.generate_quadrature_loop


def _dofblock_partition(self: Any, *rule: Any) -> tuple[list[L.LNode], list[L.LNode]]:
    sections, intermediates = _partition(self, *rule)
    self.blocks = Blocks([], [])
    matrices = [L.depth(section.statements[0]) == 2 for section in sections]
    return [
        _by_blocks(section, self.blocks) if matrix else section
        for section, matrix in zip(sections, matrices, strict=True)
    ], intermediates


def _quadrature_loop(self: Any, *rule: Any) -> list[L.LNode]:
    code = _loop(self, *rule)
    if not self.blocks.made:
        return code
    return [L.Section("Element matrix", [*self.blocks.made, *code, *self.blocks.used], [])]


if patches_ffcx:
    IntegralGenerator.generate_dofblock_partition = _dofblock_partition
    IntegralGenerator.generate_quadrature_loop = _quadrature_loop


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


# Basix builds an element's cell anew, with all its edges and corners (0.8 ms for a hexahedron),
# whenever UFL asks for it: a fourth of a form's analysis. Cells do not change.
_cell = cache(ufl.Cell)


# FFCx writes a form's source into the cache before it compiles it, and waits where it finds a
# source without a library: also for a process that is gone. Here each form has a folder, which is
# compiled whole or not at all. What a process has loaded stays: a search of the cache takes 2 ms.
_compile = dolfinx.jit.ffcx_jit.__wrapped__  # by one process
_loaded: dict[Path, Any] = {}


def _in_process(form: Any, form_options: Any, jit_options: Any) -> Any:
    settings = dolfinx.jit.get_options(jit_options)
    cache_dir = settings.pop("cache_dir")
    tag = [ffcx.get_options(form_options), settings, sysconfig.get_config_vars("SOABI", "CFLAGS")]
    folder = cache_dir / f"form_{ffcx.naming.compute_signature([form], str(tag))}"

    def get(place: Path) -> Any:
        handlers = logging.root.handlers
        try:
            # nobody else compiles in this folder, so there is nothing to wait for
            place_options = {**settings, "cache_dir": place, "timeout": 1}
            return _compile(form, form_options, place_options)
        finally:
            logging.root.handlers = handlers  # which FFCx replaces, and after an error leaves so

    if folder not in _loaded:
        code, module, _ = compiled(folder, get, "a form")
        _loaded[folder] = code, module, (None, None)
    return _loaded[folder]


def _on_ranks(
    comm: MPI.Comm, form: Any, form_compiler_options: Any = None, jit_options: Any = None
) -> Any:
    """dolfinx' function: rank 0 compiles and then the others load; all ranks raise an error of one.

    Where ranks have caches of their own, one rank of each cache compiles.
    """
    if comm.size == 1:
        return _in_process(form, form_compiler_options, jit_options)
    compiled: Any = None
    error: Exception | None = None
    for turn in (comm.rank == 0, comm.rank > 0):
        if turn:
            try:
                compiled = _in_process(form, form_compiler_options, jit_options)
            except Exception as failure:  # passed on to all ranks, which would wait for ever
                error = failure
        errors = [fault for fault in comm.allgather(error) if fault is not None]
        if errors:
            raise error or errors[0]
    return compiled


dolfinx.jit.ffcx_jit = _on_ranks


# FFCx looks each node of a form up among all of them, though it has their numbers in a table, and
# computes a facet's integration points anew for each of a form's tables: together a third of a long
# form's analysis.
def _symbols(numbers: Any, node: Any) -> Any:
    return numbers.V_symbols[numbers.G.e2i[node]]


# UFL before 2026 compares equal subexpressions of two expressions anew wherever they stand, so that
# the time grows with the number of paths to them: 8 of 10 s for an energy's stress with Mullins'
# softening. Here each pair is compared once, and equal ones share what they are made of.
def _equal(first: Any, second: Any) -> bool:
    if first is second:
        return True
    if type(first) is not type(second) or hash(first) != hash(second):
        return False
    pairs = {(id(first), id(second)): (first, second)}
    left = [*pairs.values()]
    while left:
        one, other = left.pop()
        if one._ufl_is_terminal_:
            if one != other:
                return False
            continue
        if len(one.ufl_operands) != len(other.ufl_operands):
            return False
        for pair in zip(one.ufl_operands, other.ufl_operands, strict=True):
            if pair[0]._ufl_typecode_ != pair[1]._ufl_typecode_:
                return False
            key = id(pair[0]), id(pair[1])
            if pair[0] is not pair[1] and key not in pairs:
                pairs[key] = pair
                left.append(pair)
    for one, other in pairs.values():
        if not one._ufl_is_terminal_:
            one.ufl_operands = other.ufl_operands
    return True


_points: dict[tuple[bytes, tuple[int, ...], int, str], np.ndarray] = {}
_facet_points = representationutils.map_facet_points


def _points_once(points: np.ndarray, facet: int, cell: str) -> np.ndarray:
    key = points.tobytes(), points.shape, facet, cell
    if key not in _points:
        _points[key] = _facet_points(points, facet, cell)
    return _points[key].copy()


if patches_ffcx:
    Expr.__eq__ = _equal
    basix.ufl._ElementBase.cell = property(lambda element: _cell(element._cellname))
    ValueNumberer.get_node_symbols = _symbols
    representationutils.map_facet_points = _points_once
else:
    logging.getLogger(__name__).warning(
        "FFCx %s: forms compile more slowly, and their kernels are slower, as it was not tested "
        "with what dolfingrip changes in it",
        ffcx.__version__,
    )


def _processor() -> str:
    """Instruction sets of this machine's processor, which the compiler may use."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="ignore").splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith(("flags", "Features"))), "")


def options() -> dict[str, Any]:
    """JIT options of dolfinx; a cache that unlike machines share keeps their kernels apart.

    Returns:
        The options, by dolfinx' names.

    Raises:
        ConfigError: one line, where another user could write to the cache.
    """
    made_for = f"{platform.machine()} {_processor()} {_MATRICES}"
    key = hashlib.sha256(made_for.encode()).hexdigest()[:12]
    return {
        "cffi_extra_compile_args": FLAGS,
        "cache_dir": str(cache_folder("fenics", key)),
    }
