"""What the columns of results mean: each has a text, and the page in ``docs`` has them all."""

from __future__ import annotations

import re

import pytest

from dolfingrip import config
from dolfingrip.channels import CHANNELS, GRIPPER
from dolfingrip.cli.reference_commands import page
from dolfingrip.experiments import recorder
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.protocol import grasp_stops
from dolfingrip.sections.tables import assignments


def test_each_channel_says_what_it_is() -> None:
    assert [each.name for each in CHANNELS.values() if not each.about] == []


@pytest.mark.parametrize("experiment", EXPERIMENTS.values(), ids=lambda each: each.command)
def test_each_column_of_a_table_and_of_a_plot_is_described(experiment: Experiment) -> None:
    told = dict(recorder.described(experiment))
    assert all(told.values())
    assert {each.name for each in experiment.table} <= set(told)
    assert {each.column for each in experiment.plot.curves} <= set(told)


def test_a_grasps_columns_are_those_of_its_readings() -> None:
    names = [name for name, _ in recorder.described(EXPERIMENTS["grasp"])]
    assert set(names) >= {each.name for each in GRIPPER}
    assert "object_height_mm" in names


def test_the_page_has_each_column_once_with_its_meaning() -> None:
    """The documentation is built with this page."""
    rows = re.findall(r"^\| `(\w+)` \| (.+) \|$", page(list(EXPERIMENTS.values())), re.M)
    told = {
        name: about for each in EXPERIMENTS.values() for name, about in recorder.described(each)
    }
    assert len(rows) == len(told)
    assert dict(rows) == {name: about.replace("|", "∣") for name, about in told.items()}


def test_the_lift_of_a_grasp_is_called_so() -> None:
    grasp = EXPERIMENTS["grasp"]
    asked = config.load(
        None, assignments(["experiment.max_pressure_kPa=100", "experiment.step_kPa=25"])
    )
    found = [stop.branch for stop in grasp_stops(grasp.settings(asked))]
    assert found == [*5 * ["loading"], "hold", *6 * ["lift"], "hold"]


def test_zero_has_no_sign_in_a_file() -> None:
    assert recorder.digits(-0.0) == "0"
    assert recorder.digits(-0.125) == "-0.125"
