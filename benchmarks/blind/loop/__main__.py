"""Hidden fingers are drawn, the loop is run on them, or its answers are scored.

    scripts/run python -m benchmarks.blind.loop freeze [small] [reference] [--only N]
    scripts/run python -m benchmarks.blind.loop run [small] [reference] [--only N] [--rounds 2]
    scripts/run python -m benchmarks.blind.loop score [--table FOLDER]

``freeze`` and ``run`` go on where a call before was stopped.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.blind.loop import cases, rounds, scores


def main() -> None:
    """Draw, run or score."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.blind.loop", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("stage", choices=("freeze", "run", "score"))
    parser.add_argument("protocols", nargs="*", help=f"of {', '.join(cases.PROTOCOLS)}")
    parser.add_argument("--only", type=int, help="the first so many of each protocol")
    parser.add_argument("--rounds", type=int, default=2, help="of advice, at most")
    parser.add_argument("--workers", type=int, default=1)
    answers = Path(__file__).with_name("answers")
    parser.add_argument("--table", type=Path, default=answers, help="folder of the answers")
    parser.add_argument("--out", type=Path, default=Path("out/loop"), help="of simulations")
    given = parser.parse_args()
    if given.stage == "score":
        rows = list(scores.answers(given.table))
        for protocols in (cases.FINGERS, cases.COUPONS):
            print(scores.table(rows, protocols, given.rounds), end="\n\n")
        return
    for protocol in given.protocols or list(cases.PROTOCOLS):
        if given.stage == "freeze":
            hidden = given.out / "hidden" / protocol
            cases.freeze(protocol, hidden, given.only, given.workers, cases.FOLDER)
        else:
            rounds.grow(protocol, given.out, given.only, given.rounds, given.workers, given.table)


if __name__ == "__main__":
    main()
