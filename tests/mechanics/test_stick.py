"""What new pairs take over from those before, by hand."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from dolfingrip.mechanics.contact.friction import MOST_GROWTH, transfer_history
from dolfingrip.mechanics.contact.tangential import Tangential

UP = np.array([0.0, 0.0, 1.0])


def pairs(weights: list[list[float]], forces_N: list[float], keys: list[int]) -> Tangential:
    """Pairs with normals along z."""
    return Tangential(
        sp.csr_matrix(np.array(weights)),
        np.tile(UP, (len(keys), 1)),
        np.array(forces_N),
        np.zeros(len(keys)),
        np.array(keys)[:, None],
    )


def test_a_pair_keeps_its_own() -> None:
    start = pairs([[1, -1, 0, 0], [0, 0, 1, -1]], [2.0, 3.0], [7, 8])
    stuck = np.array([[0.01, 0.0, 0.0], [0.0, -0.02, 0.0]])
    now = pairs([[0, 0, 1, -1], [1, -1, 0, 0]], [5.0, 0.1], [8, 7])
    np.testing.assert_array_equal(transfer_history(start, stuck, now), stuck[::-1])


def test_a_new_pair_takes_the_mean_of_its_nodes() -> None:
    """A vertex (0) slides on to the next triangle; turned round, the sign turns, too."""
    start = pairs([[1, -0.2, -0.3, -0.5, 0]], [2.0], [7])
    stuck = np.array([[0.01, -0.004, 0.0]])
    now = pairs([[1, 0, -0.6, -0.4, 0], [-1, 0, 0.6, 0.4, 0]], [2.0, 2.0], [8, 9])
    np.testing.assert_allclose(
        transfer_history(start, stuck, now), [stuck[0], -stuck[0]], rtol=1e-12
    )
    # the heavier of two pairs of a vertex counts more
    start = pairs([[1, -1, 0, 0], [1, 0, -1, 0]], [3.0, 1.0], [1, 2])
    stuck = np.array([[0.01, 0.0, 0.0], [0.0, 0.02, 0.0]])
    found = transfer_history(start, stuck, pairs([[1, 0, 0, -1]], [4.0], [3]))
    np.testing.assert_allclose(found, [(3 * stuck[0] + stuck[1]) / 4], rtol=1e-12)


def test_a_first_touch_remembers_nothing() -> None:
    start = pairs([[1, -1, 0, 0]], [2.0], [7])
    now = pairs([[0, 0, 1, -1]], [2.0], [8])
    assert not transfer_history(start, np.array([[0.01, 0, 0]]), now).any()
    nothing = Tangential.none(4, width=1)
    assert transfer_history(nothing, np.zeros((0, 3)), now).shape == (1, 3)
    assert transfer_history(start, np.array([[0.01, 0, 0]]), nothing).shape == (0, 3)


@pytest.mark.parametrize("key", [7, 8], ids=["same pair", "new pair"])
def test_memory_fades_where_a_point_had_all_but_left(key: int) -> None:
    start, stuck = pairs([[1, -1]], [1.0], [7]), np.array([[0.01, 0.0, 0.0]])
    for growth, part in (
        (0.01, 1),
        (0.99 * MOST_GROWTH, 1),
        (4 * MOST_GROWTH, 0.25),
        (1e6, MOST_GROWTH / 1e6),
    ):
        found = transfer_history(start, stuck, pairs([[1, -1]], [growth], [key]))
        np.testing.assert_allclose(found, part * stuck, rtol=1e-9)
