"""A case is diagnosed, what the answer advises is done, and all is diagnosed again."""

from __future__ import annotations

import csv
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from benchmarks.blind import frozen
from benchmarks.blind.answers import MU, spent_s
from benchmarks.blind.frozen import FrozenCase
from benchmarks.blind.loop import cases
from benchmarks.blind.loop.laboratory import Laboratory, NotPossible, truth_of
from benchmarks.blind.said import rows
from benchmarks.outcomes import commit
from dolfingrip.cli import progress
from dolfingrip.cli.console import console
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.diagnosis.results import write
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.files.diagnosis import DiagnosisFile, NextExperiment
from dolfingrip.files.diagnosis_words import number_words
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.store import Store

WALLS: Final = "finger.wall_mm"
COLUMNS: Final = (
    "protocol", "kind", "number", "round", "answer", "first", "second", "probability",
    "unexplained", "covers", "numbers", "open", "advised", "minutes", "undone",
    "processor_s", "simulations", "commit",
)  # fmt: skip
REFUSED: Final = "refused"
LATE: Final = "late"
MINUTES: Final = 30.0
"""Of a diagnosis, at most."""
LOADED: Final = commit()
"""Commit whose package answers: a run lasts longer than a branch stands still."""


class _Late(Exception):
    """A diagnosis takes longer than it may."""


@contextmanager
def _within(minutes: float) -> Iterator[None]:
    def late(number: int, frame: object) -> None:
        raise _Late(f"no answer within {minutes:g} minutes")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, 60 * minutes)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


Diagnose = Callable[[Laboratory, Path], DiagnosisFile]
"""Diagnoses what a laboratory measured so far, and writes the result into a folder."""


def diagnosed(store: Path, workers: int) -> Diagnose:
    """Return what diagnoses as ``dolfingrip diagnose`` does.

    Args:
        store: folder of simulations, which all cases share.
        workers: processes.
    """

    def call(laboratory: Laboratory, folder: Path) -> DiagnosisFile:
        files = laboratory.write(folder / "measured")
        with progress.jobs(console(), "simulations") as show:
            settings = DiagnosisSettings(workers, store, progress=show)
            diagnosis = diagnose(files, laboratory.config, folder, settings)
        result, _ = write(diagnosis, files, folder)
        return result

    return call


def simulations(store: Path) -> int:
    """Count the simulations in a store.

    Args:
        store: its folder; there are none where it does not exist.
    """
    if not store.exists():
        return 0
    with Store(store) as kept:
        return len(list(kept.rows()))


def run(
    case: FrozenCase,
    laboratory: Laboratory,
    diagnosing: Diagnose,
    out: Path,
    rounds: int,
    table: Path,
    count: Callable[[], int] = lambda: 0,
    minutes: float = MINUTES,
) -> None:
    """Diagnose a case, and do what is advised; a call resumes one that was killed.

    Args:
        case: what is hidden.
        laboratory: that has the first measurement.
        diagnosing: diagnoses.
        out: folder of the case.
        rounds: of advice, at most.
        table: CSV with a row for each diagnosis; it grows.
        count: of simulations so far.
        minutes: of a diagnosis, at most; a case that takes longer ends there.
    """
    done = {
        int(row["round"]): row for row in (rows(table) if table.exists() else ())
        if (row["kind"], int(row["number"])) == (case.kind, case.number)
    }  # fmt: skip
    if done and (max(done) >= rounds or not done[max(done)]["advised"]):
        return
    names: list[str] = []
    for turn in range(rounds + 1):
        folder = out / f"round-{turn}"
        before_s, before = spent_s(), count()
        print(f"{case.protocol} {case.name}, round {turn} of {rounds}", flush=True)
        try:
            read = turn in done and DiagnosisFile.is_in(folder)
            with _within(minutes):
                result = DiagnosisFile.read(folder) if read else diagnosing(laboratory, folder)
        except (ConfigError, _Late) as error:
            ended = LATE if isinstance(error, _Late) else REFUSED
            _add(table, _row(case, turn) | {"answer": ended, "undone": f"{error}"})
            return
        row = _row(case, turn) | answered(case, result) | {
            "processor_s": f"{spent_s() - before_s:.1f}",
            "simulations": count() - before,
        }  # fmt: skip
        advised, undone = (
            _followed(laboratory, result, turn, names) if turn < rounds else (None, {})
        )
        if advised:
            names.append(advised.name)
            row |= {"advised": advised.name, "minutes": f"{advised.minutes:.1f}"}
        row["undone"] = "; ".join(f"{name}: {why}" for name, why in undone.items())
        if turn not in done:
            _add(table, row)
            print(*(row[name] for name in COLUMNS[:8]), "|", *case.hidden, "|", row["advised"],
                  flush=True)  # fmt: skip
        if not advised:
            return


def _followed(
    laboratory: Laboratory, result: DiagnosisFile, turn: int, names: list[str]
) -> tuple[NextExperiment | None, dict[str, str]]:
    """Do the best advice that can be done, and tell why better ones could not."""
    undone: dict[str, str] = {}
    for advised in result.next_experiments:
        if advised.name in names:
            undone[advised.name] = "it was done before"
            continue
        try:
            laboratory.do(advised, turn)
        except NotPossible as error:
            undone[advised.name] = f"{error}"
        else:
            return advised, undone
    return None, undone


def _row(case: FrozenCase, turn: int) -> dict[str, Any]:
    empty = dict.fromkeys(COLUMNS, "")
    return empty | {
        "protocol": case.protocol, "kind": case.kind, "number": case.number, "round": turn,
        "commit": LOADED,
    }  # fmt: skip


def answered(case: FrozenCase, result: DiagnosisFile) -> dict[str, Any]:
    """The answer of a result file, beside the truth.

    Args:
        case: what is hidden.
        result: content of ``diagnosis.json``.
    """
    verdict = result.verdict
    mu_MPa = cases.PROTOCOLS[case.protocol].analysed().material.mu_MPa
    true = {MU: float(case.numbers["modulus"]) * mu_MPa, WALLS: float(case.numbers[WALLS])}
    fitted = {number.key: number for number in (result.fits[0].parameters if result.fits else ())}
    there = {key: value for key, value in true.items() if key in fitted}
    return {
        "answer": verdict.answer, "first": " ".join(verdict.effects),
        "second": " ".join(verdict.second), "probability": f"{verdict.probability:.4f}",
        "unexplained": f"{verdict.unexplained:.3g}",
        "covers": " ".join(
            str(int(fitted[key].low <= value <= fitted[key].high)) for key, value in there.items()
        ),
        "numbers": "; ".join(
            f"{number_words(fitted[key])}, truly {value:.3g}" for key, value in there.items()
        ),
        "open": " ".join(cause.name for cause in result.causes if cause.open),
    }  # fmt: skip


def _add(table: Path, row: dict[str, Any]) -> None:
    table.parent.mkdir(parents=True, exist_ok=True)
    begun = table.exists()
    with table.open("a", encoding="utf-8", newline="") as stream:
        written = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        if not begun:
            written.writeheader()
        written.writerow(row)


def grow(
    protocol: str, out: Path, only: int | None, rounds: int, workers: int, table: Path
) -> None:
    """Run the loop on the cases of a protocol; a call resumes one that was killed.

    Args:
        protocol: its name.
        out: folder of measurements and simulations.
        only: the first so many; all where None.
        rounds: of advice, at most.
        workers: processes.
        table: folder of the tables.
    """
    store = out / protocol / "simulations"
    every = frozen.cases(protocol, cases.FOLDER)[:only]
    where = Where(workers=workers)
    for case in every:
        folder, plan = out / protocol / case.name, cases.PROTOCOLS[protocol]
        laboratory = Laboratory(
            plan, truth_of(case, plan), Workers(out / "hidden" / protocol / "generator", where),
            case.seed, [(plan, frozen.written(case, folder / "first", cases.FOLDER))],
        )  # fmt: skip
        run(case, laboratory, diagnosed(store, workers), folder, rounds,
            table / f"{protocol}.csv", lambda: simulations(store))  # fmt: skip
