"""The generator's simulations as small files in the repository, so that none is computed twice.

A file holds what one store of the library (:mod:`library`) had when it was written. The rules are
those of the simulations that come with the package
(:mod:`dolfingrip.diagnosis.simulation.shipped`): a result serves only the very configuration that
it was computed with, those of an effect only while that effect's code is unchanged, and where the
mechanics have changed one simulation has to agree first.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from benchmarks.blind import generator
from benchmarks.blind.alarms import measured_of
from benchmarks.blind.diagnoses import OF_ANALYSER, PACKED, How
from benchmarks.blind.library import Entry, known
from benchmarks.blind.response import Catalogue, Truth
from benchmarks.remembering import Remembering
from dolfingrip.diagnosis.finger.case import finger_case
from dolfingrip.diagnosis.simulation import shipped, sources
from dolfingrip.diagnosis.simulation.job import Job, JobResult
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.workers import NotAtHand, StayingWorkers
from dolfingrip.jobs.pool import Pool


def file_of(store: str, folder: Path = PACKED) -> Path:
    """Where the results of a store are, if they have been written."""
    return folder / f"{store}.npz"


def at_hand(workers: Workers, pool: Pool, store: str) -> StayingWorkers:
    """``workers`` that know a store's results in the repository, unless failures are retried."""
    return StayingWorkers(
        workers.store, workers.where, workers.progress, workers.retry_failed, pool,
        known=None if workers.retry_failed else shipped.read(file_of(store)),
    )  # fmt: skip


def write(entries: list[Entry], folder: Path, to: Path = PACKED) -> list[Path]:
    """Write what has been simulated, a file for each store.

    Args:
        entries: of the library, of all histories that are to be kept.
        folder: of the library's stores.
        to: folder of the files.

    Returns:
        Files that were written.
    """
    to.mkdir(parents=True, exist_ok=True)
    found = known(entries, folder)
    files = []
    for store in dict.fromkeys(entry.store for entry in entries):
        jobs = {
            entry.job.key: entry.job
            for entry in entries
            if entry.store == store and entry.job.key in found
        }
        if jobs:
            file = file_of(store, to)
            shipped.write(file, jobs.values(), [found[key] for key in jobs])
            files.append(file)
    return files


def write_analyser(
    catalogues: Sequence[Catalogue], folder: Path, how: How, to: Path = PACKED
) -> list[Path]:
    """Write the analyser's simulations of protocols, as far as they have been made.

    What comes with the package is left out.

    Args:
        catalogues: of the protocols.
        folder: for the measured files.
        how: cases are diagnosed; with workers that stay.
        to: folder of the files.

    Returns:
        Files that were written, one for each body.
    """
    files = []
    for body in dict.fromkeys(catalogue.protocol.body for catalogue in catalogues):
        own = [catalogue for catalogue in catalogues if catalogue.protocol.body == body]
        jobs, results = _made(own, folder, how)
        if jobs:
            to.mkdir(parents=True, exist_ok=True)
            files.append(file_of(OF_ANALYSER + body, to))
            shipped.write(files[-1], jobs, results)
    return files


def _made(
    catalogues: Sequence[Catalogue], folder: Path, how: How
) -> tuple[list[Job], list[JobResult]]:
    """The analyser's simulations at hand that do not come with the package."""
    assert how.crew is not None
    crew = how.crew
    workers = Remembering(crew.store, crew.where, crew.progress, known=crew.known, computes=False)
    for catalogue in catalogues:
        with suppress(NotAtHand):
            protocol = catalogue.protocol
            whole = measured_of(catalogue, folder / protocol.name, catalogue.vector(Truth()))
            finger_case(whole, generator.analysed(protocol), workers)
    jobs, results = workers.kept()
    own, come = shipped.read(), set[str]()
    if own is not None and own.core == sources.core_digest():
        come = {job.key for job, _ in own.answers(jobs, _never)}
    kept = [(job, result) for job, result in zip(jobs, results, strict=True) if job.key not in come]
    return [job for job, _ in kept], [result for _, result in kept]


def _never(job: Job) -> JobResult:
    raise AssertionError("the same code needs no check")
