"""What became of a grasp, by made-up moments."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.experiments.results.outcome import Kind, Moment, judge

LIFT_S = 1.0


def moment(
    time_s: float, z: float, fingers: float, table: float, rise: float = 0.0, x: float = 0.0
) -> Moment:
    return Moment(time_s, time_s > LIFT_S, np.array([x, 0.0, z]), rise, np.full(3, fingers), table)


START = [moment(0.0, 20.0, 0.0, 1.0), moment(0.5, 20.0, 1.0, 0.6), moment(1.0, 20.0, 2.0, 0.1)]


@pytest.mark.parametrize(
    ("then", "kind", "at", "said"),
    [
        ([moment(1.5, 19.8, 2, 0, 9), moment(2, 19.8, 2, 0, 20)], Kind.PICKED_UP, 1.5, "by 20 mm"),
        ([moment(1.5, 19, 2, 0, 9), moment(2, 12, 2, 0, 12)], Kind.SLIPPED, 2.0, "sank by 8.0 mm"),
        ([moment(1.5, 19, 2, 0, 9), moment(2, 0, 0, 1, 0)], Kind.DROPPED, 1.5, "9 mm up"),
        ([moment(1.5, 10, 1, 0.9, 0), moment(2, 0, 1, 0.9, 0)], Kind.NOT_LIFTED, 1.5, "10 %"),
        ([moment(1.5, 10, 0, 1, 0), moment(2, 0, 0, 1, 0)], Kind.NOT_LIFTED, 1.5, "no finger"),
        ([moment(1.5, 20, 0, 0, 9, x=40)], Kind.EJECTED, 1.0, "sideways at 1.00 s"),
        ([moment(1.5, 50, 0, 0, 30)], Kind.EJECTED, 1.0, "upwards at 1.00 s"),
    ],
)
def test_classes(then: list[Moment], kind: Kind, at: float, said: str) -> None:
    found = judge([*START, *then], complete=True)
    assert found is not None
    assert found.kind is kind
    assert found.time_s == at
    assert said in found.sentence


def test_a_run_that_ended_early_has_no_class_unless_it_is_clear() -> None:
    assert judge(START, complete=False) is None
    assert judge([], complete=False) is None
    out = judge([*START, moment(1.2, 20, 0, 1, 0, x=30)], complete=False)
    assert out is not None
    assert out.kind is Kind.EJECTED
