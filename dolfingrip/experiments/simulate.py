"""Compute requests: one of them here or on MPI ranks, many of them on workers with a store.

As a program, ``python -m dolfingrip.experiments.simulate request.json answer.json`` computes a
request on all ranks of an mpirun.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from dolfingrip.config import ConfigError
from dolfingrip.experiments.finger_experiment import FingerExperiment
from dolfingrip.experiments.request import MESH, Answer, Request
from dolfingrip.files import whole
from dolfingrip.jobs import work
from dolfingrip.jobs.job import ERROR, MACHINE, REFUSED, Data, Job, JobFailure, JobResult
from dolfingrip.jobs.run import Progress, run, silent
from dolfingrip.jobs.single import tell
from dolfingrip.jobs.store import Shared, Store, same
from dolfingrip.sections.errors import MachineError

if TYPE_CHECKING:
    from mpi4py import MPI

    from dolfingrip.experiments.result import Result
    from dolfingrip.jobs.pool import Pool

MODULE: Final = "dolfingrip.experiments.simulate"
"""This file, as a program."""

FUNCTION: Final = f"{MODULE}:perform"
"""Import path of :func:`perform`."""

SHARED: Final[Shared] = same(function=FUNCTION)
"""What the requests of a store have in common."""

MORE_RANKS_THAN_CORES: Final = {
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_threads_pthreads_yield_strategy": "nanosleep",
}
"""Lets Open MPI 5 and 4 start more ranks than there are cores, as MPICH does anyway. Ranks that
wait for a message then sleep, as Linux makes processes that yield wait long for their turn."""

_HINTS: Final[dict[int, str]] = {
    signal.SIGKILL: "mostly for want of memory; allowed: fewer --workers, or a coarser mesh",
    signal.SIGXCPU: "the time that a process may take; allowed: a larger limit of the system",
}
"""What to do about a rank that a signal ended."""

Compute = Callable[[Sequence[Request]], list[Answer]]
"""From requests to their answers, in order: :func:`simulate` with a folder and workers."""

_OF_MPI: Final = ("OMPI_MCA_", "OMPI_COMM_", "PMIX_", "OPAL_", "PRTE_", "PMI_")


def simulate(
    requests: Sequence[Request], folder: Path, pool: Pool, progress: Progress = silent
) -> list[Answer]:
    """Compute requests on workers, unless their answers are in the folder's store.

    Args:
        requests: what is wanted; those of one key are computed once.
        folder: of the store, made where there is none.
        pool: workers.
        progress: called at the start and with each answer stored.

    Returns:
        Answers in the order of the requests. That of a simulation that failed has its class, a
        sentence, and what was read before.

    Raises:
        ConfigError: one line, where the folder holds something else or there are no workers.
        Unfinished: the workers are gone, or the machine did not let some requests come to an end;
            what was computed is kept.
    """
    if not requests:
        return []
    keys = [request.key for request in requests]
    jobs = {key: job(request, key) for key, request in zip(keys, requests, strict=True)}
    run(list(jobs.values()), folder, pool, SHARED, progress=progress)
    with Store(folder) as store:
        rows = {row["key"]: row for row in store.rows()}
    return [of_row(rows[key]) for key in keys]


def computed_in(folder: Path, pool: Pool, progress: Progress = silent) -> Compute:
    """Return what computes requests on workers and keeps their answers in a folder.

    Args:
        folder: of the store.
        pool: workers.
        progress: called at the start and with each answer stored.

    Returns:
        A function of requests.
    """
    return lambda requests: simulate(requests, folder, pool, progress)


def job(request: Request, key: str | None = None) -> Job:
    """Return the job that computes a request on a worker.

    Args:
        request: of an experiment of the index.
        key: that of the request, where it is known.

    Returns:
        A call of :func:`perform`.
    """
    named = {"experiment": request.experiment.name}
    return Job(key or request.key, FUNCTION, {"request": request.plain()}, named)


def of_row(row: Data) -> Answer:
    """Return the answer in a row of a store.

    Args:
        row: of a request that has ended.

    Returns:
        The answer.
    """
    stored = row["result"] or row["partial"]
    answer = Answer.from_plain(stored) if stored else Answer()
    return replace(
        answer,
        failure_class=row["failure_class"],
        failure=row["failure"],
        wall_s=row["wall_s"],
    )


def perform(request: Data, *, on_all_ranks: bool = False) -> Data:
    """Compute a request on a worker.

    Args:
        request: plain data of a :class:`Request`.
        on_all_ranks: this process is one of those that ``mpirun`` started for it.

    Returns:
        Plain data of its :class:`Answer`.

    Raises:
        JobFailure: where the model did not come to the end; with what was read before.
        ConfigError: where there is no such specimen or parameter.
        MachineError: where a rank died.
    """
    comm = None
    if on_all_ranks:
        from mpi4py import MPI

        comm = MPI.COMM_WORLD
    answer = compute(Request.from_plain(request), comm)
    if answer.failure_class is not None:
        raise JobFailure(answer.failure_class, answer.failure or "", answer.plain())
    return answer.plain()


def compute(request: Request, comm: MPI.Comm | None = None) -> Answer:
    """Compute a request.

    Args:
        request: what is wanted.
        comm: ranks to run on; None: this process, or under ``mpirun`` the ranks of the request.

    Returns:
        Readings, derivatives, and the model's failure if there was one.

    Raises:
        ConfigError: where there is no such specimen or parameter.
        MachineError: where a rank died.
    """
    if comm is None:
        if request.ranks > 1:
            return _on_ranks(request)
        from mpi4py import MPI

        comm = MPI.COMM_SELF
    if request.places:
        return _at_places(request, comm)
    from dolfingrip.experiments.loop import follow

    runs, over = 1 + request.mesh_check, request.experiment.plot.over
    total = runs * len(request.experiment.schedule(request.config))
    done, reached = 0, "mesh and forms"
    tell(done, total, reached)

    def advance(row: dict[str, Any]) -> None:
        nonlocal done, reached
        done += 1
        reached = f"{row[over.name]:zg} {over.symbol}"
        tell(done, total, reached)

    result = follow(request, comm, advance, lambda line: tell(done, total, line or reached))
    return answer_of(request, result)


def load() -> None:
    """Import what simulations need, which takes a second or two."""
    import dolfingrip.experiments.loop  # noqa: F401


def answer_of(request: Request, result: Result) -> Answer:
    """Return what a request wants of a result.

    Args:
        request: what is wanted.
        result: of its experiment.

    Returns:
        The answer; a failure of a second run is not one of it.
    """
    from dolfingrip.experiments.results import record

    wanted, rows = set(request.columns), result.rows
    columns: dict[str, np.ndarray] = {}
    for name in dict.fromkeys(name for row in rows for name in row):
        if (not wanted or name in wanted) and (values := result[name]).dtype.kind != "U":
            columns[name] = values
    slopes: dict[tuple[str, str], np.ndarray] = {}
    for entry in result.sensitivities:
        if not wanted or entry["column"] in wanted:
            names = entry["column"], entry["parameter"]
            slopes.setdefault(names, np.full(len(rows), np.nan))[entry["row"]] = entry["derivative"]
    if (checked := result.facts.mesh_check) is not None:
        mesh_errors = {(name, MESH): np.array(errors) for name, errors in checked.errors.items()}
        slopes |= {names: errors for names, errors in mesh_errors.items() if names[0] in columns}
    failure = result.failure
    return Answer(
        columns,
        slopes,
        None if failure is None else str(failure.kind),
        None if failure is None else failure.sentence(),
        None if result.outcome is None else asdict(result.outcome),
        result.facts.newton.iterations,
        record.versions(),
    )


def _at_places(request: Request, comm: MPI.Comm) -> Answer:
    from dolfingrip.experiments.derivatives.answers import answers

    if not isinstance(request.experiment, FingerExperiment):
        raise ConfigError(f"{request.experiment.name}: has no places; allowed: one of a finger")
    try:
        columns, slopes = answers(
            request.experiment, request.config, request.places, request.columns,
            request.gradients or (), comm,
            None if request.made_for is None else request.made_for.adapted().geometry,
        )  # fmt: skip
    except JobFailure as ending:
        return Answer(failure_class=ending.kind, failure=ending.sentence)
    return Answer(columns, slopes)


# -- on ranks ------------------------------------------------------------------------------------


def _on_ranks(request: Request) -> Answer:
    # the kernel ends mpirun with the worker, however that ends
    guard = ["setpriv", "--pdeathsig", "TERM"] if shutil.which("setpriv") else []
    environment = {k: v for k, v in os.environ.items() if not k.startswith(_OF_MPI)}
    kept = {k: v for k, v in os.environ.items() if "_MCA_" in k}
    with tempfile.TemporaryDirectory(prefix="dolfingrip-") as folder:
        question, answer = Path(folder) / "request.json", Path(folder) / "answer.json"
        whole.write(question, json.dumps(request.plain()))
        program = [sys.executable, "-P", "-m", MODULE, question, answer]
        ended = subprocess.run(
            [*guard, "mpirun", "-n", str(request.ranks), *map(str, program)],
            env={**environment, **MORE_RANKS_THAN_CORES, **kept, "OMP_NUM_THREADS": "1"},
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            check=False,
        )  # fmt: skip
        if not answer.exists():
            raise MachineError(_of_mpirun(ended.returncode, ended.stdout))
        finished = JobResult.loads(answer.read_text(encoding="utf-8"))
    if finished.status == "broken":
        raise MachineError(finished.failure)
    if finished.failure_class == REFUSED:
        raise ConfigError(finished.failure or REFUSED)
    return of_row(asdict(finished))


def _of_mpirun(code: int, said: str) -> str:
    """Why mpirun has no answer, in one line: a signal that ended a rank, or what it said last."""
    # a code above 128 is that of a signal, as the shell has it
    match = re.search(r"rank (?P<rank>\d+).{0,200}? on\s+signal (?P<signal>\d+)", said, re.DOTALL)
    # MPICH tells no rank
    match = match or re.search(r"EXIT STRING: (?P<rank>)[^()]*\(signal (?P<signal>\d+)\)", said)
    number = int(match["signal"]) if match else -code if code < 0 else code - 128
    try:
        name = signal.Signals(number).name
    except ValueError:
        lines = [line for line in said.splitlines() if line.strip(" -*=")]
        return f"mpirun ended with {code}: {lines[-1] if lines else 'nothing said'}"
    who = (f"rank {match['rank']}" if match["rank"] else "a rank") if match else "mpirun"
    hint = _HINTS.get(number, "allowed: the same command, which tries it again")
    return f"{who} was ended by signal {number} ({name}); {hint}"


def main(request: Path, answer: Path) -> None:
    """Compute a request on all ranks; rank 0 writes the answer.

    Args:
        request: JSON file of the request.
        answer: file that is written.
    """
    _end_with_parent()
    from mpi4py import MPI

    plain = json.loads(request.read_text(encoding="utf-8"))
    try:
        ended = work.compute(Job("", FUNCTION, {"request": plain, "on_all_ranks": True}))
    except whole.WriteError as error:  # on all ranks
        ended = JobResult("", "broken", failure_class=MACHINE, failure=str(error))
    else:
        if ended.status == "broken" or ended.failure_class == ERROR:  # perhaps on this rank alone
            sys.stderr.write(f"{ended.failure}\n")
            MPI.COMM_WORLD.Abort(70)  # the other ranks would wait for this one for ever
    if MPI.COMM_WORLD.rank == 0:
        whole.write(answer, ended.dumps())


def _end_with_parent() -> None:
    """Have Linux kill this rank once mpirun is gone, which a killed mpirun itself cannot."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(1, int(signal.SIGKILL), 0, 0, 0)  # PR_SET_PDEATHSIG


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
