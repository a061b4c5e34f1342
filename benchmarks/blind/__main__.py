"""Command line of the blind benchmark; ``scripts/blind-benchmark`` calls it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.blind import alarms, cases
from benchmarks.blind.protocols import FINGERS, PROTOCOLS
from benchmarks.blind.stages import EXTRA, ORDINARY, STAGES, Asked
from dolfingrip.cli.options import console
from dolfingrip.config import ConfigError
from dolfingrip.jobs.pool import SchedulerGone

OUT: Final = Path("out/blind")
DRAWS: Final = 400


def parsed(arguments: Sequence[str] | None) -> tuple[tuple[str, ...], Asked]:
    """Stages, and what was asked for."""
    told = "; ".join(
        f"{name}: {(stage.__doc__ or '').splitlines()[0]}" for name, stage in STAGES.items()
    )
    parser = argparse.ArgumentParser(
        prog="scripts/blind-benchmark",
        description="Hidden causes, their diagnosis, and what exact evidence allows. A call goes "
        f"on where the one before it was stopped. Stages: {told}",
    )
    parser.add_argument(
        "stages",
        nargs="*",
        metavar="STAGE",
        help=f"default: all but {', '.join(EXTRA)}, in order",
    )
    parser.add_argument(
        "--cases", dest="set_name", choices=cases.SETS, default=cases.SETS[0],
        help=f"which set of them; default: {cases.SETS[0]}",
    )  # fmt: skip
    parser.add_argument(
        "--only", default=",".join(FINGERS), metavar="PROTOCOL,…",
        help=f"of {', '.join(PROTOCOLS)}; default: all of the reference finger",
    )  # fmt: skip
    parser.add_argument(
        "--number", type=int, default=cases.NUMBER, metavar="N",
        help=f"of cases of a set; default: {cases.NUMBER}",
    )  # fmt: skip
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FOLDER", help=f"default: {OUT}")
    parser.add_argument("--quick", action="store_true", help="diagnose by closed forms alone")
    parser.add_argument(
        "--draws", type=int, default=DRAWS, metavar="N",
        help=f"of measurements without a cause, by protocol; default: {DRAWS}",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=int, default=alarms.SEED, metavar="N",
        help=f"of these measurements; default, for figures: {alarms.SEED}; tune on another one",
    )  # fmt: skip
    parser.add_argument("--retry-failed", action="store_true", help="simulate again what failed")
    asked = parser.parse_args(arguments)
    for stage in asked.stages:
        if stage not in STAGES:
            parser.error(f"{stage}: allowed: {', '.join(STAGES)}")
    only = tuple(asked.only.split(","))
    for name in only:
        if name not in PROTOCOLS:
            parser.error(f"--only {name}: allowed: {', '.join(PROTOCOLS)}")
    for name in ("workers", "number", "draws"):
        if getattr(asked, name) < 1:
            parser.error(f"--{name} {getattr(asked, name)}: allowed: 1 or more")
    wanted = Asked(
        asked.out, asked.set_name, only, asked.number, asked.workers, asked.quick,
        asked.retry_failed,
        alarms.Draws(asked.out / "alarms", asked.draws, asked.seed), console(),
    )  # fmt: skip
    return tuple(asked.stages) or ORDINARY, wanted


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
