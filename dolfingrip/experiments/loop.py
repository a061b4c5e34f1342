"""Run an experiment from stop to stop, and record the readings at each."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Final

from mpi4py import MPI

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import mesh_error, protocol
from dolfingrip.experiments.derivatives.bands import Bands
from dolfingrip.experiments.derivatives.gradients import AtHighest, collectors
from dolfingrip.experiments.derivatives.sensitivities import Sensitivities, choices
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.finger_experiment import FingerExperiment
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.recorder import Recorder, columns, write_outcome
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results import record
from dolfingrip.experiments.results.readings import Row
from dolfingrip.experiments.results.sensitivity_table import COLUMNS, SensitivityTable
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.files.run import MeshCheck, RunFailure
from dolfingrip.mechanics.model.compilation import Tell, told_to
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.path.failure import Failure, FailureKind
from dolfingrip.mechanics.path.path import LoadPath, Observer

WORDS: Final = {
    FailureKind.INVERTED_ELEMENT: (
        "an element turned inside out; refine the mesh or lower the {quantity}"
    ),
    FailureKind.CONTACT: (
        "contact kept Newton's steps short; widen contact.barrier_mm or lower its stiffness"
    ),
    FailureKind.LIMIT_POINT: (
        "{soft} (its stiffness vanishes): {quantity} control cannot follow it"
    ),
    FailureKind.ITERATION_LIMIT: "Newton's method did not converge within solver.max_iterations",
    FailureKind.TIME_LIMIT: "solver.time_limit_s is over",
}
"""The meaning of a failure, in words of the configuration."""


def run(
    experiment: Experiment | str,
    config: Config | None = None,
    *,
    out: Path | str | None = None,
    comm: MPI.Comm = MPI.COMM_WORLD,
    progress: Callable[[Row], None] = lambda row: None,
    gradients: Sequence[str] | None = None,
    mesh_check: bool = False,
    bands: Mapping[str, float] | None = None,
    tell: Tell | None = None,
) -> Result:
    """Run an experiment.

    Args:
        experiment: an experiment, or its name in :mod:`dolfingrip.experiments.index`.
        config: everything that the simulation depends on; default: the reference finger.
        out: folder for ``result.csv``, ``run.json`` and ``fields.pvd``; None: nothing is written.
        comm: ranks to run on.
        progress: called on every rank with each new row, also with the rows of second runs.
        gradients: keys of parameters that all readings are derived by; (): all parameters; None:
            no derivatives. The key of a choice of the model (``extensions.coarse_mesh``) asks
            for a second run with the other choice, and for the difference of both runs.
        mesh_check: whether the error of the readings that is due to the mesh is estimated.
        bands: standard deviations by which bands of the readings are computed, beside the usual
            ones; None: no bands.
        tell: called on every rank at each iteration of a load step, with a line where that takes
            longer than two seconds, else an empty one; each second, from another thread of the
            rank that compiles a form, with a line about that, and with an empty one once it is
            compiled.

    Returns:
        The result; its ``failure`` says why a load path ended early.

    Raises:
        ConfigError: one line about bad input.
        WriteError: on every rank, one line about a file that could not be written.
    """
    request = Request.of(
        experiment,
        config or Config(),
        gradients,
        fields=None if out is None else Path(out),
        mesh_check=mesh_check,
        bands=bands,
    )
    return follow(request, comm, progress, tell)


def follow(
    request: Request,
    comm: MPI.Comm,
    progress: Callable[[Row], None] = lambda row: None,
    tell: Tell | None = None,
) -> Result:
    """Follow a request's load path from stop to stop.

    It is followed once more for each choice of the model, and on the bisected mesh where the error
    of the mesh is asked for.

    Args:
        request: what is wanted, without places.
        comm: ranks to run on.
        progress: called on every rank with each new row, also with the rows of second runs.
        tell: as that of :func:`run`.

    Returns:
        The result, with derivatives as rows of ``sensitivity.csv``.

    Raises:
        ConfigError: one line about bad input.
    """
    model_choices = choices(request.config, request.gradients)
    with told_to(tell):
        result = _once(request, comm, progress, tell)
        plain = replace(request, gradients=None, fields=None, mesh_check=False, bands=None)
        if request.mesh_check:
            check = _mesh_check(result, plain, comm, progress, tell)
            result.facts = result.facts.model_copy(update={"mesh_check": check})
        for choice in model_choices:
            other = _once(replace(plain, config=choice.other), comm, progress, tell)
            assert not isinstance(other.failure, RunFailure)
            result.second_runs[choice.key] = other.failure
            result.sensitivities += choice.differences(result.rows, other.rows, COLUMNS)
    if model_choices:
        ended = {
            key: "complete" if failure is None else failure.sentence()
            for key, failure in result.second_runs.items()
        }
        result.facts = result.facts.model_copy(update={"second_runs": ended})
    out, facts, slopes = request.fields, result.facts, result.sensitivities
    if out is not None and (model_choices or request.mesh_check):
        on_root(comm, lambda: write_outcome(out, facts, slopes))
    comm.Barrier()
    return result


def _mesh_check(
    result: Result, request: Request, comm: MPI.Comm, progress: Callable[[Row], None],
    tell: Tell | None,
) -> MeshCheck:  # fmt: skip
    """Follow the load path on the bisected mesh, and tell the error of the readings."""
    start = time.perf_counter()
    try:
        finer = replace(request, config=mesh_error.bisected(request.config))
        check = mesh_error.estimate(result, _once(finer, comm, progress, tell))
    except ConfigError as reason:  # cells that cannot be bisected, or too many for the memory
        check = MeshCheck(why=f"the run on the bisected mesh is refused: {reason}")
    return check.model_copy(update={"wall_s": round(time.perf_counter() - start, 3)})


def _once(
    request: Request, comm: MPI.Comm, progress: Callable[[Row], None], tell: Tell | None
) -> Result:
    """Follow the load path once, without second runs."""
    start = time.perf_counter()
    profile = Profile()
    experiment, config = request.experiment, request.config
    if request.made_for is not None and isinstance(experiment, FingerExperiment):
        experiment = type(experiment)(request.made_for.adapted().geometry)
    stops = experiment.schedule(config)
    bands = None if request.bands is None else Bands.of(experiment, config, request.bands)
    built = config if bands is None else bands.config
    keys = request.gradients if bands is None else bands.keys(request.gradients)
    rig = experiment.prepare(built, comm, profile)
    banded = [] if bands is None else [n for n, reading in rig.readings.items() if reading.derived]
    names = columns(experiment, rig.newton.model.domain.cavities, config, banded)
    rig.newton.watch.tell = tell
    rig.newton.model.cycle_at = protocol.cycle_at(stops)
    result = Result(experiment.name, config, order=names, folder=request.fields)
    derived: list[Sensitivities | AtHighest] = []
    if keys is not None:
        at = stops if request.at_highest else None
        with profile.phase("sensitivities"):
            derived = collectors(rig, built, keys, at, request.columns)
    with ExitStack() as stack:
        recorder = None
        if request.fields is not None:
            files = Recorder(request.fields, experiment, config, rig, profile, names)
            recorder = stack.enter_context(files)

        def reached(row: Row) -> None:
            place = len(result.rows)
            result.rows.append(row)
            for source in derived:
                source.record(place)
            if bands is not None:
                slopes = (one for source in derived for one in source.rows)
                row |= bands.ends(result.rows, slopes, banded)
            if recorder is not None:
                recorder.append(row)
            progress(row)

        observers = [source.forward for source in derived if isinstance(source, Sensitivities)]
        failure = _lead(experiment, rig, stops, reached, observers)
        if failure is not None:
            failure = explained(failure, rig)
        result.failure = failure
        result.sensitivities = SensitivityTable(row for source in derived for row in source.rows)
        experiment.conclude(result, rig)
        wall_s = time.perf_counter() - start
        notes = experiment.notes(config)
        result.facts = record.of_run(result, rig.newton, profile, wall_s, notes).model_copy(
            update={
                "bands": {} if bands is None else dict(bands.spreads),
                "sag_mm": rig.sag_mm,
            }
        )
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
    if failure is not None and (further := rig.continuation(failure)):
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


def explained(failure: Failure, rig: Rig) -> Failure:
    """The failure with its meaning for the rig's specimen and with the rig's advice."""
    words = WORDS[failure.kind].format(soft=rig.softening, quantity=rig.quantity)
    return replace(failure, words=words, advice=rig.advice(failure))
