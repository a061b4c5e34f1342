"""The pairs of a normal contact, with all that friction needs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp

from dolfingrip.mechanics.contact.node_set import NodeSet
from dolfingrip.mechanics.model.term import Term


@dataclass(frozen=True, slots=True)
class Tangential:
    """Pairs in contact at one displacement: relative displacements and normal forces.

    All ranks hold the same pairs. A pair's tangent plane is given by its normal, and tangential
    vectors have three components, so that they can be moved from one plane to another.

    Attributes:
        weights: (m, k) weights of the nodes' displacements in each pair's relative displacement.
        normals: (m, 3) unit normals of the pairs.
        normal_N: (m,) normal forces, positive.
        rise_N_per_mm: (m,) increase of the normal forces as the pairs' distances fall.
        keys: (m, q) identity of each pair, equal from step to step.
    """

    weights: sp.csr_matrix
    normals: np.ndarray
    normal_N: np.ndarray
    rise_N_per_mm: np.ndarray
    keys: np.ndarray

    @classmethod
    def none(cls, nodes: int, width: int) -> Self:
        """No pair among so many nodes, with keys of ``width`` numbers."""
        empty = np.zeros((0, 3))
        keys = np.zeros((0, width), dtype=np.int64)
        return cls(sp.csr_matrix((0, nodes)), empty, np.zeros(0), np.zeros(0), keys)

    def pressed_N(self) -> np.ndarray:
        """Sizes of the normal forces that each node takes part in, (k,)."""
        return np.asarray(abs(self.weights).T @ self.normal_N)

    def pressing_N(self) -> np.ndarray:
        """Normal forces on the nodes, (k, 3)."""
        return np.asarray(self.weights.T @ (self.normal_N[:, None] * self.normals))

    def flat(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors of the pairs without their parts along the normals, (m, 3)."""
        along = np.einsum("ij,ij->i", vectors, self.normals)
        return np.asarray(vectors - along[:, None] * self.normals)

    def slip(self, moved: np.ndarray) -> np.ndarray:
        """Tangential relative displacements for (k, 3) displacements of the nodes, (m, 3)."""
        return self.flat(self.weights @ moved)

    def spread(self, blocks: np.ndarray) -> sp.csr_matrix:
        """Matrix (3k, 3k) at the nodes of (m, 3, 3) blocks of the pairs' relative displacements."""
        count = np.arange(len(blocks) + 1)
        within = sp.bsr_matrix((blocks, count[:-1], count), shape=(3 * len(blocks),) * 2)
        weights = sp.kron(self.weights, sp.eye_array(3), format="csr")
        return sp.csr_matrix(weights.T @ within @ weights)

    def pressed_more_N(self, moved: np.ndarray, facing: np.ndarray) -> np.ndarray:
        """Rise of the normal forces for (k, 3) displacements of the nodes, (m,).

        Args:
            moved: displacements.
            facing: (3,) displacement of the body that the pairs touch, if it is no node.
        """
        apart = np.einsum("ij,ij->i", self.weights @ moved - facing, self.normals)
        return np.asarray(-self.rise_N_per_mm * apart)

    # -- arrays, which a state stores --------------------------------------------------------------

    def arrays(self) -> dict[str, np.ndarray]:
        """All arrays by name."""
        return {
            "weights": self.weights.data,
            "columns": self.weights.indices,
            "starts": self.weights.indptr,
            "normals": self.normals,
            "normal_N": self.normal_N,
            "rise_N_per_mm": self.rise_N_per_mm,
            "keys": self.keys,
        }

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, np.ndarray], nodes: int) -> Self:
        """The pairs whose arrays :meth:`arrays` returned, among so many nodes."""
        normal_N = arrays["normal_N"]
        parts = (arrays["weights"], arrays["columns"], arrays["starts"])
        weights = sp.csr_matrix(parts, shape=(len(normal_N), nodes))
        rise = arrays["rise_N_per_mm"]
        return cls(weights, arrays["normals"], normal_N, rise, arrays["keys"])


class Touching(Term):
    """A normal contact that friction can act on."""

    @property
    @abstractmethod
    def touching(self) -> NodeSet:
        """Nodes and bodies that its pairs may move with."""

    @abstractmethod
    def tangential(self, dofs: np.ndarray) -> Tangential:
        """Pairs of the contact at the displacement ``dofs``."""

    def facing(self, step: np.ndarray) -> np.ndarray:
        """Displacement in a step of the unknowns of the body that pairs touch, if no node, (3,)."""
        return np.zeros(3)
