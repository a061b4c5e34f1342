"""Stages of the blind benchmark, in the order in which they run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import pandas as pd
from rich.console import Console

from benchmarks.blind import (
    alarms,
    cases,
    controls,
    diagnoses,
    followup,
    full,
    generator,
    library,
    misfit,
    packed,
    report,
)
from benchmarks.blind.cases import Case
from benchmarks.blind.diagnoses import How
from benchmarks.blind.judging import CaseSet, Folders
from benchmarks.blind.protocols import FINGERS, PROTOCOLS, PULL, WITH_COUPON
from benchmarks.blind.response import Catalogue
from dolfingrip.cli import progress
from dolfingrip.design.campaign.cluster import Where
from dolfingrip.diagnosis.simulation.runner import Workers


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
        screen_first: diagnose by closed forms, and whole unless these find no cause.
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
    screen_first: bool
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
        return How(self.folders.analyser, self.workers, self.quick, screen_first=self.screen_first)

    @property
    def scores(self) -> Path:
        """Folder of the figures."""
        own = "" if set(self.only) <= set(FINGERS) else "-".join(self.only) + "-"
        return self.out / "score" / f"{own}{self.set_name}-{self.mode}"

    @property
    def mode(self) -> str:
        """How cases are diagnosed, in a word."""
        return "screened" if self.screen_first else self.how.mode

    def at_work(self, show: Callable[..., None]) -> Workers:
        """Workers that show their progress."""
        return Workers(self.folders.library, Where(workers=self.workers), show, self.retry_failed)


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
        with progress.designs(asked.screen) as show, ExitStack() as stack:
            workers = partial(packed.at_hand, asked.at_work(show), stack)
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
    with progress.designs(asked.screen) as show:
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
    case_set = CaseSet(planned(asked), asked.folders)
    diagnose_all(asked, [case for case, _ in case_set.made()])


def diagnose_all(asked: Asked, every: Sequence[Case]) -> None:
    """Diagnose what has not been, with workers that stay."""
    with (
        progress.shown(asked.screen, "cases", at_once=True, few=progress.FEW) as show,
        diagnoses.with_crew(asked.how) as how,
    ):
        for number, case in enumerate(every):
            show(number, len(every), case.name)
            diagnoses.diagnose(case, asked.folders.case(case), how)
        show(len(every), len(every))


def run_next(asked: Asked) -> None:
    """Make the experiments that were proposed for ties, and diagnose with them."""
    case_set = CaseSet(planned(asked), asked.folders)
    tied = [
        case
        for case, _ in case_set.made()
        if diagnoses.is_known(asked.folders.case(case), asked.how)
        and followup.to_be_split(
            case, diagnoses.diagnose(case, asked.folders.case(case), asked.how)
        )
    ]
    with (
        progress.shown(asked.screen, "ties", at_once=True, few=progress.FEW) as show,
        diagnoses.with_crew(asked.how) as how,
    ):
        for number, case in enumerate(tied):
            show(number, len(tied), case.name)
            own = Workers(asked.folders.full, Where(workers=asked.workers))
            followup.split(case, asked.folders.case(case), how, own)
        show(len(tied), len(tied))


def run_controls(asked: Asked) -> None:
    """The same cases with other noise, or with noise that is not as told: controls.csv."""
    wanted = controls.variants(planned(asked))
    case_set = CaseSet([case for own in wanted.values() for case in own], asked.folders)
    diagnose_all(asked, [case for case, _ in case_set.made()])
    table = controls.table(wanted, asked.folders.case, asked.how)
    table["noticeable"] = [noticeable(case_set, wanted[name]) for name in table["control"]]
    asked.scores.mkdir(parents=True, exist_ok=True)
    table.to_csv(asked.scores / "controls.csv", index=False)
    asked.screen.print(table.to_string(index=False), soft_wrap=True, markup=False)


def noticeable(case_set: CaseSet, own: Sequence[Case]) -> float:
    """The share of :func:`controls.noticeable` over the cases of one control."""
    kinds = Counter((case.protocol, case.instruments) for case in own)
    found = [
        count * controls.noticeable(case_set.bound(protocol), instruments)
        for (protocol, instruments), count in kinds.items()
    ]
    return sum(found) / len(own)


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


def run_misfit(asked: Asked) -> None:
    """What the generator's finger leaves without a cause: misfit.csv (only where asked for)."""
    with (
        progress.shown(asked.screen, "fits", at_once=True) as show,
        diagnoses.with_crew(asked.how) as how,
    ):
        table = pd.concat(
            misfit.table(catalogue, asked.out / "misfit", how, show)
            for catalogue in catalogues(asked)
        )
    table.to_csv(asked.out / "misfit" / "misfit.csv", index=False)
    asked.screen.print(table.to_string(index=False), soft_wrap=True, markup=False)


def run_score(asked: Asked) -> None:
    """Hold the verdicts against the bound: figures.md, figures.csv, cases.csv, confusion.png."""
    case_set = CaseSet(planned(asked), asked.folders)
    with progress.shown(asked.screen, "cases", at_once=True) as show:
        judged = case_set.judged(asked.how, show)
    title = f"Blind benchmark, {asked.set_name} cases, {asked.mode}"
    asked.screen.print(report.write(judged, title, asked.scores), soft_wrap=True, markup=False)
    asked.screen.print(f"wrote {asked.scores}", soft_wrap=True)


STAGES: Final[Mapping[str, Callable[[Asked], None]]] = {
    "library": run_library,
    "pack": run_pack,
    "full": run_full,
    "cases": run_cases,
    "diagnose": run_diagnose,
    "next": run_next,
    "score": run_score,
    "controls": run_controls,
    "alarms": run_alarms,
    "misfit": run_misfit,
}
EXTRA: Final = ("pack", "alarms", "misfit")
ORDINARY: Final = tuple(name for name in STAGES if name not in EXTRA)
"""Those that are run where none is named."""
