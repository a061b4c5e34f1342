"""The command line of one half of the benchmark: run cases of a set, score them, draw ranks."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.blind import ranks, said, score


def main(
    package: str,
    told: str,
    counts: Mapping[str, Mapping[str, int]],
    protocols: Sequence[str],
    bench: Callable[[str, Path], said.Bench[Any]],
) -> None:
    """Run, score or draw.

    Args:
        package: name of the half.
        told: what it is.
        counts: cases by set and kind.
        protocols: their names.
        bench: of a protocol, with a folder for measurements.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks.blind.{package}", description=told,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("stage", choices=("run", "freeze", "score", "ranks"))
    parser.add_argument("--set", choices=tuple(counts), default="confirmation")
    parser.add_argument("--protocol", choices=tuple(protocols), action="append")
    scored = Path(__file__).parent / package / "scored"
    parser.add_argument("--out", type=Path, default=scored, help="folder of the tables")
    parser.add_argument("--only", type=int, help="the first so many of each kind")
    parser.add_argument("--kind", action="append", help="these kinds alone")
    asked = parser.parse_args()
    if asked.stage == "score":
        print(score.table(list(said.every(asked.out, asked.set))))
    elif asked.stage == "ranks":
        ranks.draw(list(said.every(asked.out, "prior")), asked.out / "ranks.png")
    else:
        few = {
            kind: count if asked.only is None else min(count, asked.only)
            for kind, count in counts[asked.set].items()
            if not asked.kind or kind in asked.kind
        }
        for name in asked.protocol or protocols:
            place = f"{asked.set}-{name}"
            own = bench(name, asked.out / "scratch" / place)
            if asked.stage == "freeze":
                said.freeze(own, asked.set, few)
                continue
            said.grow(asked.out / f"{place}.csv", own, asked.set, few)
