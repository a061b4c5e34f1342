"""A motion of places that a scheme of :mod:`dolfingrip.forms.inertia` takes through time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from dolfingrip.forms.inertia import Scheme


class TimeIntegrator:
    """Places, velocities and accelerations at a load step's start, and what they predict.

    Where no time passes, only places change.

    Args:
        name: first part of the names of stored values.
        places: at the start, at rest (mm).
        scheme: of the next steps; it may be changed between steps.

    Attributes:
        places, velocity, acceleration: at the step's start, of the shape of ``places`` (mm, mm/s,
            mm/s²); the acceleration is seen from what falls freely.
        ahead: û of the step (mm).
        stiffness: k of the step (1/s²); 0 if no time passes.
    """

    def __init__(self, name: str, places: np.ndarray, scheme: Scheme) -> None:
        self._name, self.scheme = name, scheme
        self.places = self._predicted = self.ahead = places.copy()
        self.velocity, self.acceleration, self._forces = (np.zeros_like(places) for _ in range(3))
        self._step_s = self.stiffness = 0.0
        self._falls: np.ndarray | float = 0.0

    def start(self, velocity: np.ndarray, acceleration: np.ndarray) -> None:
        """Begin with a motion (mm/s and mm/s²) that is in balance."""
        self.velocity, self.acceleration = velocity.copy(), acceleration.copy()
        self._forces = -self.acceleration

    def set_step(self, step_s: float, falls: np.ndarray | float = 0.0) -> None:
        """Predict the end of a step, in which all falls with an acceleration (mm/s²)."""
        alpha, beta, _, delta = self.scheme
        self._step_s, self._falls = step_s, falls
        moved = delta * self.acceleration + (delta + beta) * falls
        self._predicted = self.places + step_s * self.velocity + step_s**2 * moved
        self.ahead = self._predicted + alpha * beta * step_s**2 * self._forces
        self.stiffness = 1 / ((1 + alpha) * beta * step_s**2) if step_s > 0 else 0.0

    def end_acceleration(self, places: np.ndarray) -> np.ndarray:
        """Acceleration of places that the step leads to, seen from what falls freely (mm/s²)."""
        if not self._step_s:
            return np.zeros_like(places) - self._falls
        return (places - self._predicted) / (self.scheme.beta * self._step_s**2)

    def end_velocity(self, places: np.ndarray) -> np.ndarray:
        """Velocity of places that the step leads to (mm/s)."""
        gamma = self.scheme.gamma
        change = (1 - gamma) * self.acceleration + gamma * self.end_acceleration(places)
        return self.velocity + self._step_s * (change + self._falls)

    def end_forces(self, places: np.ndarray) -> np.ndarray:
        """Slopes of all else's potential by mass at places that the step leads to (mm/s²)."""
        alpha = self.scheme.alpha
        return (alpha * self._forces - self.end_acceleration(places)) / (1 + alpha)

    def error_mm(self, places: np.ndarray) -> float:
        """Largest error of places that the step leads to; 0 if no time passes.

        The scheme lacks (β − 1/6) Δt² (a − a₀) of them (Zienkiewicz & Xie, Earthquake Eng. Struct.
        Dyn. 20, 1991).
        """
        change = self.end_acceleration(places) - self.acceleration
        lacking = (self.scheme.beta - 1 / 6) * self._step_s**2
        return float(lacking * np.abs(change).max(initial=0.0))

    def accept(self, places: np.ndarray) -> None:
        """Take the places that the step led to."""
        if self._step_s:
            self.velocity, self.acceleration, self._forces = (
                self.end_velocity(places),
                self.end_acceleration(places),
                self.end_forces(places),
            )
        self.places = places.copy()

    def values(self) -> dict[str, np.ndarray]:
        """The motion, by name."""
        stored = (self.places, self.velocity, self.acceleration, self._forces)
        return {
            f"{self._name}.{key}": array.copy() for key, array in zip(_NAMES, stored, strict=True)
        }

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Set the motion."""
        self.places, self.velocity, self.acceleration, self._forces = (
            values[f"{self._name}.{key}"].copy() for key in _NAMES
        )


_NAMES: Final = ("before_mm", "velocity", "acceleration", "forces_by_mass")
