"""Jobs that are still missing in a folder, computed and stored one by one.

Client or worker may be killed at any moment. The next call keeps what is stored, stores what is
spooled, and computes only what is neither.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from dolfingrip.jobs.job import Job, JobResult
from dolfingrip.jobs.pool import Pool, Unfinished
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import NAME, Shared, Store
from dolfingrip.sections.errors import ConfigError


@dataclass(slots=True)
class Standing:
    """How far the jobs of a call are.

    Attributes:
        total: their number.
        done, failed: of them, with those of earlier calls.
        computed: stored by this call.
        classes: number of failed jobs of this call by class.
        broken: jobs that the machine did not let come to an end; they stay pending.
        again: attempts of this call that the machine broke off and that were made again.
        latest: the answer that came last in this call; None before the first.
    """

    total: int
    done: int = 0
    failed: int = 0
    computed: int = 0
    classes: dict[str, int] = field(default_factory=dict)
    broken: int = 0
    again: int = 0
    latest: JobResult | None = None

    def count(self, answer: JobResult) -> None:
        """Take an answer into account."""
        self.latest = answer
        self.again += len(answer.broken)
        if answer.status == "broken":
            self.broken += 1
            return
        self.computed += 1
        if answer.status == "done":
            self.done += 1
            return
        self.failed += 1
        kind = answer.failure_class or ""
        self.classes[kind] = self.classes.get(kind, 0) + 1


Progress = Callable[[Standing], None]
Say = Callable[[str], None]


def silent(progress: object) -> None:
    """Show nothing.

    Args:
        progress: how far the jobs are, or what is done.
    """


def run(
    jobs: Sequence[Job],
    folder: Path,
    pool: Pool,
    shared: Shared,
    *,
    retry_failed: bool = False,
    spared: Collection[str] = (),
    progress: Progress = silent,
) -> Standing:
    """Compute what is missing.

    Args:
        jobs: to have; each key once. The folder keeps others, too.
        folder: of store and spool, made where there is none.
        pool: workers.
        shared: what all jobs of the folder share.
        retry_failed: compute failed jobs anew.
        spared: classes of failures that are not computed anew.
        progress: called at the start and with each answer stored.

    Returns:
        How far the jobs are.

    Raises:
        ConfigError: one line, where the folder holds other jobs or there are no workers.
        SchedulerGone: all workers are gone.
        Unfinished: the machine did not let some jobs come to an end, however often they were
            tried; all others are done, and the same call goes on with these.
        WriteError: one line about a file that could not be written; what was computed is kept.
        KeyboardInterrupt: Ctrl-C; what was computed is kept.
    """
    last: str | None = None
    with Store(folder, write=True) as store:
        store.add(jobs, shared)
        spool = Spool((folder / "spool").absolute())
        spool.folder.mkdir(exist_ok=True)
        for answer in spool.answers():
            store.record(answer)
        if retry_failed:
            for key in store.reopen([job.key for job in jobs], spared):
                spool.forget(key)
        statuses = [store.status(job.key) for job in jobs]
        standing = Standing(len(jobs), statuses.count("done"), statuses.count("failed"))
        progress(standing)
        missing = [job for job, status in zip(jobs, statuses, strict=True) if status == "pending"]
        with closing(pool.answers(missing, spool)) as answers:
            for answer in answers:
                if answer.status == "broken" or store.record(answer):
                    standing.count(answer)
                    progress(standing)
                if answer.status == "broken":
                    last = answer.failure
        if not store.counts()["pending"]:
            spool.clear()
    if standing.broken:
        raise Unfinished(
            f"{standing.broken} of {standing.total} could not be computed on this machine: {last}; "
            f"the others are kept in {folder}, the same call tries these again"
        )
    return standing


def check(folder: Path) -> tuple[int, list[str]]:
    """Look through store and spool, and set aside what is damaged.

    Args:
        folder: of the jobs.

    Returns:
        Number of rows and answers that are whole; and the names of those that are set aside, since
        the store was made.

    Raises:
        ConfigError: one line, where there is no store, or none of it can be read.
    """
    if not (folder / NAME).is_file():
        raise ConfigError(f"{folder / NAME}: no such campaign")
    with Store(folder, write=True) as store:
        store.facts()
        spool = Spool(folder / "spool")
        sound_count = sum(store.counts().values()) + len(list(spool.answers()))
        files = [*folder.glob(f"{NAME}.damaged-*"), *spool.folder.glob("*.damaged")]
        return sound_count, [*store.aside(), *(str(file.relative_to(folder)) for file in files)]
