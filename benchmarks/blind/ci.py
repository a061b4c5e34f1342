"""Whole cases on coupons and a short finger, from their own simulations to a verdict.

    scripts/run python -m benchmarks.blind.ci [--out FOLDER] [--workers N] [--publish]

Continuous integration compares the verdicts with those of ``ci.csv`` and fails where one is worse:
another answer, a class without the hidden cause that had it, a wider class, or one member of a tie.
``--publish`` writes that file anew, for when they are better.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Final

from benchmarks.blind.case import ARTEFACTS, Case
from benchmarks.blind.coupons import run as coupons
from benchmarks.blind.fingers import cases as fingers
from benchmarks.blind.said import Bench
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis

EXPECTED: Final = Path(__file__).with_name("ci.csv")
EFFECTS: Final = (
    "print_anisotropy", "plate_compliance", "plate_friction", "angle_offset", "force_offset",
)  # fmt: skip
"""That are hidden and tried in fingers: fewer than the catalogue, as each is compiled."""

CASES: Final[Sequence[tuple[str, str, int]]] = (
    ("pull", "none", 0),
    ("pull", "one", 0),
    ("pull", "two", 2),
    ("pull", "with_outsider", 1),
    ("pull", "outsider", 2),
    ("pull", "nuisance", 2),
    ("loops", "one", 0),
    ("loops", "with_outsider", 0),
    ("loops", "none", 0),
    ("few", "none", 0),
    ("few", "one", 0),
    ("loops", "outsider", 0),
    ("loops", "outsider", 5),
    ("loops", "two", 2),
    ("pull", "outsider", 13),
    ("loops", "outsider", 3),
)
"""Protocol, kind and number of cases of the development set."""


def names() -> list[str]:
    """Return the names of all cases."""
    return [f"ci-{place:03d}-{protocol}" for place, (protocol, _, _) in enumerate(CASES)]


@dataclass(frozen=True, slots=True)
class Answered:
    """An answer to a case.

    Attributes:
        case: name.
        hidden: causes.
        answer: ``cause``, ``none`` or ``unknown``.
        named: effects of the classes that are named, and kinds of artefacts that are told.
        right: whether the answer is, and each class holds a hidden cause.
    """

    case: str
    hidden: str
    answer: str
    named: str
    right: bool

    def worse_than(self, other: Answered) -> str:
        """In what it is worse; nothing where it is not."""
        if other.right and not self.right:
            return (
                f"{self.case}: {self.answer} {self.named}, where {self.hidden or 'none'} is right"
            )
        mine, before = (len(each.named.split(" or ")) for each in (self, other))
        if other.right and mine > before:
            return f"{self.case}: {self.named}, where {other.named} was told apart"
        if other.right and mine < before:
            return f"{self.case}: {self.named}, where the readings allow {other.named}"
        return ""


def answered(name: str, case: Case[Any], found: Diagnosis) -> Answered:
    """The answer as a row."""
    decision, outsider = found.decision, case.truth.outsider[0]
    sets = [each for each in (decision.first, decision.second) if each]
    artefacts = dict.fromkeys(each.nuisance.name.split()[0] for each in found.artefacts)
    # one that is told and taken out leaves nothing else
    outside = decision.answer == ("none" if ARTEFACTS.get(outsider) in artefacts else "unknown")
    right = {"none": decision.answer == "none", "outsider": outside}.get(
        case.kind, decision.answer == "cause"
    )
    right &= len(sets) == 2 if case.kind == "two" else True
    told = [*case.names, *filter(None, [outsider])]
    return Answered(
        name, " + ".join(told), decision.answer,
        " + ".join([*(" or ".join(sorted(each)) for each in sets), *artefacts]),
        right and all(set(each) & {*case.names} for each in sets),
    )  # fmt: skip


def run(out: Path, workers: int, cases: Sequence[tuple[str, str, int]] = CASES) -> list[Answered]:
    """Simulate, write, diagnose: cases of one protocol after the other in one process.

    Args:
        out: folder of measurements and simulations.
        workers: processes at once, each of which takes a protocol.
        cases: protocol, kind and number of each.

    Returns:
        Answers in the order of the cases.
    """
    parts: dict[str, dict[str, tuple[str, int]]] = {}
    for name, (protocol, kind, number) in zip(names(), cases, strict=False):
        parts.setdefault(protocol, {})[name] = kind, number
    # fingers first, as they take longest
    order = sorted(parts, key=lambda protocol: protocol not in fingers.PROTOCOLS)
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        jobs = [pool.submit(_of, protocol, parts[protocol], out, workers) for protocol in order]
        answers = {answer.case: answer for job in jobs for answer in job.result()}
    return [answers[name] for name in sorted(answers)]


def _of(
    protocol: str, cases: Mapping[str, tuple[str, int]], out: Path, workers: int
) -> list[Answered]:
    """Answer the cases of one protocol, by their names."""
    folder = out / protocol
    if protocol in fingers.PROTOCOLS:
        bench: Bench[Any] = fingers.bench(protocol, folder, workers, EFFECTS)
    else:
        bench = coupons.bench(protocol, folder)
    answers = []
    for name, (kind, number) in cases.items():
        case = bench.drawn("development", kind, number)
        answers.append(answered(name, case, bench.diagnosed(case)))
        print(f"{answers[-1]}", flush=True)
    return answers


def expected() -> list[Answered]:
    """Read the answers that are committed."""
    with EXPECTED.open(encoding="utf-8", newline="") as file:
        return [
            Answered(**{**row, "right": row["right"] == "True"}) for row in csv.DictReader(file)
        ]


def publish(found: Sequence[Answered]) -> None:
    """Write ``ci.csv``."""
    with EXPECTED.open("w", encoding="utf-8", newline="") as file:
        names = [each.name for each in fields(Answered)]
        table = csv.DictWriter(file, names, lineterminator="\n")
        table.writeheader()
        table.writerows({name: getattr(each, name) for name in names} for each in found)


def main() -> int:
    """Run all and compare; 1 where a verdict is worse."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind.ci")
    parser.add_argument("--out", type=Path, default=Path("out/blind-ci"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--publish", action="store_true", help="write ci.csv anew")
    asked = parser.parse_args()
    found = run(asked.out, asked.workers)
    if asked.publish:
        publish(found)
        return 0
    worse = [mine.worse_than(before) for mine, before in zip(found, expected(), strict=True)]
    print("\n".join(filter(None, worse)) or "no verdict is worse than the committed one")
    return int(any(worse))


if __name__ == "__main__":
    sys.exit(main())
