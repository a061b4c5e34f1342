"""What every experiment in the index must have; a new one is tested here by being there."""

from __future__ import annotations

from pathlib import Path

import pytest
import typer.main

from dolfingrip.cli.commands import app
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import index, run
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.recorder import columns

every = pytest.mark.parametrize(
    "experiment", index.EXPERIMENTS.values(), ids=list(index.EXPERIMENTS)
)


@every
def test_says_what_it_is(experiment: Experiment) -> None:
    for said in (experiment.name, experiment.command, experiment.title, experiment.summary()):
        assert said
    known = columns(experiment)
    assert len(set(known)) == len(known)
    shown = {column.name for column in experiment.table}
    drawn = {curve.column for curve in experiment.plot.curves} | {experiment.plot.over.name}
    assert {experiment.control.name, *shown, *drawn} <= set(known)
    assert experiment.table[0] is experiment.control


@every
def test_has_a_command_with_its_options(experiment: Experiment) -> None:
    group = typer.main.get_command(app)
    command = group.commands[experiment.command].entry.built()  # type: ignore[attr-defined]
    flags = {flag for parameter in command.params for flag in parameter.opts}
    assert {"--out", "-o", "--config", "--set"} <= flags
    assert {option.flag for option in experiment.options} <= flags
    assert ("--protocol" in flags) == ("--specimen" in flags) == experiment.protocol
    assert ("--render" in flags) == experiment.drawable
    assert {"--video", "--video-length", "--video-turn", "--colour-by"} <= flags
    assert ("--cut" in flags) == (experiment.drawable or experiment.command == "grasp")


@every
def test_starts_at_rest_and_describes_itself(experiment: Experiment) -> None:
    settings = experiment.settings(Config())
    first, *others = experiment.schedule(settings)
    assert (first.value, first.time_s, first.branch) == (0.0, 0.0, "loading")
    assert others
    assert experiment.described(settings)["experiment"] == experiment.name


def test_an_experiment_is_a_file_and_a_line() -> None:
    """No other file of the package knows any of them by its class."""
    package = Path(index.__file__).parents[1]
    modules = {f"dolfingrip.experiments.{name} import" for name in index.NAMES}
    for file in package.rglob("*.py"):
        if file.stem not in index.NAMES:
            text = file.read_text(encoding="utf-8")
            assert not any(module in text for module in modules), file


def test_an_unknown_name_is_said_with_those_there_are() -> None:
    with pytest.raises(ConfigError, match=r"^experiment bent: allowed: bending \(or bend\), "):
        run("bent")
