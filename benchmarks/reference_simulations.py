"""Compute the simulations that are shipped, and write ``reference.npz`` of the diagnosis.

    scripts/run python -m benchmarks.reference_simulations [--workers 2] [--store FOLDER]

The reference finger, bending and blocked force, three cycles at the ordinary settings: with
derivatives by the nuisances, and with each effect of the catalogue; and those additions that are
cheap: a slow cycle, a hold, coupons. About half an hour of processor.
Can be stopped and started. To be run again where the mechanics change; until then a diagnosis
checks the file by one simulation (:mod:`dolfingrip.diagnosis.simulation.shipped`).
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from dolfingrip.config import Config
from dolfingrip.design.campaign.campaign import Standing
from dolfingrip.design.campaign.cluster import Where
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.plan.plan import read_alike
from dolfingrip.diagnosis.simulation import shipped
from dolfingrip.diagnosis.simulation.base import simulate_base
from dolfingrip.diagnosis.simulation.job import Job, JobResult
from dolfingrip.diagnosis.simulation.reference import reference_measurement
from dolfingrip.diagnosis.tried import tried
from dolfingrip.diagnosis.workers import StayingWorkers

ADDED = ("slow_cycle", "hold", "coupon")
"""Kinds of additions to the paper's protocol whose simulations are shipped, too."""


@dataclass(frozen=True, slots=True)
class Remembering(StayingWorkers):
    """Workers that keep what they were asked for.

    Attributes:
        asked: jobs and their results, by key.
    """

    asked: dict[str, tuple[Job, JobResult]] = field(default_factory=dict)

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        """As :meth:`StayingWorkers.results`."""
        found = StayingWorkers.results(self, jobs)
        for job, result in zip(jobs, found, strict=True):
            self.asked[job.key] = (job, result)
        return found


def main() -> None:
    """Compute what is missing, and write the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--store", type=Path, default=Path("out/reference_simulations"))
    options = parser.parse_args()

    def say(standing: Standing) -> None:
        print(f"{standing.done} of {standing.total}, {standing.failed} failed", flush=True)

    with ExitStack() as stack:
        where = Where(workers=options.workers)
        workers = Remembering(options.store, where, say, stack=stack)
        simulate_base(reference_measurement(), Config(), workers, effects=tried(None))
        paper, _ = rig.read(None, Config())
        for proposal in proposals(paper, Config()):
            if proposal.kind in ADDED:
                own = read_alike(proposal, paper)
                simulate_base(own, Config(), workers, effects=tried(None))
    jobs, results = zip(*workers.asked.values(), strict=True)
    shipped.write(shipped.FILE, jobs, results)
    seconds = sum(result.wall_s or 0.0 for result in results)
    size_kB = shipped.FILE.stat().st_size / 1000
    print(f"{shipped.FILE}: {len(jobs)} simulations of {seconds:.0f} s, {size_kB:.0f} kB")


if __name__ == "__main__":
    main()
