"""Requests of a diagnosis on workers, each answer kept in a store by its content.

What is in the store is not computed again, whichever data asked for it; a diagnosis that is killed
goes on where it was. What comes with the package (:mod:`dolfingrip.diagnosis.simulation.shipped`)
is entered instead of being computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

from dolfingrip.channels import TIME
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.columns import CONTROL, read_by
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation import shipped
from dolfingrip.diagnosis.simulation.shipped import Shipped
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import enter, simulate
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, silent
from dolfingrip.jobs.store import Store


def request(
    experiment: str,
    config: Config,
    gradients: Sequence[str] = (),
    *,
    mesh_check: bool = False,
    seen: Sequence[str] = (),
) -> Request:
    """Ask for an experiment as a diagnosis simulates it.

    States beyond a snap are not what was measured up to there, and cost most of the time. How far a
    path goes beyond its last stop is never read.

    Args:
        experiment: its name.
        config: with the protocol of the measurement.
        gradients: keys of parameters that all readings are derived by.
        mesh_check: whether the error of the mesh is estimated, too.
        seen: columns of the measurement, whose markers are read, too.

    Returns:
        The request.

    Raises:
        ConfigError: one line, where the configuration cannot have the experiment's settings.
    """
    shortest = max(config.solver.min_step_kPa, POLICY.shortest_step * config.solver.max_step_kPa)
    plain = config.changed(experiment={"snaps": False}, solver={"min_step_kPa": shortest})
    columns = (TIME.name, CONTROL[experiment], *read_by(experiment, seen))
    return Request.of(experiment, plain, gradients or None, columns=columns, mesh_check=mesh_check)


class NotAtHand(Exception):
    """Simulations would have to be computed; the text says how many."""


@dataclass(frozen=True, slots=True)
class Workers:
    """Where simulations are computed and kept.

    Attributes:
        store: folder of the results, made where there is none.
        where: which workers; one MPI process each.
        progress: called with each simulation that is done.
        kept: processes that are started when something is to be computed, and kept; started for
            each call where None.
        known: results that come with the package.
        computes: whether what is not there is computed.
        spent_s: time that each simulation took, by its key.
    """

    store: Path
    where: Where = field(default_factory=Where)
    progress: Progress = silent
    kept: Pool | None = None
    known: Shipped | None = None
    computes: bool = True
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
            NotAtHand: simulations are missing, and nothing is computed.
            Unfinished: the workers are gone, or the machine did not let some simulations come to
                an end; what was computed is kept.
        """
        if self.known is not None:
            self._enter(self.known, self._missing(requests))
        if not self.computes and (missing := self._missing(requests)):
            raise NotAtHand(f"{len(missing)} simulations are not at hand")
        return self._computed(requests)

    def at_hand(self) -> Workers:
        """Return workers that raise :class:`NotAtHand` where a simulation is missing."""
        return replace(self, computes=False)

    def pool(self) -> AbstractContextManager[Pool]:
        """The workers that compute what is missing; those not kept end with the ``with`` block."""
        return Pool(self.where) if self.kept is None else nullcontext(self.kept)

    def _computed(self, requests: Sequence[Request]) -> list[Answer]:
        with self.pool() as pool:
            found = simulate(requests, self.store, pool, self.progress)
        for asked, answer in zip(requests, found, strict=True):
            self.spent_s[asked.key] = answer.wall_s or 0.0
        return found

    def _enter(self, known: Shipped, missing: Sequence[Request]) -> None:
        """Enter what comes with the package."""
        found = known.answers(missing, lambda asked: self._computed([asked])[0])
        if found:
            enter(found, self.store, "shipped")

    def _missing(self, requests: Sequence[Request]) -> list[Request]:
        try:
            with Store(self.store) as store:
                return [one for one in requests if store.status(one.key) in (None, "pending")]
        except ConfigError:
            return list(requests)


@contextmanager
def staying(
    store: Path, workers: int, progress: Progress, *, anew: bool = False
) -> Iterator[Workers]:
    """Workers that end with the ``with`` block: a diagnosis asks many times, and starts them once.

    With ``anew`` they compute what comes with the package, too.
    """
    where = Where(workers=workers)
    with Pool(where) as pool:
        yield Workers(store, where, progress, pool, None if anew else shipped.read())
