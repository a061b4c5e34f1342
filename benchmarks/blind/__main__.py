"""Cases that are kept as files are diagnosed, and their answers are scored.

    scripts/run python -m benchmarks.blind diagnose [PROTOCOL…] [--only N] [--table FOLDER]
    scripts/run python -m benchmarks.blind score [--table FOLDER]

``diagnose`` goes on where a call before was stopped. The measurements, and what was hidden, lie in
``benchmarks/blind/frozen``; ``python -m benchmarks.blind.coupons freeze`` and ``…fingers freeze``
have drawn them.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.blind import answers, frozen, score


def main() -> None:
    """Diagnose or score."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.blind", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("stage", choices=("diagnose", "score"))
    parser.add_argument("protocols", nargs="*", help=f"of {', '.join(frozen.protocols())}")
    parser.add_argument("--table", type=Path, default=answers.FOLDER, help="folder of the answers")
    parser.add_argument("--out", type=Path, default=Path("out/blind"), help="of simulations")
    parser.add_argument("--only", type=int, help="the first so many of each kind")
    asked = parser.parse_args()
    if asked.stage == "score":
        print(score.table(list(answers.scored(asked.table))))
        return
    for name in asked.protocols or list(frozen.protocols()):
        answers.grow(name, asked.out, asked.only, asked.table)


if __name__ == "__main__":
    main()
