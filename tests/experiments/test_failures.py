"""What a failed path means in an experiment, in words."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from dolfingrip.experiments.loop import explained
from dolfingrip.mechanics.path.failure import Failure, FailureKind


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (FailureKind.TIME_LIMIT, "solver.time_limit_s is over"),
        (
            FailureKind.LIMIT_POINT,
            "the coupon goes soft here (its stiffness vanishes): displacement control cannot "
            "follow it",
        ),
    ],
)
def test_words_are_those_of_the_rig(kind: FailureKind, said: str) -> None:
    rig: Any = SimpleNamespace(
        softening="the coupon goes soft here", quantity="displacement",
        advice=lambda failure: "go on",
    )  # fmt: skip
    failure = explained(Failure(kind, {"displacement_mm": 80.0, "time_s": 3.0}), rig)
    assert failure.sentence() == f"stopped at 80 mm ({kind}): {said}; go on"
