"""Compute the simulations that are shipped, and write ``reference.json.gz`` of the diagnosis.

    scripts/run python -m benchmarks.reference_simulations [--workers 2] [--store FOLDER]
    scripts/run python -m benchmarks.reference_simulations --only causes,coupon

The reference finger, bending and blocked force, three cycles at the ordinary settings, with
derivatives by the nuisances, and with each cause of the catalogue at the places that emulators are
made from; and the additions that
``dolfingrip plan-experiment`` judges for the paper's protocol, but for the tip up and down. About
half an hour of processor. Can be stopped and started: a call goes on where the one before it was,
as long as the code is the same. With ``--only`` it computes these parts, and writes no file but
with ``--keep``.

To be run again where the code of an effect changes (that one is computed alone then), or where the
mechanics change; until then a diagnosis checks the file by one simulation
(:mod:`dolfingrip.diagnosis.simulation.runner`). Where the change is known not to touch fingers, as
one of coupons alone, ``--keep`` takes over what the file has after that check, computes what it
lacks, and adds that to the file; so does a call that is stopped by Ctrl-C.
"""

from __future__ import annotations

import argparse
import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from benchmarks import shipped_file
from benchmarks.reference_measurement import reference_measurement
from benchmarks.remembering import Remembering
from dolfingrip.cli import progress
from dolfingrip.cli.console import console
from dolfingrip.config import Config
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.core.unknown import causes
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.plan import analyse_plan, joined, read_alike
from dolfingrip.diagnosis.simulation import runner
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool, Unfinished

APART: Final = ("orientation",)
"""Additions that are left out: the tip up and down is another 80 simulations."""

CAUSES: Final = "causes"
"""The part that every diagnosis of the reference finger is made from; the others are additions."""

PARTS: Final = (CAUSES, *(kind for kind in rig.KINDS if kind not in APART))


def measurements() -> Iterator[tuple[str, Measurement]]:
    """Yield each measurement that is simulated, with the part that it belongs to."""
    paper, _ = rig.read(None, Config())
    # its protocol is the beginning of the three cycles, whose simulations serve it
    yield CAUSES, reference_measurement()
    yield CAUSES, paper
    for proposal in proposals(paper, Config()):
        yield proposal.kind, joined(paper, read_alike(proposal, paper))


def code() -> str:
    """Short digest of all code that results depend on: what other code computed is left alone."""
    every = [
        runner.core_digest(),
        *(runner.effect_digest(each.name) for each in causes(Config())),
    ]
    return hashlib.sha256("".join(every).encode()).hexdigest()[:12]


def main() -> None:
    """Compute what is missing, and write the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--store", type=Path, default=Path("out/reference_simulations"))
    parser.add_argument("--only", default=",".join(PARTS), help=f"of {', '.join(PARTS)}")
    parser.add_argument("--keep", action="store_true", help="what one simulation agrees with")
    options = parser.parse_args()
    parts = options.only.split(",")
    for part in parts:
        if part not in PARTS:
            parser.error(f"--only {part}: allowed: {', '.join(PARTS)}")

    known = runner.shipped()
    if known is not None and known.core != runner.core_digest() and not options.keep:
        known = None
    where = Where(workers=options.workers)
    with progress.jobs(console(), "simulations") as show, Pool(where) as pool:
        workers = Remembering(options.store / code(), where, show, kept=pool, known=known)
        try:
            for part, measurement in measurements():
                if part in parts:
                    print(part, flush=True)
                    analyse_plan(measurement, Config(), workers, None)
        except (KeyboardInterrupt, Unfinished):
            if not options.keep:
                raise
            print("stopped; what has ended is added")
    requests, results = workers.remembered()
    seconds = sum(result.wall_s or 0.0 for result in results)
    print(f"{len(requests)} simulations of {seconds:.0f} s")
    if options.keep or set(parts) == set(PARTS):
        shipped_file.write(runner.FILE, requests, results, keep=options.keep)
        print(f"{runner.FILE}: {runner.FILE.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
