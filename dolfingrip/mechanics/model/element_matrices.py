"""Code of element matrices: FFCx' loops in an order that compilers turn into vector instructions.

FFCx adds each product of two basis functions' derivatives to the element matrix by itself, 81 for
each pair of a solid's nodes, and entries of one component lie three apart in the matrix, so that
the loops stay scalar. Here the trial function's derivatives are summed first, which leaves 27
products, and each pair of components has a block of its own, whose rows are contiguous. The blocks
are added to the matrix once, after the last integration point. Results differ by rounding.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any, NamedTuple

import ffcx.codegeneration.lnodes as L
import numpy as np
from ffcx.codegeneration.integral_generator import IntegralGenerator
from ffcx.codegeneration.optimizer import check_dependency, get_statements

from dolfingrip.mechanics.model.compatibility import patches_ffcx

VERSION = 1 if patches_ffcx else 0
"""Part of the key of compiled forms: another number where this file makes other code."""


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
            of_row = tuple(each for each in factors if check_dependency(each, i))
            others = [each for each in factors if not check_dependency(each, i)]
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
