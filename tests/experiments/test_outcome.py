"""What became of a grasp, by made-up moments."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.experiments.results.outcome import Moment, Ring, decided, judge
from dolfingrip.files.run import GraspKind as Kind

LIFT_S = 1.0


def moment(
    time_s: float, z: float, fingers: float, table: float, rise: float = 0.0, x: float = 0.0
) -> Moment:
    return Moment(time_s, time_s > LIFT_S, np.array([x, 0.0, z]), rise, np.full(3, fingers), table)


START = [moment(0.0, 20.0, 0.0, 1.0), moment(0.5, 20.0, 1.0, 0.6), moment(1.0, 20.0, 2.0, 0.1)]


@pytest.mark.parametrize(
    ("then", "kind", "at", "said"),
    [
        (
            [moment(1.5, 19.8, 2, 0, 9), moment(2, 19.8, 2, 0, 20)],
            Kind.PICKED_UP,
            1.5,
            "by 20 mm",
        ),
        (
            [moment(1.5, 19, 2, 0, 9), moment(2, 12, 2, 0, 12)],
            Kind.SLIPPED,
            2.0,
            "sank by 8.0 mm",
        ),
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


@pytest.mark.parametrize(("part", "kind"), [(0.008, Kind.PICKED_UP), (0.03, Kind.NOT_LIFTED)])
def test_fingers_bear_an_object_of_which_the_table_bears_a_hundredth(
    part: float, kind: Kind
) -> None:
    """A thirtieth of its weight on the table is too much, in all and in any moment."""
    found = judge([*START, moment(1.5, 19.8, 2, part, 9), moment(2, 19.8, 2, part, 20)],
                  complete=True)  # fmt: skip
    assert found is not None
    assert found.kind is kind
    lost = [*START, moment(1.5, 19, 2, part, 9), moment(1.6, 0, 0, 1.0)]
    assert decided(lost) is (kind is Kind.PICKED_UP)
    set_down = judge([*START, moment(1.5, 19, 2, 0, 9), moment(2, 12, 2, part, 0)], complete=True)
    assert set_down is not None
    assert (set_down.kind is Kind.DROPPED) is (kind is Kind.NOT_LIFTED)


def test_a_run_that_ended_early_has_no_class_unless_it_is_clear() -> None:
    assert judge(START, complete=False) is None
    assert judge([], complete=False) is None
    out = judge([*START, moment(1.2, 20, 0, 1, 0, x=30)], complete=False)
    assert out is not None
    assert out.kind is Kind.EJECTED


RING = Ring(40.0, np.array([[-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]))
"""A claw: nothing stands at x > 0."""


def rolling(sign: float) -> list[Moment]:
    """A thumb pushes it ever faster along x."""
    return [
        moment(0.5 + 0.1 * i, 20, 1, 1.0, x=sign * x) for i, x in enumerate([1, 4, 8, 13, 19, 26])
    ]


def test_what_rolls_out_between_fingers_is_ejected_though_one_pushes_it() -> None:
    out = judge([*START[:1], *rolling(1.0)], complete=False, ring=RING)
    assert out is not None
    assert out.kind is Kind.EJECTED
    assert decided([*START[:1], *rolling(1.0)], RING)
    # towards a finger it may yet be held
    assert not decided([*START[:1], *rolling(-1.0)], RING)
    beyond = [*START[:1], *rolling(-1.0), moment(1.5, 20, 1, 1.0, x=-45)]
    assert decided(beyond, RING)


def test_a_run_that_ends_while_it_is_squeezed_out() -> None:
    out = judge([*START[:1], *rolling(1.0)[:4]], complete=False, ring=RING)
    assert out is not None
    assert out.kind is Kind.EJECTED
    assert "50 mm/s, 13 mm away (the computation ended there)" in out.sentence


def test_a_run_that_ends_in_the_lift_has_the_class_of_its_last_step() -> None:
    up = judge([*START, moment(1.5, 19.8, 2, 0, 9)], complete=False)
    down = judge([*START, moment(1.5, 18, 1, 0.9, 0)], complete=False)
    undecided = judge([*START, moment(1.1, 19.8, 1, 0.5, 0)], complete=False)
    assert up is not None
    assert up.kind is Kind.PICKED_UP
    assert up.sentence.endswith("(the computation ended there)")
    assert down is not None
    assert down.kind is Kind.NOT_LIFTED
    assert undecided is None


def test_what_is_lost_in_the_lift_is_decided() -> None:
    held = [*START, moment(1.5, 19, 2, 0, 9)]
    assert decided([*held, moment(1.6, 13, 0, 0, 8)])
    assert decided([*held, moment(1.55, 17, 0, 0, 8), moment(1.6, 13, 0, 0, 8)])
    assert decided([*held, moment(1.6, 18, 0, 0, 8, x=-6)])
    assert not decided([*held, moment(1.6, 13, 1, 0, 8)])


def test_what_bounces_between_fingers_in_the_lift_is_not_lost() -> None:
    bounced = [*START, moment(1.5, 19, 2, 0, 9), moment(1.52, 17, 0, 0, 8)]
    assert not decided(bounced)
    caught = judge([*bounced, moment(1.53, 16, 1, 0, 8), moment(2, 16, 2, 0, 20)], complete=True)
    assert caught is not None
    assert caught.kind is Kind.SLIPPED
