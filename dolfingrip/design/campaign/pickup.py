"""The least pressure that picks food up, by grasps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from dolfingrip.design.campaign.threshold import least
from dolfingrip.design.campaign.trials import Trial, Trials

HIGHEST_kPa: Final = 300.0
"""The paper's highest pressure."""

ESTIMATES: Final = 4
"""Grasps at most that are made to estimate the pressure."""


@dataclass(frozen=True, slots=True)
class Pickup:
    """The least pressure that picks up.

    Attributes:
        fails_kPa: highest pressure below that was tried and does not; None where there is none.
        least_kPa: that pressure; None where none up to the highest does.
    """

    fails_kPa: float | None
    least_kPa: float | None


def pickup_pressure(
    trials: Trials,
    resolution_kPa: float,
    start_kPa: float,
    highest_kPa: float = HIGHEST_kPa,
    estimates: int = ESTIMATES,
) -> Pickup:
    """The least multiple of ``resolution_kPa`` at which the food is picked up.

    The first grasp tells how hard the fingers press. Where normal forces grow with the pressure and
    friction bears the weight, W = μ ΣN at the pressure that is sought; so the next grasp is there.
    Once that changes little, grasps on either side confirm it.

    Args:
        trials: grasps; the friction is that of their configuration.
        resolution_kPa: distance of pressures.
        start_kPa: pressure of the first grasp.
        highest_kPa: none above is tried.
        estimates: grasps at most from which the pressure is estimated; 0 where the start is near.
    """
    friction = trials.base.food.friction
    highest = int(highest_kPa / resolution_kPa + 1e-9)

    def trial(place: int) -> Trial:
        return trials.at(place * resolution_kPa, friction)

    place = min(max(round(start_kPa / resolution_kPa), 1), highest)
    for _ in range(estimates):
        made = trial(place)
        if friction <= 0 or made.normal_N <= 0:
            break
        guess = round(place * made.weight_N / (friction * made.normal_N))
        # not far beyond what this grasp has shown
        guess = min(guess, place) if made.picked_up else min(max(guess, place), 2 * place)
        guess = min(max(guess, 1), highest)
        if abs(guess - place) <= 1:
            break
        place = guess
    found = least(lambda at: trial(at).picked_up, place, 1, highest)
    return Pickup(*(None if place is None else place * resolution_kPa for place in found))
