"""Stages of the blind benchmark, in the order in which they run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

from rich.console import Console

from benchmarks.blind import alarms, cases, diagnoses, full, generator, library, packed, report
from benchmarks.blind.cases import Case
from benchmarks.blind.diagnoses import How
from benchmarks.blind.judging import CaseSet, Folders
from benchmarks.blind.protocols import FINGERS, PROTOCOLS, PULL, WITH_COUPON
from benchmarks.blind.response import Catalogue
from dolfingrip.cli import progress
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress


@dataclass(frozen=True, slots=True)
class Asked:
    """What was asked for.

    Attributes:
        out: folder of all that is kept.
        set_name: of the cases.
        only: names of protocols.
        number: of cases of a set, those of other protocols included.
        workers: number of processes.
        quick: diagnose by closed forms alone.
        retry_failed: simulate again what failed.
        draws: measurements without a cause, of each protocol.
        screen: where progress is shown.
    """

    out: Path
    set_name: str
    only: tuple[str, ...]
    number: int
    workers: int
    quick: bool
    retry_failed: bool
    draws: alarms.Draws
    screen: Console

    @property
    def folders(self) -> Folders:
        """Where things are kept."""
        return Folders(self.out)

    @property
    def how(self) -> How:
        """How cases are diagnosed."""
        return How(self.folders.analyser, self.workers, self.quick)

    @property
    def scores(self) -> Path:
        """Folder of the figures."""
        own = "" if set(self.only) <= set(FINGERS) else "-".join(self.only) + "-"
        return self.out / "score" / f"{own}{self.set_name}-{self.how.mode}"

    def at_work(self, show: Callable[..., None]) -> Workers:
        """Workers that show their progress."""
        return Workers(self.folders.library, Where(workers=self.workers), show, self.retry_failed)


def designs(asked: Asked) -> AbstractContextManager[Progress]:
    """Shows how many simulations are done."""
    return progress.jobs(asked.screen, "designs", progress.FEW)


def histories(asked: Asked) -> list[str]:
    """Histories that the protocols begin like, the shortest first."""
    wanted = {PROTOCOLS[name].history for name in asked.only}
    if set(WITH_COUPON) & set(asked.only):
        wanted.add(PULL)
    return [history for history in library.HISTORIES if history in wanted]


def run_library(asked: Asked) -> None:
    """Simulate the generator's responses: curves first, then histories, the shortest first."""
    for history in histories(asked):
        asked.screen.print(f"library of {history}", soft_wrap=True)
        with designs(asked) as show, Pool(Where(workers=asked.workers)) as pool:
            workers = partial(packed.at_hand, asked.at_work(show), pool)
            library.compute(history, asked.folders.library, workers)


def run_pack(asked: Asked) -> None:
    """Write what was simulated into benchmarks/blind/simulated (only where asked for)."""
    every = [entry for history in histories(asked) for entry in library.entries(history)]
    files = packed.write(every, asked.folders.library)
    with diagnoses.with_crew(asked.how) as how:
        # coupons are simulated in no time
        own = tuple(name for name in asked.only if PROTOCOLS[name].body != "coupon")
        fingers = replace(asked, only=own)
        files += packed.write_analyser(list(catalogues(fingers)), asked.out / "packed", how)
    for file in files:
        size = f"{file.stat().st_size / 1000:.0f} kB"
        asked.screen.print(f"wrote {file}, {size}", soft_wrap=True, markup=False)


def planned(asked: Asked) -> list[Case]:
    """The cases of the set that follow the protocols asked for."""
    if set(asked.only) <= set(FINGERS):
        every = cases.plan(asked.set_name, asked.number)
        return [case for case in every if case.protocol in asked.only]
    often = dict.fromkeys(asked.only, 1.0)
    return cases.plan(asked.set_name, asked.number, often, full=often)


def run_full(asked: Asked) -> None:
    """Simulate the cases that have a simulation of their own."""
    own = [case for case in planned(asked) if case.full]
    with designs(asked) as show:
        full.compute(own, replace(asked.at_work(show), store=asked.folders.full))


def run_cases(asked: Asked) -> None:
    """Write the cases that the library allows so far: measured.csv, measured.toml, truth.json."""
    case_set = CaseSet(planned(asked), asked.folders)
    made = sum(1 for _ in case_set.made())
    folder = asked.out / "cases"
    cases.table_of(case_set.cases).to_csv(folder / f"{asked.set_name}.csv", index=False)
    missing = len(case_set.cases) - made
    asked.screen.print(f"{made} cases in {folder}; {missing} wait for simulations", soft_wrap=True)
    for line in case_set.failures():
        asked.screen.print(f"not hidden: {line}", soft_wrap=True, markup=False)


def run_diagnose(asked: Asked) -> None:
    """Diagnose them; with --quick by closed forms alone."""
    every = [case for case, _ in CaseSet(planned(asked), asked.folders).made()]
    with (
        progress.shown(asked.screen, "cases", at_once=True, few=progress.FEW) as show,
        diagnoses.with_crew(asked.how) as how,
    ):
        for number, case in enumerate(every):
            show(number, len(every), case.name)
            diagnoses.diagnose(case, asked.folders.case(case), how)
        show(len(every), len(every))


def catalogues(asked: Asked) -> Iterator[Catalogue]:
    """The generator's, of each protocol asked for."""
    known = generator.causes()
    for name in asked.only:
        own = library.of_protocol(PROTOCOLS[name], asked.folders.library)
        yield Catalogue(PROTOCOLS[name], own, known)


def run_alarms(asked: Asked) -> None:
    """Many measurements without a cause of each protocol: alarms.csv (only where asked for)."""
    found = {}
    with (
        progress.shown(asked.screen, "draws", at_once=True) as show,
        diagnoses.with_crew(asked.how) as how,
    ):
        for catalogue in catalogues(asked):
            found[catalogue.protocol.name] = alarms.draw(catalogue, asked.draws, how, show)
    table = alarms.table(found, asked.draws.seed)
    table.to_csv(asked.out / "alarms" / "alarms.csv", index=False)
    asked.screen.print(table.to_string(index=False), soft_wrap=True, markup=False)


def run_score(asked: Asked) -> None:
    """Hold the verdicts against the bound: figures.md, figures.csv, cases.csv."""
    case_set = CaseSet(planned(asked), asked.folders)
    with progress.shown(asked.screen, "cases", at_once=True) as show:
        judged = case_set.judged(asked.how, show)
    title = f"Blind benchmark, {asked.set_name} cases, {asked.how.mode}"
    asked.screen.print(report.write(judged, title, asked.scores), soft_wrap=True, markup=False)
    asked.screen.print(f"wrote {asked.scores}", soft_wrap=True)


STAGES: Final[Mapping[str, Callable[[Asked], None]]] = {
    "library": run_library,
    "pack": run_pack,
    "full": run_full,
    "cases": run_cases,
    "diagnose": run_diagnose,
    "score": run_score,
    "alarms": run_alarms,
}
EXTRA: Final = ("pack", "alarms")
ORDINARY: Final = tuple(name for name in STAGES if name not in EXTRA)
"""Those that are run where none is named."""
