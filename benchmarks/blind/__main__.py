"""Command line of the blind benchmark; ``scripts/blind-benchmark`` calls it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from rich.console import Console

from benchmarks.blind import library
from benchmarks.blind.protocols import FINGERS, PROTOCOLS
from dolfingrip.cli import progress
from dolfingrip.cli.options import console
from dolfingrip.config import ConfigError
from dolfingrip.design.campaign.campaign import SchedulerGone
from dolfingrip.design.campaign.cluster import Where
from dolfingrip.diagnosis.simulation.runner import Workers

OUT: Final = Path("out/blind")
HALVES: Final = ("development", "final")


@dataclass(frozen=True, slots=True)
class Asked:
    """What was asked for.

    Attributes:
        out: folder of all that is kept.
        half: of the cases.
        only: names of protocols.
        workers: number of processes.
        retry_failed: simulate again what failed.
        screen: where progress is shown.
    """

    out: Path
    half: str
    only: tuple[str, ...]
    workers: int
    retry_failed: bool
    screen: Console

    @property
    def stores(self) -> Path:
        """Folder of the library's stores."""
        return self.out / "library"

    def at_work(self, show: Callable[..., None]) -> Workers:
        """Workers that show their progress."""
        return Workers(self.stores, Where(workers=self.workers), show, self.retry_failed)


def run_library(asked: Asked) -> None:
    """Simulate the generator's responses: curves first, then histories, the shortest first."""
    wanted = {PROTOCOLS[name].history for name in asked.only}
    if "P7+" in asked.only:
        wanted.add("pull")
    for history in library.HISTORIES:
        if history in wanted:
            asked.screen.print(f"library of {history}", soft_wrap=True)
            with progress.designs(asked.screen) as show:
                library.compute(history, asked.stores, asked.at_work(show))


STAGES: Final[Mapping[str, Callable[[Asked], None]]] = {
    "library": run_library,
}


def parsed(arguments: Sequence[str] | None) -> tuple[tuple[str, ...], Asked]:
    """Stages, and what was asked for."""
    told = "; ".join(
        f"{name}: {(stage.__doc__ or '').splitlines()[0]}" for name, stage in STAGES.items()
    )
    parser = argparse.ArgumentParser(
        prog="scripts/blind-benchmark",
        description=f"Hidden causes, their diagnosis, and what exact evidence allows. Stages: {told}",
    )
    parser.add_argument("stages", nargs="*", metavar="STAGE", help="default: all, in order")
    parser.add_argument("--half", choices=HALVES, default=HALVES[0], help="of the cases")
    parser.add_argument(
        "--only", default=",".join(FINGERS), metavar="PROTOCOL,…",
        help=f"of {', '.join(PROTOCOLS)}; default: all of the reference finger",
    )  # fmt: skip
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FOLDER", help=f"default: {OUT}")
    parser.add_argument("--retry-failed", action="store_true", help="simulate again what failed")
    asked = parser.parse_args(arguments)
    for stage in asked.stages:
        if stage not in STAGES:
            parser.error(f"{stage}: allowed: {', '.join(STAGES)}")
    only = tuple(asked.only.split(","))
    for name in only:
        if name not in PROTOCOLS:
            parser.error(f"--only {name}: allowed: {', '.join(PROTOCOLS)}")
    if asked.workers < 1:
        parser.error(f"--workers {asked.workers}: allowed: 1 or more")
    wanted = Asked(asked.out, asked.half, only, asked.workers, asked.retry_failed, console())
    return tuple(asked.stages) or tuple(STAGES), wanted


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the stages that were asked for."""
    stages, asked = parsed(arguments)
    try:
        for name in STAGES:
            if name in stages:
                STAGES[name](asked)
    except ConfigError as error:
        asked.screen.print(f"blind-benchmark: {error}", soft_wrap=True, markup=False)
        return 2
    except SchedulerGone as gone:
        asked.screen.print(f"blind-benchmark: {gone}", soft_wrap=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
