"""Section of the configuration for a finger, or a solid body, that is held and let go."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from pydantic import Field

from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.section import Refusal, Role, Section


class Release(Section):
    """A hold of the tip's face before 0 s, for long; with inertia the finger is let go."""

    role: ClassVar = Role.PROCEDURE
    felt_by: ClassVar = ("finger",)
    later: ClassVar = {"held_x_mm": None, "load_x_N": 0.0, "over_s": 0.01}

    held_x_mm: float | None = Field(
        None, description="held at this mean displacement from the shape as built: 0 is level"
    )
    load_x_N: float = Field(0.0, description="held by this dead load along x")
    over_s: float = Field(0.01, gt=0, description="time in which the hold fades, from 0 s on")

    @property
    def acts(self) -> bool:
        """Return whether the tip is held."""
        return self.held_x_mm is not None or self.load_x_N != 0

    def refuse(self, who: str) -> None:
        """Refuse a tip that is held and let go.

        Args:
            who: does not follow it.

        Raises:
            ConfigError: one line, if the tip is held.
        """
        if self.acts:
            raise ConfigError(f"release.{self.key}: {who} lets go of no tip; allowed: without it")

    @property
    def key(self) -> str:
        """Return the key that says how the tip is held."""
        return "load_x_N" if self.held_x_mm is None else "held_x_mm"

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if self.held_x_mm is not None and self.load_x_N:
            yield Refusal("load_x_N", "allowed: not beside held_x_mm")
