"""Section of the configuration for a base that moves: what a robot's arm or a shaker does."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.procedure import Times
from dolfingrip.sections.section import PURE, Numbers, Refusal, Role, Section, Vector


class BaseMotion(Section):
    """Acceleration of the clamp in time; places are seen from it, as by a camera on the base."""

    role: ClassVar = Role.PROCEDURE
    felt_by: ClassVar = ("finger",)
    later: ClassVar = {"time_s": (), "acceleration_m_s2": (), "direction": (1.0, 0.0, 0.0)}

    time_s: Times = Field((), description="of each acceleration; it is linear in between")
    acceleration_m_s2: Numbers = Field((), description="of the clamp; 0 before and after")
    direction: Annotated[Vector, PURE] = Field(
        (1.0, 0.0, 0.0), description="of the acceleration; z is from clamp to tip"
    )

    def refuse(self, who: str) -> None:
        """Refuse a base that moves.

        Args:
            who: does not follow it.

        Raises:
            ConfigError: one line, if it moves.
        """
        if self.time_s:
            raise ConfigError(f"base.time_s: {who} has a base at rest; allowed: without it")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        yield from self.as_many("acceleration_m_s2", "time_s")
        if len(self.time_s) == 1 or any(b <= a for a, b in pairwise(self.time_s)):
            yield Refusal("time_s", "allowed: two or more, each after the one before")
        yield from self.directed("direction")

    def velocity_mm_s(self, time_s: float) -> np.ndarray:
        """Velocity of the clamp, (3,), from rest.

        Args:
            time_s: since the start.
        """
        times, rates = np.array(self.time_s), 1000 * np.array(self.acceleration_m_s2)
        before = times < time_s
        until = np.append(times[before], min(time_s, times[-1]))
        gained = np.trapezoid(np.interp(until, times, rates), until)
        direction = np.asarray(self.direction, dtype=float)
        return np.asarray(gained * direction / np.linalg.norm(direction))
