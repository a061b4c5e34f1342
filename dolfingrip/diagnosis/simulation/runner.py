"""Requests of a diagnosis on workers, each answer kept in a store by its content.

What is in the store is not computed again, whichever data asked for it; a diagnosis that is killed
goes on where it was.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from dolfingrip.channels import TIME
from dolfingrip.config import Config
from dolfingrip.diagnosis.data.clock import moves
from dolfingrip.diagnosis.data.table import CONTROL, READINGS
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import simulate
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, silent


def request(
    experiment: str,
    config: Config,
    gradients: Sequence[str] = (),
    *,
    mesh_check: bool = False,
    read: Sequence[str] = (),
) -> Request:
    """Ask for an experiment as a diagnosis simulates it.

    States beyond a snap are not what was measured up to there, and cost most of the time. How far a
    path goes beyond its last stop is never read. The shortest step is a part of the largest
    pressure: a soft finger balloons within what is a short step of a stiff one. That of a body that
    moves while its pressure rests is as configured, as its error in time asks for short steps.

    Args:
        experiment: its name.
        config: with the protocol of the measurement.
        gradients: keys of parameters that all readings are derived by.
        mesh_check: whether the error of the mesh is estimated, too.
        read: columns that are read; the experiment's own where empty, without markers.

    Returns:
        The request.

    Raises:
        ConfigError: one line, where the configuration cannot have the experiment's settings.
    """
    shortest = config.solver.min_step_kPa
    if not moves(config):
        largest = max(map(abs, config.protocol.pressure_kPa), default=float("inf"))
        shortest = max(shortest, 0.125 * min(config.solver.max_step_kPa, 0.125 * largest))
    plain = config.changed(experiment={"snaps": False}, solver={"min_step_kPa": shortest})
    columns = (TIME.name, CONTROL[experiment], *(read or READINGS[experiment]))
    return Request.of(experiment, plain, gradients or None, columns=columns, mesh_check=mesh_check)


@dataclass(frozen=True, slots=True)
class Workers:
    """Where simulations are computed and kept.

    Attributes:
        store: folder of the results, made where there is none.
        where: which workers; one MPI process each.
        progress: called with each simulation that is done.
        kept: processes that are started when something is to be computed, and kept; started for
            each call where None.
        spent_s: time that each simulation took, by its key.
    """

    store: Path
    where: Where = field(default_factory=Where)
    progress: Progress = silent
    kept: Pool | None = None
    spent_s: dict[str, float] = field(default_factory=dict)

    def results(self, requests: Sequence[Request]) -> list[Answer]:
        """Compute each request where it is not in the store.

        Args:
            requests: what is wanted.

        Returns:
            Their answers, in order. That of a simulation that failed has its class, a sentence and
            what was read before.

        Raises:
            ConfigError: one line: no workers, or the store is in use or another's.
            Unfinished: the workers are gone, or the machine did not let some simulations come to
                an end; what was computed is kept.
        """
        with self.pool() as pool:
            answers = simulate(requests, self.store, pool, self.progress)
        for request, answer in zip(requests, answers, strict=True):
            self.spent_s[request.key] = answer.wall_s or 0.0
        return answers

    def pool(self) -> AbstractContextManager[Pool]:
        """The workers that compute what is missing; those not kept end with the ``with`` block."""
        return Pool(self.where) if self.kept is None else nullcontext(self.kept)


@contextmanager
def staying(store: Path, workers: int, progress: Progress) -> Iterator[Workers]:
    """Workers that a diagnosis starts once, and that end with the ``with`` block."""
    where = Where(workers=workers)
    with Pool(where) as pool:
        yield Workers(store, where, progress, pool)
