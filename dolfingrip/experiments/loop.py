"""Run an experiment from stop to stop, and record the readings at each."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from mpi4py import MPI

from dolfingrip.config import Config
from dolfingrip.experiments.derivatives.choices import choices
from dolfingrip.experiments.derivatives.sensitivities import Sensitivities, chosen
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.failures import explained
from dolfingrip.experiments.index import find
from dolfingrip.experiments.protocol.schedule import Stop
from dolfingrip.experiments.recorder import Recorder, write_outcome
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results import record
from dolfingrip.experiments.results.readings import Row
from dolfingrip.experiments.results.sensitivity_table import COLUMNS, SensitivityTable
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.files.run import RunFailure
from dolfingrip.mechanics.model.compilation import Tell, told_to
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.path.failure import Failure
from dolfingrip.mechanics.path.path import LoadPath, Observer


def run(
    experiment: Experiment | str,
    config: Config | None = None,
    *,
    out: Path | str | None = None,
    comm: MPI.Comm = MPI.COMM_WORLD,
    progress: Callable[[Row], None] = lambda row: None,
    visit: Callable[[Any, Row], None] = lambda specimen, row: None,
    gradients: Sequence[str] | None = None,
    tell: Tell | None = None,
) -> Result:
    """Run an experiment.

    Args:
        experiment: an experiment, or its name in :mod:`dolfingrip.experiments.index`.
        config: everything that the simulation depends on; default: the reference finger.
        out: folder for ``result.csv``, ``run.json`` and ``fields.pvd``; None: nothing is written.
        comm: ranks to run on.
        progress: called on every rank with each new row, also with the rows of second runs.
        visit: called on every rank with the specimen (for instance a finger's model) in its
            present state and with each new row. It must not change the specimen. It is not
            called in second runs.
        gradients: keys of parameters that all readings are derived by; (): all parameters; None:
            no derivatives. The key of a choice of the model (``extensions.coarse_mesh``) asks
            for a second run with the other choice, and for the difference of both runs.
        tell: called with a line about what takes longer than two seconds: on every rank about each
            iteration of a load step; each second, from another thread of the rank that compiles a
            form, about that, and with an empty line once it is compiled.

    Raises:
        ConfigError: one line about bad input.
        WriteError: on every rank, one line about a file that could not be written.
    """
    if isinstance(experiment, str):
        experiment = find(experiment)
    config = experiment.settings(config or Config())
    out = None if out is None else Path(out)
    asked = choices(config, gradients)
    with told_to(tell):
        result = _run(experiment, config, out, comm, progress, visit, gradients, tell)
        for choice in asked:
            other = _run(experiment, choice.other, None, comm, progress, tell=tell)
            assert not isinstance(other.failure, RunFailure)
            result.second_runs[choice.key] = other.failure
            result.sensitivities += choice.differences(result.rows, other.rows, COLUMNS)
    if asked:
        ended = {
            key: "complete" if failure is None else failure.sentence()
            for key, failure in result.second_runs.items()
        }
        result.facts = result.facts.model_copy(update={"second_runs": ended})
        if out is not None:
            on_root(comm, lambda: write_outcome(out, result.facts, result.sensitivities))
    comm.Barrier()
    return result


def _run(
    experiment: Experiment,
    config: Config,
    out: Path | None,
    comm: MPI.Comm,
    progress: Callable[[Row], None],
    visit: Callable[[Any, Row], None] = lambda specimen, row: None,
    gradients: Sequence[str] | None = None,
    tell: Tell | None = None,
) -> Result:
    """Run an experiment once, without second runs; the arguments are those of :func:`run`."""
    start = time.perf_counter()
    profile = Profile()
    stops = experiment.schedule(config)
    rig = experiment.prepare(config, comm, profile)
    rig.newton.watch.tell = tell
    result = Result(experiment.name, config, folder=out)
    sensitivities = None
    parameters = [] if gradients is None else chosen(config, gradients)
    if parameters:
        with profile.phase("sensitivities"):
            sensitivities = Sensitivities(rig, config, parameters)
    with ExitStack() as stack:
        recorder = None
        if out is not None:
            files = Recorder(out, experiment, config, rig.newton.model, profile)
            recorder = stack.enter_context(files)

        def reached(row: Row) -> None:
            result.rows.append(row)
            if recorder is not None:
                recorder.append(row)
            if sensitivities is not None:
                sensitivities.record(len(result.rows) - 1)
            progress(row)
            visit(rig.specimen, row)

        observers = [] if sensitivities is None else [sensitivities.forward]
        failure = _lead(experiment, rig, stops, reached, observers)
        if failure is not None:
            failure = explained(failure, rig)
        result.failure = failure
        if sensitivities is not None:
            result.sensitivities = SensitivityTable(sensitivities.rows)
        experiment.conclude(result, rig)
        wall_s = time.perf_counter() - start
        notes = experiment.notes(config)
        result.facts = record.of_run(result, rig.newton, profile, wall_s, notes)
        if recorder is not None:
            recorder.finish(result.facts, result.sensitivities)
    return result


def _lead(
    experiment: Experiment,
    rig: Rig,
    stops: Sequence[Stop],
    reached: Callable[[Row], None],
    observers: Sequence[Observer] = (),
) -> Failure | None:
    """Go through all stops and call ``reached`` with each row; return why the path ended early."""
    path = rig.path(observers)
    failure = rig.start(path, stops[0])
    if failure is not None:
        return failure
    failure = _through(experiment, rig, path, stops, reached)
    if failure is not None and (further := rig.beyond(failure)):
        failure = _through(experiment, rig, rig.path(observers), further, reached)
    return failure


def _through(
    experiment: Experiment,
    rig: Rig,
    path: LoadPath,
    stops: Sequence[Stop],
    reached: Callable[[Row], None],
) -> Failure | None:
    """Go from stop to stop under one control; return why the path ended early, None if not."""
    for stop in stops:
        arrival = path.advance(rig.controls(stop))
        if arrival.failure is not None:
            return arrival.failure
        with rig.newton.profile.phase("observation"):
            readings = rig.read()
        row: Row = {
            "experiment": experiment.name,
            "specimen": "simulated",
            "cycle": stop.cycle,
            "branch": stop.branch,
            **readings,
            "iterations": arrival.iterations,
            "load_steps": arrival.steps,
        }
        reached(row)
        if rig.over():
            break
    return None
