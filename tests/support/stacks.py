"""Two cubes, one barrier's width apart along z."""

from __future__ import annotations

import numpy as np
from support import bodies

from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.surface import Surface

WIDTH = 0.02
STIFFNESS = 1.0
"""MPa, of the barrier: many times the blocks' pressure, so that the gap closes by little."""
NU = 0.3
PUSH = WIDTH / 2
TOP = 2 + WIDTH


def stacked(lower: int, upper: int) -> bodies.Body:
    """Unit cubes of ``lower``³ and ``upper``³ cells, one barrier's width apart along z."""
    solid = bodies.domain(
        bodies.join(
            [bodies.box((n, n, n)) for n in (lower, upper)],
            np.array([[0, 0, 0], [0, 0, 1 + WIDTH]]),
        ),
        {"skin": lambda x: np.ones(x.shape[1], dtype=bool)},
    )
    body = bodies.body(solid, 1, nu=NU)
    surface = Surface(body.u.function_space, solid, solid.facets("skin"))
    body.touch(BarrierContact(surface, WIDTH, STIFFNESS))
    return body


def is_upper(points: np.ndarray) -> np.ndarray:
    """Which of (n, 3) points at rest belong to the upper cube."""
    return np.asarray(points[:, 2] > 1 + WIDTH / 2)
