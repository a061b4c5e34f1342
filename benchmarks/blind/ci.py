"""Twelve whole cases on coupons and a short finger, from their own simulations to a verdict.

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
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Final

from benchmarks.blind import full
from benchmarks.blind.cases import Case, Kind, read, write
from benchmarks.blind.coupons.cases import Bench, drawn
from benchmarks.blind.coupons.run import diagnosed
from benchmarks.blind.diagnoses import How, diagnose, with_crew
from benchmarks.blind.noise import Instruments
from benchmarks.blind.opinions import Opinion
from benchmarks.blind.outsiders import OUTSIDERS
from benchmarks.blind.protocols import PROTOCOLS
from benchmarks.blind.response import NUISANCES, Hidden, Truth
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.jobs.cluster import Where

EXPECTED: Final = Path(__file__).with_name("ci.csv")
EFFECTS: Final[Mapping[str, tuple[str, ...]]] = {
    "short": (
        "print_anisotropy", "plate_compliance", "angle_gain", "force_gain", "force_offset",
    ),
}  # fmt: skip
"""That are tried: fewer than the catalogue, as each is compiled and simulated."""
SHARP: Final = {"short": 0.5}
"""Factor of the noise: a short finger bends little, by 7°, on both meshes alike to 0.1°."""

HIDDEN: Final[Sequence[tuple[str, tuple[tuple[str, int, float], ...]]]] = (
    ("short", ()),
    ("short", (("force_offset", 0, 2.0),)),
    ("short", (("print_anisotropy", 0, 1.2),)),
    ("short", (("soft_foam", 0, 1.0),)),
)
"""Protocol and causes of each case of a finger: with form and strength."""
COUPONS: Final[Sequence[tuple[str, str, int]]] = (
    ("pull", "none", 0),
    ("pull", "one", 0),
    ("pull", "with_outsider", 1),
    ("pull", "outsider", 2),
    ("pull", "nuisance", 2),
    ("loops", "one", 0),
    ("loops", "with_outsider", 0),
    ("loops", "none", 0),
)
"""Protocol, kind and number of cases of coupons, of the development set."""


def names() -> list[str]:
    """Of all cases, coupons first."""
    of_pulls = [f"ci-{number:03d}-{protocol}" for number, (protocol, _, _) in enumerate(COUPONS)]
    return [*of_pulls, *(each.name for each in cases())]


def cases() -> list[Case]:
    """Those of a finger, with nuisances of their own."""
    found = []
    for number, (protocol, causes) in enumerate(HIDDEN, len(COUPONS)):
        kind: Kind = "none"
        if causes:
            kind = "one" if len(causes) == 1 else "two"
            kind = "outsider" if causes[0][0] in OUTSIDERS else kind
        known = PROTOCOLS[protocol].known_better
        sizes = {
            name: round(known.get(name, 1.0) * 1.2 * ((7 * number + 3 * i) % 11 - 5) / 5, 3)
            for i, name in enumerate(NUISANCES)
        }
        truth = Truth(tuple(Hidden(*each) for each in causes), sizes)
        scatter = Instruments(factor=SHARP[protocol])
        seed = (12, number)
        found.append(Case("ci", number, protocol, kind, True, truth, seed, scatter))
    return found


@dataclass(frozen=True, slots=True)
class Answered:
    """What was said of a case.

    Attributes:
        case: name.
        hidden: causes.
        answer: ``cause``, ``none`` or ``unknown``.
        named: effects of the classes that are named.
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


def answered(case: Case, opinion: Opinion) -> Answered:
    """The answer as a row."""
    right = {
        "none": opinion.answer == "none",
        "outsider": opinion.answer == "unknown",
        "one": len(opinion.named) == 1 and opinion.right(case.hidden),
        "two": len(opinion.named) == 2 and opinion.right(case.hidden),
    }[case.kind]
    named = " + ".join(" or ".join(sorted(names)) for names in opinion.named)
    return Answered(case.name, " + ".join(case.hidden), opinion.answer, named, right)


def of_coupons(out: Path) -> list[Answered]:
    """Coupons, each simulated on its own and diagnosed."""
    benches: dict[str, Bench] = {}
    found = []
    for name, (protocol, kind, which) in zip(names(), COUPONS, strict=False):
        bench = benches.setdefault(protocol, Bench(protocol, out / protocol))
        case = drawn(bench, "development", kind, which)
        decision = diagnosed(bench, case, out / "cases").decision
        sets = [names for names in (decision.first, decision.second) if names]
        hidden = {*case.names}
        right = all(set(names) & hidden for names in sets) and {
            "none": decision.answer == "none",
            "outsider": decision.answer == "unknown",
        }.get(kind, decision.answer == "cause")
        told = [*case.names, *filter(None, [case.truth.outsider[0]])]
        found.append(
            Answered(
                name, " + ".join(told), decision.answer,
                " + ".join(" or ".join(sorted(names)) for names in sets), right,
            )
        )  # fmt: skip
        print(f"{found[-1]}", flush=True)
    return found


def run(out: Path, workers: int, only: Sequence[Case] | None = None) -> list[Answered]:
    """Simulate, write, diagnose."""
    wanted = list(only) if only is not None else cases()
    store = out / full.STORE
    full.compute(wanted, Workers(store, Where(workers=workers)))
    results = full.known_results(store)
    found = []
    with with_crew(How(out / "analyser", workers)) as shared:
        for case in wanted:
            true = full.vector(case, results)
            if true is None:
                raise ValueError(f"{case.name}: its simulation ended early")
            folder = out / "cases" / case.name
            write(case, read(case, true), folder)
            how = replace(shared, effects=EFFECTS[case.protocol])
            found.append(answered(case, Opinion.of_file(diagnose(case, folder, how))))
            print(f"{found[-1]}", flush=True)
    return found


def expected() -> list[Answered]:
    """What is committed."""
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
    found = [*of_coupons(asked.out / "coupons"), *run(asked.out / "fingers", asked.workers)]
    if asked.publish:
        publish(found)
        return 0
    worse = [mine.worse_than(before) for mine, before in zip(found, expected(), strict=True)]
    print("\n".join(filter(None, worse)) or "no verdict is worse than the committed one")
    return int(any(worse))


if __name__ == "__main__":
    sys.exit(main())
