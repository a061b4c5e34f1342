"""Pairs of contact inherit the elastic displacement of points that stick."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from dolfingrip.mechanics.contact.policy import MEMORY
from dolfingrip.mechanics.contact.tangential import Tangential

TINY = np.finfo(float).tiny
"""A number that avoids 0/0."""


def handed_on(start: Tangential, stuck: np.ndarray, now: Tangential) -> np.ndarray:
    """(m, 3) elastic displacement (mm) of the pairs ``now``.

    A pair keeps its memory. A new pair takes the mean of its nodes' memories; a vertex that slides
    to the next triangle makes such a pair. If the normal force grows by more than the factor
    ``MEMORY.most_growth``, memory fades. Such a point had nearly left, and a finger that is pressed
    on its plate again must not feel how it last slid off.

    Args:
        start: pairs at the load step's start.
        stuck: (n, 3) elastic displacements of these pairs.
        now: pairs in contact now.
    """
    known = {tuple(key): i for i, key in enumerate(start.keys.tolist())}
    before = np.array([known.get(tuple(key), -1) for key in now.keys.tolist()], dtype=np.int64)
    old, new = np.flatnonzero(before >= 0), np.flatnonzero(before < 0)
    found, share = np.zeros((len(before), 3)), np.ones(len(before))
    found[old] = stuck[before[old]]
    share[old] = start.normal_N[before[old]] / now.normal_N[old]
    if len(stuck) and len(new):
        weights = abs(now.weights[new])
        found[new] = _of_nodes(start, stuck, now.weights[new])
        share[new] = weights @ start.pressed_N() / np.maximum(weights @ now.pressed_N(), TINY)
    return np.asarray(found * np.minimum(MEMORY.most_growth * share, 1.0)[:, None])


def _of_nodes(start: Tangential, stuck: np.ndarray, weights: sp.csr_matrix) -> np.ndarray:
    """(j, 3) mean memory of the nodes of new pairs.

    The memory of a node is the mean over its pairs, weighted by normal force and by the node's part
    in them. The sign of that part counts, so that both sides of a contact have opposite memories.
    """
    part = start.pressed_N()
    at_nodes = np.asarray(start.weights.T @ (start.normal_N[:, None] * stuck))
    at_nodes /= np.maximum(part, TINY)[:, None]
    size = abs(weights) @ (part > 0).astype(float)
    return np.asarray(weights @ at_nodes) / np.maximum(size, TINY)[:, None]
