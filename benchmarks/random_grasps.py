"""Random grasps: food, pose, pressure and friction at random; how many end in a class of outcome.

    scripts/run python -m benchmarks.random_grasps [--number 100] [--seed 0] [--workers 1]
        [--out out/random_grasps] [--publish]

Food is one of the kinds, the pose scoop, pinch or claw, the pressure 100 to 300 kPa, friction 0.1
to 0.8; a gripper that cannot stand so is drawn again. The mesh is the coarse preset. A longer table
of the same seed contains the shorter one, and a call resumes one that was killed.

``random_grasps.csv`` has a row for each grasp that was computed, ``summary.md`` the counts;
``--publish`` writes the table beside this file, too.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import numpy as np

from benchmarks import grasp_campaign
from benchmarks.grasp_campaign import FOOD, FRICTION, POSE, PRESSURE
from dolfingrip import config as configuration
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.sections.food import ORDINARY
from dolfingrip.sections.gripper import GripPose

PRESSURES_KPA, FRICTIONS = (100.0, 300.0), (0.1, 0.8)

TABLE = Path(__file__).with_suffix(".csv")


def draw(number: int, seed: int, possible: Callable[[Inputs], bool]) -> list[Inputs]:
    """The first ``number`` possible grasps of a seed."""
    rng = np.random.default_rng(seed)
    found: list[Inputs] = []
    while len(found) < number:
        inputs: Inputs = {
            FOOD: str(rng.choice(list(ORDINARY))),
            POSE: str(rng.choice(list(get_args(GripPose)))),
            PRESSURE: round(float(rng.uniform(*PRESSURES_KPA)), 1),
            FRICTION: round(float(rng.uniform(*FRICTIONS)), 3),
        }
        if possible(inputs):
            found.append(inputs)
    return found


class Standing:
    """Whether fingers can stand around food so; each food and pose is tried once."""

    def __init__(self, shared: Config) -> None:
        self._shared = shared
        self._known: dict[tuple[object, object], bool] = {}

    def __call__(self, inputs: Inputs) -> bool:
        key = inputs[FOOD], inputs[POSE]
        if key not in self._known:
            self._known[key] = self._try(inputs)
        return self._known[key]

    def _try(self, inputs: Inputs) -> bool:
        from dolfingrip.experiments.rigs.grasped import grasped
        from dolfingrip.experiments.rigs.gripper import stands_of

        design = grasp_campaign.plan([inputs], self._shared).designs()[0]
        config = configuration.from_dict(design.config)
        try:
            stands_of(config, grasped(config.food))
        except ConfigError:
            return False
        return True


def main() -> int:
    """Run what is missing, then write table and summary."""
    parser = grasp_campaign.options(
        "random_grasps", "Random grasps, and how many end in a class of outcome."
    )
    parser.add_argument("--number", type=int, default=100, metavar="N", help="default: 100")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="default: 0")
    asked = parser.parse_args()
    if asked.number < 1:
        parser.error(f"--number {asked.number}: allowed: 1 or more")
    shared = configuration.load(None, asked.overrides, grasp_campaign.OURS)
    points = draw(asked.number, asked.seed, Standing(shared))
    rows = grasp_campaign.compute(points, shared, asked)
    said = f"Random grasps of seed {asked.seed}, coarse preset"
    summary = grasp_campaign.counted(rows, said, asked.number, "97 % or more")
    grasp_campaign.publish(rows, summary, asked, TABLE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
