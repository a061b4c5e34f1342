"""Hidden cases are kept as files, run, or their answers scored.

    scripts/run python -m benchmarks.blind.time freeze|run|score [PROTOCOL …] [--kind one|two]
        [--only N] [--out FOLDER]

``freeze`` and ``run`` go on where a call before was stopped.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.blind import said, score
from benchmarks.blind.time.cases import HIDDEN, PROTOCOLS, bench

SET = "time"


def main() -> None:
    """Draw, run or score."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.blind.time", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("stage", choices=("freeze", "run", "score"))
    parser.add_argument("protocols", nargs="*", help=f"of {', '.join(PROTOCOLS)}")
    parser.add_argument("--kind", choices=("one", "two"), action="append")
    parser.add_argument("--only", type=int, help="the first so many of each kind")
    scored = Path(__file__).with_name("scored")
    parser.add_argument("--table", type=Path, default=scored, help="folder of the answers")
    parser.add_argument("--out", type=Path, default=Path("out/time"), help="of simulations")
    given = parser.parse_args()
    if given.stage == "score":
        print(score.table(list(said.every(given.table, SET))))
        return
    for name in given.protocols or list(PROTOCOLS):
        cases = bench(PROTOCOLS[name], given.out / name)
        counts = {
            kind: len(hidden) if given.only is None else min(given.only, len(hidden))
            for kind, hidden in HIDDEN[name].items()
            if not given.kind or kind in given.kind
        }
        if given.stage == "freeze":
            said.freeze(cases, SET, counts, Path(__file__).with_name("frozen"))
        else:
            said.grow(given.table / f"{SET}-{name}.csv", cases, SET, counts)


if __name__ == "__main__":
    main()
