"""Places in the world of a solid's copies, which lie side by side in one reference mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from dolfingrip.meshes.solid import shares


@dataclass(frozen=True)
class Placement:
    """The places of a solid's copies: x = R_i (X + u − s_i) + o_i.

    Forms, internal variables and material axes belong to the solid in its reference mesh. Contact
    and gravity act in the world, so they use a placement.

    Attributes:
        rotations: (k, 3, 3) R_i.
        origins_mm: (k, 3) o_i.
        pitch_mm: copies are shifted along x, s_i = i times this; a copy's points have an x from
            ``start_mm`` to below ``start_mm`` + pitch, shift apart.
        start_mm: see above.
    """

    rotations: np.ndarray
    origins_mm: np.ndarray
    pitch_mm: float
    start_mm: float

    @classmethod
    def of(
        cls, extent_mm: tuple[float, float], rotations: np.ndarray, origins_mm: np.ndarray
    ) -> Self:
        """The placement of copies made by :mod:`~dolfingrip.meshes.solid`.

        Args:
            extent_mm: smallest and largest x of the reference points of all ranks.
            rotations: R_i.
            origins_mm: o_i.
        """
        return cls(rotations, origins_mm, *shares(*extent_mm, len(rotations)))

    @property
    def count(self) -> int:
        """Number of copies."""
        return len(self.rotations)

    def which(self, points: np.ndarray) -> np.ndarray:
        """Number of the copy that each of (n, 3) reference points belongs to, (n,)."""
        copies = np.floor((points[:, 0] - self.start_mm) / self.pitch_mm).astype(int)
        return np.asarray(np.clip(copies, 0, self.count - 1))

    def frames(self, points: np.ndarray) -> np.ndarray:
        """Rotations of the copies that (n, 3) reference points belong to, (n, 3, 3)."""
        return np.asarray(self.rotations[self.which(points)])

    def positions(self, points: np.ndarray) -> np.ndarray:
        """Places of undeformed reference points in the world (mm), (n, 3)."""
        which = self.which(points)
        shifted = points - np.outer(which * self.pitch_mm, [1.0, 0.0, 0.0])
        turned = np.einsum("nij,nj->ni", self.rotations[which], shifted)
        return np.asarray(turned + self.origins_mm[which])


def to_world(frames: np.ndarray | None, vectors: np.ndarray) -> np.ndarray:
    """Turn vectors from reference axes into the world.

    Args:
        frames: (n, 3, 3) axes of the reference in the world; None: the axes are equal.
        vectors: (n, 3) vectors in reference axes.

    Returns:
        (n, 3) vectors in the world, in the unit of the arguments.
    """
    return vectors if frames is None else np.einsum("nij,nj->ni", frames, vectors)


def to_reference(frames: np.ndarray | None, vectors: np.ndarray) -> np.ndarray:
    """Turn vectors of the world, or derivatives by them, into reference axes.

    Args:
        frames: (n, 3, 3) axes of the reference in the world; None: the axes are equal.
        vectors: (n, 3, …) vectors in the world.

    Returns:
        (n, 3, …) vectors in reference axes, in the unit of the arguments.
    """
    return vectors if frames is None else np.einsum("nji,nj...->ni...", frames, vectors)
