"""Factors of two parts that only a border couples, whatever the sign of the border's part."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from dolfingrip.mechanics.newton import cholmod
from dolfingrip.mechanics.newton.bordered import Bordered
from dolfingrip.mechanics.newton.cholesky import Cholesky
from dolfingrip.mechanics.newton.inverse import Factorisation
from tests.mechanics.test_cholesky import NODES, assert_solves, chain, tangent

pytestmark = pytest.mark.skipif(not cholmod.available(), reason="needs CHOLMOD")

BORDER = 2
SEED = 5


def coupled(rng: np.random.Generator, cut: int, shift: float) -> np.ndarray:
    """A chain without links at node ``cut``, whose last nodes are coupled with all others."""
    dense = chain(3)
    end, inner = 3 * cut, 3 * (NODES - BORDER)
    dense[:end, end:inner] = dense[end:inner, :end] = 0.0
    dense[:inner, inner:] = rng.uniform(-1, 1, (inner, 3 * BORDER))
    dense[inner:, :inner] = dense[:inner, inner:].T
    dense[inner:, inner:] -= shift * np.eye(3 * BORDER)
    return dense


@pytest.mark.parametrize("shift", [0.0, 100.0])
def test_parts_and_border_together_are_the_inverse(shift: float) -> None:
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    made = []

    def create() -> Cholesky:
        made.append(len(made))
        return Cholesky(MPI.COMM_SELF, lambda: Factorisation("test_part_any_", MPI.COMM_SELF))

    inverse = Bordered(MPI.COMM_SELF, BORDER, create)
    for cut, parts in ((15, 2), (15, 2), (22, 4), (0, 5)):
        dense = coupled(rng, cut, shift)
        matrix = tangent(dense)
        inverse.set_up(matrix)
        negative = int((np.linalg.eigvalsh(dense) < 0).sum())
        assert_solves(inverse, matrix, dense, negative, rng)
        assert negative == (3 * BORDER if shift else 0)
        assert len(made) == parts  # a pattern that stays keeps its parts
