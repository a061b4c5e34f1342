"""A campaign: the designs of a plan that are still missing, computed and stored one by one.

Client or worker may be killed at any moment. The next call keeps what is stored, stores what is
spooled, and computes only what is neither.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from dolfingrip.design.campaign.answer import WORKER_LOST, Answer
from dolfingrip.design.campaign.cluster import Where, connected
from dolfingrip.design.campaign.evaluate import Task, work
from dolfingrip.design.campaign.interrupts import interrupts_answered_by
from dolfingrip.design.campaign.plan import Design, Work
from dolfingrip.design.campaign.spool import Spool
from dolfingrip.design.campaign.store import Store

_INTERRUPT = object()  # what Ctrl-C puts among the answers


class SchedulerGone(Exception):
    """The scheduler ended before the campaign; what was computed is kept."""


@dataclass(slots=True)
class Standing:
    """How far a campaign is, of the designs that its plan asks for.

    Attributes:
        total: designs of the plan.
        done, failed: of them, with those of earlier calls.
        computed: stored by this call.
        classes: number of failed designs of this call by class.
    """

    total: int
    done: int = 0
    failed: int = 0
    computed: int = 0
    classes: dict[str, int] = field(default_factory=dict)

    def count(self, answer: Answer) -> None:
        """Take an answer into account."""
        self.computed += 1
        if answer.status == "done":
            self.done += 1
            return
        self.failed += 1
        kind = answer.failure_class or ""
        self.classes[kind] = self.classes.get(kind, 0) + 1


def run(
    plan: Work,
    out: Path,
    where: Where,
    *,
    retry_failed: bool = False,
    spared: Collection[str] = (),
    progress: Callable[[Standing], None] = lambda standing: None,
) -> Standing:
    """Compute what is missing.

    Args:
        plan: designs to have; the store keeps others of the same settings too.
        out: folder of the campaign.
        where: workers.
        retry_failed: compute failed designs anew.
        spared: classes of failures that are not computed anew.
        progress: called at the start and with each answer stored.

    Raises:
        ConfigError: one line, where the folder is another campaign's or there are no workers.
        SchedulerGone: all workers are gone.
    """
    designs = plan.designs()
    keys = [design.key for design in designs]
    with Store(out, write=True) as store:
        store.add(plan.facts(), designs)
        spool = Spool((out / "spool").absolute())
        spool.folder.mkdir(exist_ok=True)
        for answer in spool.answers():
            store.record(answer)
        if retry_failed:
            for key in store.reopen(keys, spared):
                spool.forget(key)
        statuses = [store.status(key) for key in keys]
        standing = Standing(len(keys), statuses.count("done"), statuses.count("failed"))
        progress(standing)
        missing = [d for d, status in zip(designs, statuses, strict=True) if status == "pending"]
        if missing:
            _compute(missing, plan, where, store, spool, standing, progress)
        if not store.counts()["pending"]:
            spool.clear()
    return standing


def _compute(
    designs: Sequence[Design],
    plan: Work,
    where: Where,
    store: Store,
    spool: Spool,
    standing: Standing,
    progress: Callable[[Standing], None],
) -> None:
    # An interrupt is one more item of the queue: raised wherever the signal comes, it can end up in
    # a destructor, which swallows it, and the campaign would go on.
    arrived: SimpleQueue[Any] = SimpleQueue()
    with (
        connected(where) as client,
        interrupts_answered_by(lambda number, frame: arrived.put(_INTERRUPT)),
    ):
        keys = {}
        for design in designs:
            task = Task(
                design.key, design.config, plan.quantities, plan.objective, where.ranks,
                str(spool.folder), plan.gradients,
            )  # fmt: skip
            # Dask's key is the design's: a scheduler that still computes it takes up that
            future = client.submit(work, task, key=f"design-{design.key}")
            keys[future] = design.key
            future.add_done_callback(arrived.put)
        # in the order of completion, each dropped as it is stored
        while keys:
            future = arrived.get()
            if future is _INTERRUPT:
                raise KeyboardInterrupt
            answer = _answer(future, keys[future], spool)
            if answer is None:
                future.add_done_callback(arrived.put)
                continue
            del keys[future]
            if store.record(answer):
                standing.count(answer)
                progress(standing)


def _answer(future: Any, key: str, spool: Spool) -> Answer | None:
    """The answer behind a future that has ended; None where it is computed again.

    Raises:
        SchedulerGone: which says nothing about the design.
    """
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    # What is on the disk outlives the worker that computed it and Dask's copy with it.
    spooled = spool.read(key)
    if spooled is not None:
        return spooled
    if future.status in ("lost", "pending"):  # its worker died since, and another takes it up
        return None
    try:
        error = future.exception() if future.status == "error" else None
        if error is None:
            answer: Answer = future.result()
            return answer
    except FutureCancelledError:
        raise SchedulerGone(
            "the scheduler is gone; what was computed is kept, the same call goes on from there"
        ) from None
    if isinstance(error, KilledWorker):
        return Answer(
            key, "failed", failure_class=WORKER_LOST,
            failure="every worker that computed it died, for want of memory or by a crash",
        )  # fmt: skip
    return Answer(key, "failed", failure_class="error", failure=f"{type(error).__name__}: {error}")
