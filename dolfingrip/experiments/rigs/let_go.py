"""A hold of the tip's face that is let go."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from dolfingrip.experiments.rigs.tip_load import dead_loads, load
from dolfingrip.mechanics.model.state import Memory

if TYPE_CHECKING:
    from dolfingrip.experiments.rigs.finger import Additions
    from dolfingrip.extensions.site import Site
    from dolfingrip.sections.release import Release


class LetGo(Memory):
    """The load along x that holds the tip's face, and fades from 0 s on.

    It is a parameter as well, which a place that is held depends on all others by.

    Args:
        release: how long it takes to fade.

    Attributes:
        load_N: of the whole face, up to 0 s.
        holds: whether the tip is held yet.
    """

    scale: float = 1.0
    direction: float = 1.0

    def __init__(self, release: Release) -> None:
        self._over_s = release.over_s
        self.load_N, self.holds = 0.0, False

    @contextmanager
    def applied(self, amount: float) -> Iterator[None]:
        """A context in which the load is another one."""
        kept = self.load_N
        self.load_N += amount * self.holds
        try:
            yield
        finally:
            self.load_N = kept

    def added(self, site: Site) -> Additions:
        """Add the load to a finger."""
        dead = dead_loads(site)
        self._force = site.parameters[load("x")]
        return replace(dead, memories=[self])

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set the load at the step's end."""
        self._force.value = self.load_N * min(max(1 - time_s / self._over_s, 0.0), 1.0)
