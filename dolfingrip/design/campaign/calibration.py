"""The friction that pick-up pressures tell of, by grasps."""

from __future__ import annotations

from dataclasses import dataclass

from dolfingrip.config import ConfigError
from dolfingrip.design.campaign.policy import SEARCH
from dolfingrip.design.campaign.threshold import least
from dolfingrip.design.campaign.trials import Trial, Trials


@dataclass(frozen=True, slots=True)
class FrictionFound:
    """The friction with which a pressure is the least that picks up.

    Attributes:
        low: least coefficient on the grid that picks up at that pressure.
        high: the largest that does not at the next lower one; between the two the least pressure
            that picks up is the measured one.
    """

    low: float
    high: float

    @property
    def friction(self) -> float:
        """The middle of the interval."""
        return (self.low + self.high) / 2


def friction(
    trials: Trials, pickup_kPa: float, resolution_kPa: float, tolerance: float
) -> FrictionFound:
    """The friction for which ``pickup_kPa`` is the least pressure that picks up.

    μ*(p) is the least friction with which pressure p picks up; it falls as p grows. A pick-up
    pressure that was found in steps of the resolution r says that μ*(p) ≤ μ < μ*(p − r). Both are
    searched for from μ = W/ΣN on, with ΣN of one grasp.

    Args:
        trials: grasps.
        pickup_kPa: p.
        resolution_kPa: r.
        tolerance: of μ*.

    Raises:
        ConfigError: one line, where no friction does.
    """
    first = trials.at(pickup_kPa, trials.base.food.friction)
    at_pressure = _least_friction(trials, pickup_kPa, first, tolerance)
    below = trials.at(pickup_kPa - resolution_kPa, at_pressure)
    at_lower = _least_friction(
        trials, pickup_kPa - resolution_kPa, below, tolerance, round(at_pressure / tolerance)
    )
    return FrictionFound(at_pressure, max(at_lower - tolerance, at_pressure))


def _least_friction(
    trials: Trials, pressure_kPa: float, known: Trial, tolerance: float, low: int = 1
) -> float:
    """μ* at a pressure, on a grid of ``tolerance``.

    Args:
        trials: grasps.
        pressure_kPa: the pressure.
        known: a grasp there.
        tolerance: distance of places.
        low: place that no answer is below, as of a higher pressure.
    """
    start = known.weight_N / known.normal_N if known.normal_N > 0 else known.friction
    found = least(
        lambda place: trials.at(pressure_kPa, place * tolerance).picked_up,
        round(start / tolerance), low, round(SEARCH.largest_friction / tolerance),
    )  # fmt: skip
    if found.succeeds is None:
        raise ConfigError(
            f"--pickup-pressure {pressure_kPa:g}: no friction up to {SEARCH.largest_friction:g} "
            "picks the food up there; allowed: a higher pressure, or another pose"
        )
    return found.succeeds * tolerance
