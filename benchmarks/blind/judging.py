"""One set of the benchmark: its cases, their files, diagnoses and the bound's opinions."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from benchmarks.blind import cases as casework
from benchmarks.blind import diagnoses, full, generator, library
from benchmarks.blind.bound import Attained, Bound
from benchmarks.blind.cases import Case, Readings
from benchmarks.blind.diagnoses import How
from benchmarks.blind.opinions import Interval, Judged, Opinion
from benchmarks.blind.protocols import PROTOCOLS
from benchmarks.blind.response import Catalogue

BOUND: Final = "bound.json"


@dataclass(frozen=True, slots=True)
class Folders:
    """Where things are kept.

    Attributes:
        out: folder of the benchmark.
    """

    out: Path

    @property
    def library(self) -> Path:
        """Stores of the generator."""
        return self.out / "library"

    @property
    def full(self) -> Path:
        """Store of cases with a simulation of their own."""
        return self.out / full.STORE

    @property
    def analyser(self) -> Path:
        """Store of the analyser's simulations."""
        return self.out / "analyser"

    def case(self, case: Case) -> Path:
        """Folder of a case."""
        return self.out / "cases" / case.name


class CaseSet:
    """The cases of a set that the library allows so far.

    Args:
        cases: of the plan.
        folders: where things are kept.
    """

    def __init__(self, cases: Sequence[Case], folders: Folders) -> None:
        """Load libraries and results of simulations."""
        self.cases = tuple(cases)
        self.folders = folders
        self._own = full.known_results(folders.full)
        known = generator.causes()
        self._catalogues = {
            name: Catalogue(PROTOCOLS[name], library.of_protocol(PROTOCOLS[name], folders.library),
                            known)
            for name in dict.fromkeys(case.protocol for case in cases)
        }  # fmt: skip
        self._bounds: dict[str, Bound] = {}

    def complete(self, protocol: str) -> bool:
        """Whether the library has all causes of the catalogue for a protocol, or they failed."""
        catalogue = self._catalogues[protocol]
        failed = catalogue.library.failed
        return all(
            catalogue.has(name) or name in failed
            for name in catalogue.causes
            if _felt(catalogue, name)
        )

    def failures(self) -> list[str]:
        """A sentence for each simulation of the libraries that ended early."""
        every = [line for each in self._catalogues.values() for line in each.library.failures]
        return list(dict.fromkeys(every))

    def readings(self, case: Case) -> Readings | None:
        """What a case's instruments read; None where simulations are missing."""
        catalogue = self._catalogues[case.protocol]
        if not all(catalogue.has(name) for name in case.hidden):
            return None
        if case.full:
            true = full.vector(case, self._own)
            return None if true is None else casework.read(case, true)
        return casework.read(case, catalogue.vector(case.truth))

    def made(self) -> Iterator[tuple[Case, Readings]]:
        """Cases that can be made, their files written."""
        for case in self.cases:
            readings = self.readings(case)
            if readings is not None:
                folder = self.folders.case(case)
                if not (folder / "measured.csv").is_file():
                    casework.write(case, readings, folder)
                yield case, readings

    def attained(self, case: Case, readings: Readings) -> dict[str, Any] | None:
        """The bound's opinion, kept in the case's folder; None if columns are missing."""
        path = self.folders.case(case) / BOUND
        if not path.is_file():
            if not self.complete(case.protocol):
                return None
            found = self.bound(case.protocol).attained(case, readings)
            path.write_text(json.dumps(_plain(found)) + "\n", encoding="utf-8")
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return content

    def bound(self, protocol: str) -> Bound:
        """Exact evidence on a protocol."""
        if protocol not in self._bounds:
            self._bounds[protocol] = Bound(self._catalogues[protocol])
        return self._bounds[protocol]

    def judged(self, how: How, show: Callable[[int, int], None]) -> list[Judged]:
        """All cases that were diagnosed in this way, each with its bound."""
        found = []
        every = list(self.made())
        for number, (case, readings) in enumerate(every):
            show(number, len(every))
            if not diagnoses.is_known(self.folders.case(case), how):
                continue
            best = self.attained(case, readings)
            if best is not None:
                content = diagnoses.diagnose(case, self.folders.case(case), how)
                found.append(judge(case, content, best))
        return found


def _felt(catalogue: Catalogue, name: str) -> bool:
    cause = catalogue.causes[name]
    experiments = {course.experiment for course in catalogue.protocol.courses}
    return bool(experiments & library.felt(cause))


def _plain(found: Attained) -> dict[str, Any]:
    return {
        "opinion": asdict(Opinion.of_verdict(found.verdict)),
        "intervals": [asdict(each) for each in found.intervals],
        "cut": found.cut,
        "strengths_sigma": found.strengths_sigma,
        "unexplained_sigma": found.unexplained_sigma,
    }


def judge(
    case: Case,
    content: Mapping[str, Any],
    best: Mapping[str, Any],
) -> Judged:
    """A case with both opinions.

    Args:
        case: which.
        content: of its ``diagnosis.json``.
        best: the bound's, as it is kept.
    """
    exact = best["opinion"]
    return Judged(
        name=case.name,
        protocol=case.protocol,
        kind=case.kind,
        full=case.full,
        hidden=case.hidden,
        strengths_sigma=tuple(best["strengths_sigma"]),
        unexplained_sigma=best["unexplained_sigma"],
        said=Opinion.of_file(content),
        bound=Opinion(
            exact["answer"], exact["probability"], tuple(exact["leading"]),
            tuple(tuple(names) for names in exact["named"]),
        ),
        intervals=diagnoses.intervals(case, dict(content)),
        bound_intervals=tuple(Interval(**each) for each in best["intervals"]),
        cut=diagnoses.cut(dict(content)),
        bound_cut=best["cut"],
        beats_rivals=content["gain_claimed"],
        seconds=float(content["simulated_s"]),
    )  # fmt: skip
