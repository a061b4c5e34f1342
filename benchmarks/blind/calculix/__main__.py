"""Simulate with CalculiX, diagnose, or score.

scripts/run python -m benchmarks.blind.calculix simulate [CASE...]
scripts/run python -m benchmarks.blind.calculix diagnose [CASE...] [--out FOLDER] [--whole]
scripts/run python -m benchmarks.blind.calculix score
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.blind.calculix import answers, truth

if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.blind.calculix", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("stage", choices=("simulate", "diagnose", "score"))
    parser.add_argument("cases", nargs="*", help=f"of {', '.join(truth.CASES)}; all where none")
    parser.add_argument("--out", type=Path, default=Path("out/calculix"))
    parser.add_argument("--whole", action="store_true", help="verify claims, not as --quick")
    asked = parser.parse_args()
    names = asked.cases or list(truth.CASES)
    if asked.stage == "simulate":
        truth.simulate(names, asked.out)
    elif asked.stage == "diagnose":
        answers.run(names, asked.out, quick=not asked.whole)
    else:
        print(answers.score(list(answers.answers())))
