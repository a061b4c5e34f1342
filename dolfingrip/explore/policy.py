"""The numbers of the explorer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class ExplorePolicy:
    """How the explorer behaves.

    Attributes:
        port: at which it listens if none is asked for; the next ones are tried where it is taken.
        ports: how many are tried.
        steps: readings up to the highest pressure, where a campaign has fewer.
        neighbours: solved designs that one is interpolated between.
        checked: solved designs from which on the interpolation's error is estimated.
        same: distance of two designs, in shares of the sliders' ranges, up to which they are one.
        grasp_step_kPa: between readings of a grasp.
        largest_message: bytes that a tab may send at once.
        half_open: connections whose request has not arrived yet, at one time.
        request_s: time that a request may take to arrive.
    """

    port: int = 8760
    ports: int = 20
    steps: int = 12
    neighbours: int = 12
    checked: int = 4
    same: float = 1e-6
    grasp_step_kPa: float = 25.0
    largest_message: int = 100_000
    half_open: int = 64
    request_s: float = 10.0


POLICY: Final = ExplorePolicy()
