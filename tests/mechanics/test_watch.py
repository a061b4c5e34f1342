"""What a long solve tells, by a clock of the test's own."""

from __future__ import annotations

import pytest
from support.small import SELF, short

from dolfingrip.experiments.loop import run
from dolfingrip.mechanics.newton.ending import Watch


class GivenUp(BaseException):
    """Somebody wants another simulation."""


def test_a_run_is_left_at_an_iteration() -> None:
    """The exception passes through PETSc, and the next run of the process is as ever."""
    told: list[str] = []

    def tell(line: str) -> None:
        told.append(line)
        if len(told) == 2:
            raise GivenUp

    config = short("experiment.max_pressure_kPa=20", "experiment.step_kPa=20")
    with pytest.raises(GivenUp) as caught:
        run("bending", config, comm=SELF, tell=tell)
    assert len(told) == 2
    assert caught.value.__context__ is None  # those who look for reasons behind it come to an end
    result = run("bending", config, comm=SELF)
    assert result.failure is None
    assert result.column("angle_deg")[-1] > 0.5


def test_only_what_takes_long_is_told() -> None:
    now = [0.0]
    told: list[str] = []
    watch = Watch(lambda: now[0])
    watch.tell = told.append
    watch.start()
    watch.judged(0, 2.0, 1e-6)
    now[0] = 2.5
    watch.stepped(0.25, "bellows")
    watch.judged(1, 0.5, 1e-6)
    watch.start()  # the next solve
    watch.judged(0, 2.0, 1e-6)
    now[0] = 5.0
    watch.stepped(1.0, "")
    watch.judged(1, 1e-3, 1e-6)
    assert told == [
        "",
        "iteration 1: residual 5.0e-01 N (to 1.0e-06 N), step 0.25 of Newton's, bounded by: "
        "bellows",
        "",
        "iteration 1: residual 1.0e-03 N (to 1.0e-06 N), step 1 of Newton's",
    ]
