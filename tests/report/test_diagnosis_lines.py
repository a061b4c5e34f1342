"""Lines of a diagnosis' pictures: one for an elastic way, bands along each way alone."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dolfingrip.report.diagnosis import first_way, lines, ways

LOAD = [0.0, 50.0, 100.0, 100.0, 50.0, 0.0, 50.0]


def test_an_elastic_way_is_drawn_once() -> None:
    load = np.array(LOAD) + 0.3 * np.array([0, 1, 0, -1, -1, 1, 0])  # as regulators scatter
    run = pd.DataFrame({"load": load, "elastic": 0.1 * load})
    run["viscous"] = run["elastic"] + np.linspace(0, 0.5, len(run))
    assert first_way(run, "load", "elastic")["load"].tolist() == load[:3].tolist()
    assert first_way(run, "load", "viscous") is run


def test_specimens_that_are_simulated_alike_have_one_line() -> None:
    """Coupons begin and end at other travels; one that is stiffer has a line of its own."""
    load = np.linspace(0, 10, 11)
    runs = [
        pd.DataFrame({"run": number, "load": load + 0.02 * number, "noise": 0.1})
        for number in range(3)
    ]
    for number, run in enumerate(runs):
        run["force"] = (1.0 + 0.1 * (number == 2)) * run["load"]
    drawn = lines(pd.concat(runs), "load", "force", "fitted", "blue", "dash")
    assert [(each.name, len(each.x)) for each in drawn] == [("fitted", 11), ("", 11)]


def test_ways_end_where_the_load_turns() -> None:
    """A wait belongs to the way before it; a turn to both ways."""
    assert ways(np.array(LOAD)) == [slice(0, 4), slice(3, 6), slice(5, 7)]
    assert ways(np.array([0.0, 10.0])) == [slice(0, 2)]
    assert ways(np.array([7.0])) == [slice(0, 1)]
    assert ways(np.array([5.0, 5.0, 0.0])) == [slice(0, 3)]
