"""What a long solve tells, by a clock of the test's own."""

from __future__ import annotations

from dolfingrip.mechanics.newton.ending import Watch


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
        "iteration 1: residual 5.0e-01 N (to 1.0e-06 N), step 0.25 of Newton's, bounded by: "
        "bellows",
        "iteration 1: residual 1.0e-03 N (to 1.0e-06 N), step 1 of Newton's",
    ]
