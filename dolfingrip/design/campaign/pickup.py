"""The least pressure that picks food up, by grasps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dolfingrip.design.campaign.policy import SEARCH
from dolfingrip.design.campaign.threshold import least
from dolfingrip.design.campaign.trials import Trial, Trials


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
    highest_kPa: float = SEARCH.highest_kPa,
) -> Pickup:
    """The least multiple of ``resolution_kPa`` at which the food is picked up.

    Each grasp tells how hard the fingers press. Where friction bears the weight, W = μ ΣN at the
    pressure that is sought; so the next grasp is there, by the normal forces of those before it.
    Then grasps on either side confirm it.

    Args:
        trials: grasps; the friction is that of their configuration.
        resolution_kPa: distance of pressures.
        start_kPa: pressure of the first grasp.
        highest_kPa: none above is tried.
    """
    friction = trials.base.food.friction
    highest = int(highest_kPa / resolution_kPa + 1e-9)

    def trial(place: int) -> Trial:
        return trials.at(place * resolution_kPa, friction)

    place = min(max(round(start_kPa / resolution_kPa), 1), highest)
    made: dict[int, Trial] = {}
    fails, succeeds = 0, highest + 1
    for _ in range(SEARCH.estimates):
        made[place] = trial(place)
        if made[place].picked_up:
            succeeds = min(succeeds, place)
        else:
            fails = max(fails, place)
        # not far beyond what grasps have shown
        guess = min(max(_bearing(made, friction), fails + 1), succeeds - 1, 2 * place, highest)
        if succeeds <= fails + 1 or guess in made:
            break
        place = guess
    low, high = max(fails, 1), min(succeeds, highest)
    found = least(lambda at: trial(at).picked_up, place, low, high)
    return Pickup(*(None if place is None else place * resolution_kPa for place in found))


def _bearing(made: Mapping[int, Trial], friction: float) -> int:
    """The place at which μ ΣN is the weight: ΣN straight between grasps, and beyond the last."""
    places = [0, *sorted(made)]
    normals = np.maximum.accumulate([0.0, *(made[place].normal_N for place in places[1:])])
    wanted = made[places[1]].weight_N / max(friction, 1e-9)
    if wanted <= normals[-1]:
        return round(float(np.interp(wanted, normals, places)))
    if normals[-1] <= 0:
        return 2 * places[-1]
    return round(min(places[-1] * wanted / normals[-1], 2 * places[-1]))
