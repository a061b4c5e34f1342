"""``python -m benchmarks.blind.coupons``."""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.blind.coupons import __doc__ as told
from benchmarks.blind.coupons import ranks, run, score
from benchmarks.blind.coupons.cases import COUNTS
from benchmarks.blind.coupons.coupon import PROTOCOLS

SCORED = Path(__file__).with_name("scored")


def main() -> None:
    """Run, score or draw."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.blind.coupons", description=told,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("stage", choices=("run", "score", "ranks"))
    parser.add_argument("--set", choices=tuple(COUNTS), default="confirmation")
    parser.add_argument("--protocol", choices=tuple(PROTOCOLS), action="append")
    parser.add_argument("--out", type=Path, default=SCORED, help="folder of the tables")
    parser.add_argument("--only", type=int, help="the first so many of each kind")
    parser.add_argument("--kind", action="append", help="these kinds alone")
    asked = parser.parse_args()
    if asked.stage == "run":
        for protocol in asked.protocol or PROTOCOLS:
            run.run(asked.set, protocol, asked.out, asked.only, asked.kind)
    elif asked.stage == "score":
        print(score.table(list(run.every(asked.out, asked.set))))
    else:
        ranks.draw(list(run.every(asked.out, "prior")), asked.out / "ranks.png")


if __name__ == "__main__":
    main()
