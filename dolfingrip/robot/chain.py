"""A chain of links with laws at its joints, and its equilibrium.

The finger bends in the plane (x, z). The coordinates w of all joints are numbered from clamp to
tip, those of one joint as :data:`COORDINATES` has them. Arrays have the states as first axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

COORDINATES: Final = (
    ("slide", "slide", (0.0, 0.0, 1.0)),
    ("shear", "slide", (1.0, 0.0, 0.0)),
    ("bend", "hinge", (0.0, -1.0, 0.0)),
    ("side", "hinge", (1.0, 0.0, 0.0)),
    ("twist", "hinge", (0.0, 0.0, 1.0)),
)
"""Coordinates of a joint: name, kind, and axis in the axes of the finger at rest."""

TERMS: Final = 4
"""Coefficients of a law a p + b p w + c w + d p²."""

_ITERATIONS: Final = 200

_DONE_N: Final = 1e-9
"""Residual at which Newton's method ends (N, or N·mm)."""

_LARGEST_STEP: Final = 0.2
"""Angle by which a hinge turns at most in a step (rad), and way of a slide by the chain's length.
Laws without an equilibrium, which a fit may try, lead away no faster."""

_HALVINGS: Final = 30

_LEAST: Final = 1e-3
"""Stiffness below which no direction counts, as where the chain would buckle."""


@dataclass(frozen=True)
class Points:
    """Points that are fixed to links.

    Attributes:
        rest_mm: (points, 3) places at rest.
        link: (points,) links they belong to; 0 is the one that is clamped.
    """

    rest_mm: np.ndarray
    link: np.ndarray


@dataclass(frozen=True)
class Plates:
    """A rigid plate for each state, whose normal is x.

    Attributes:
        x_mm: (states,) place of the plate; −∞ where there is none.
        points: points of the chain that meet it.
        stiffness_N_per_mm: of the contact.
    """

    x_mm: np.ndarray
    points: Points
    stiffness_N_per_mm: float


@dataclass(frozen=True)
class Loads:
    """Dead loads, such as weights.

    Attributes:
        points: of the chain that bear them.
        forces_N: (points, 3).
    """

    points: Points
    forces_N: np.ndarray


@dataclass(frozen=True)
class Chain:
    """Places of joints.

    Attributes:
        joints_mm: (joints, 3) places of the hinges at rest, from clamp to tip.
    """

    joints_mm: np.ndarray

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(COORDINATES) * len(self.joints_mm)

    def of(self, *names: str) -> np.ndarray:
        """Return the numbers of the coordinates of some names."""
        those = [name in names for name, _, _ in COORDINATES]
        return np.flatnonzero(np.tile(those, len(self.joints_mm)))

    @property
    def bends(self) -> np.ndarray:
        """Numbers of the hinges in the plane of bending among the coordinates."""
        return self.of("bend")

    @property
    def _rest_mm(self) -> np.ndarray:
        """Places at which the links begin."""
        return np.vstack([np.zeros(3), self.joints_mm])

    @property
    def turning(self) -> np.ndarray:
        """Which coordinates are hinges."""
        return np.tile([kind == "hinge" for _, kind, _ in COORDINATES], len(self.joints_mm))

    def fixed(self, rest_mm: np.ndarray) -> Points:
        """Fix points to the links on which they lie at rest.

        Args:
            rest_mm: (points, 3) places.
        """
        at_rest = np.asarray(rest_mm, dtype=float)
        return Points(at_rest, np.searchsorted(self.joints_mm[:, 2], at_rest[:, 2], side="right"))

    def frames(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return where the links are, and the axes of their joints.

        Args:
            w: (…, coordinates) mm and rad.

        Returns:
            Present places (…, links, 3) of the joint that each link begins with, the first one the
            origin; turns (…, links, 3, 3) of the links; and axes (…, coordinates, 3).
        """
        centres = [np.zeros((*w.shape[:-1], 3))]
        turns = [np.broadcast_to(np.eye(3), (*w.shape[:-1], 3, 3))]
        axes, left = [], iter(np.moveaxis(w, -1, 0))
        for step in np.diff(self._rest_mm, axis=0):
            turn = turns[-1]
            centre = centres[-1] + turn @ step
            for _, kind, axis in COORDINATES:
                axes.append(turn @ np.array(axis))
                if kind == "slide":
                    centre = centre + axes[-1] * next(left)[..., None]
                else:
                    turn = (
                        turn @ Rotation.from_rotvec(np.multiply.outer(next(left), axis)).as_matrix()
                    )
            centres.append(centre)
            turns.append(turn)
        return np.stack(centres, -2), np.stack(turns, -3), np.stack(axes, -2)

    def places(self, w: np.ndarray, points: Points) -> np.ndarray:
        """Return where points are.

        Args:
            w: (…, coordinates) mm and rad.
            points: of the links.

        Returns:
            (…, points, 3) places (mm).
        """
        centres, turns, _ = self.frames(w)
        arms = points.rest_mm - self._rest_mm[points.link]
        turned = np.einsum("...pij,pj->...pi", turns[..., points.link, :, :], arms)
        return np.asarray(centres[..., points.link, :] + turned)

    def slopes(self, w: np.ndarray, points: Points) -> np.ndarray:
        """Return derivatives of places by the coordinates, (…, points, coordinates, 3)."""
        centres, _, axes = self.frames(w)
        arms = self.places(w, points)[..., :, None, :] - centres[..., None, self._joint, :]
        along = axes[..., None, :, :]
        slopes = np.where(self.turning[:, None], np.cross(along, arms), along)
        return np.where(self._moving(points), slopes, 0.0)

    def spins(self, w: np.ndarray, points: Points) -> np.ndarray:
        """Return derivatives of the turns of points' links, (…, points, coordinates, 3)."""
        axes = self.frames(w)[2][..., None, :, :]
        return np.where(self._moving(points) & self.turning[:, None], axes, 0.0)

    @property
    def _joint(self) -> np.ndarray:
        """Link before which each coordinate stands."""
        return np.arange(self.size) // len(COORDINATES) + 1

    def _moving(self, points: Points) -> np.ndarray:
        """Which coordinates move which points, (points, coordinates, 1)."""
        return (self._joint <= points.link[:, None])[..., None]

    def curvatures(self, w: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Return second derivatives of a point's place by the coordinates.

        Args:
            w: (…, coordinates) mm and rad.
            slopes: (…, coordinates, 3) of the point, from :meth:`slopes`.

        Returns:
            (…, coordinates, coordinates, 3); a hinge turns the slopes of all that comes later.
        """
        axes = np.where(self.turning[:, None], self.frames(w)[2], 0.0)
        order = np.arange(self.size)
        first, later = np.minimum(order[:, None], order), np.maximum(order[:, None], order)
        return np.cross(axes[..., first, :], slopes[..., later, :])


def terms(w: np.ndarray, pressures_kPa: np.ndarray) -> np.ndarray:
    """Return what the coefficients of the laws are multiplied by, (states, coordinates, 4)."""
    p = np.broadcast_to(pressures_kPa[:, None], w.shape)
    return np.stack([p, p * w, w, p * p], axis=-1)


def stiffnesses(laws: np.ndarray, pressures_kPa: np.ndarray) -> np.ndarray:
    """Return the stiffness of each coordinate, −∂(law)/∂w, (states, coordinates)."""
    return -(laws[:, 1] * pressures_kPa[:, None] + laws[:, 2])


@dataclass(frozen=True)
class Equilibrium:
    """Equilibria of a chain.

    Attributes:
        w: (states, coordinates).
        stiffness: (states, coordinates, coordinates), the negative derivative of all forces by w.
        forces_N: (states,) on the plates.
        pressing: (states, coordinates) derivatives of these forces by w.
    """

    w: np.ndarray
    stiffness: np.ndarray
    forces_N: np.ndarray
    pressing: np.ndarray


def equilibrium(
    chain: Chain, laws: np.ndarray, pressures_kPa: np.ndarray, plates: Plates, start: np.ndarray,
    loads: Loads | None = None,
) -> Equilibrium:  # fmt: skip
    """Find equilibria by Newton's method, all states at once.

    Args:
        chain: links and joints.
        laws: (coordinates, 4) coefficients.
        pressures_kPa: (states,).
        plates: that the chain meets.
        start: (states, coordinates) where the search begins.
        loads: that act in all states; None: none.
    """

    def energy(w: np.ndarray) -> np.ndarray:
        depth = np.maximum(plates.x_mm[:, None] - chain.places(w, plates.points)[..., 0], 0.0)
        p = pressures_kPa[:, None]
        a, b, c, d = laws.T
        inner = -((a + d * p) * p + 0.5 * (b * p + c) * w) * w
        total = inner.sum(axis=1) + 0.5 * plates.stiffness_N_per_mm * (depth**2).sum(axis=1)
        if loads is not None:
            total -= np.einsum("smk,mk->s", chain.places(w, loads.points), loads.forces_N)
        return np.asarray(total)

    reach = np.where(chain.turning, 1.0, chain.joints_mm[-1, 2])
    w = start.copy()
    level = energy(w)
    for _ in range(_ITERATIONS):
        balance = _balance(chain, laws, pressures_kPa, plates, loads, w)
        residual, stiffness = balance[0], balance[1].stiffness
        if np.abs(residual).max() < _DONE_N:
            break
        values, vectors = np.linalg.eigh(stiffness)
        along = np.einsum("sij,si->sj", vectors, residual) / np.maximum(np.abs(values), _LEAST)
        step = np.einsum("sij,sj->si", vectors, along)
        farthest = (np.abs(step) / reach).max(axis=1)
        step *= (_LARGEST_STEP / np.maximum(farthest, _LARGEST_STEP))[:, None]
        slope = (residual * step).sum(axis=1)
        part = np.ones(len(w))
        for _ in range(_HALVINGS):
            tried = w + part[:, None] * step
            risen = energy(tried) > level - 1e-4 * part * slope + 1e-9
            if not risen.any():
                break
            part[risen] *= 0.5
        w = w + part[:, None] * step
        level = energy(w)
    return balance[1]


def _balance(
    chain: Chain, laws: np.ndarray, pressures_kPa: np.ndarray, plates: Plates,
    loads: Loads | None, w: np.ndarray,
) -> tuple[np.ndarray, Equilibrium]:  # fmt: skip
    """Sum of all forces, and what an equilibrium tells, at any coordinates."""
    slopes = chain.slopes(w, plates.points)
    along = slopes[..., 0]
    depth = plates.x_mm[:, None] - chain.places(w, plates.points)[..., 0]
    force = plates.stiffness_N_per_mm * np.maximum(depth, 0.0)
    touching = plates.stiffness_N_per_mm * (depth > 0)
    stiffness = np.einsum("smi,smj,sm->sij", along, along, touching)
    for m in range(len(plates.points.link)):
        stiffness -= chain.curvatures(w, slopes[:, m])[..., 0] * force[:, m, None, None]
    diagonal = np.arange(w.shape[1])
    stiffness[:, diagonal, diagonal] += stiffnesses(laws, pressures_kPa)
    residual = np.einsum("sik,ik->si", terms(w, pressures_kPa), laws)
    residual += np.einsum("smi,sm->si", along, force)
    if loads is not None:
        lowering = chain.slopes(w, loads.points)
        residual += np.einsum("smik,mk->si", lowering, loads.forces_N)
        for m, load in enumerate(loads.forces_N):
            stiffness -= chain.curvatures(w, lowering[:, m]) @ load
    pressing = -np.einsum("smi,sm->si", along, touching)
    return residual, Equilibrium(w, stiffness, force.sum(axis=1), pressing)
