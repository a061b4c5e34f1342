"""Answers to the cases that are kept as files: a table for each protocol, which grows."""

from __future__ import annotations

import csv
import resource
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from support.hidden_coupon import PROTOCOLS as COUPONS

from benchmarks.blind import frozen
from benchmarks.blind.fingers.finger import PROTOCOLS as FINGERS
from benchmarks.blind.frozen import FrozenCase
from benchmarks.blind.said import rows
from benchmarks.outcomes import commit
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis, diagnosed
from dolfingrip.diagnosis.data import measurement
from dolfingrip.diagnosis.screening import analyse, simulator_of
from dolfingrip.diagnosis.simulation.runner import staying
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.files.diagnosis_words import number_words
from dolfingrip.jobs.run import silent

FOLDER: Final = Path(__file__).with_name("answers")
MU: Final = "material.mu_MPa"
COLUMNS: Final = (
    "protocol", "kind", "number", "answer", "first", "second", "probability", "unexplained",
    "covers", "numbers", "inclusion", "processor_s", "commit",
)  # fmt: skip


def configured(protocol: str) -> Config:
    """The model that is diagnosed.

    Args:
        protocol: name of it.
    """
    return Config() if protocol in COUPONS else FINGERS[protocol].analysed()


def diagnose(
    case: FrozenCase,
    out: Path,
    workers: int = 2,
    effects: Sequence[str] | None = None,
    folder: Path = frozen.FOLDER,
) -> Diagnosis:
    """Diagnose a case up to its verdict.

    Args:
        case: which one.
        out: folder of the measurement, and of simulations, which all cases of a protocol share.
        workers: processes.
        effects: that are tried; the whole catalogue where None.
        folder: of the files of the case.
    """
    config = configured(case.protocol)
    file = frozen.written(case, out / case.name, folder)
    read, _ = measurement.selected(measurement.read([file], config), config)
    with staying(out / "simulations", workers, silent) as kept:
        analysis = analyse(
            simulator_of(read, config, kept), unknowns(read, config, effects), effects
        )
        return diagnosed(analysis, config)


def answered(case: FrozenCase, found: Diagnosis, spent_s: float) -> dict[str, Any]:
    """The row of a case.

    Args:
        case: what is hidden.
        found: what was found.
        spent_s: time of the processor.
    """
    decision = found.decision
    hidden = [name for name in case.hidden if name in found.posterior.names]
    fits = [decision.best, *map(found.member, hidden)]
    fitted = {each.key: each for fit in reversed(fits) for each in found.numbers(fit)}
    true = _flat(case, configured(case.protocol))
    known = {key: true[key] for key in fitted if key in true}
    held = {key: fitted[key].low <= value <= fitted[key].high for key, value in known.items()}
    visible = {name: round(p, 4) for name, p in decision.inclusion.items() if p >= 0.002}
    return {
        "protocol": case.protocol, "kind": case.kind, "number": case.number,
        "answer": decision.answer, "first": " ".join(decision.first),
        "second": " ".join(decision.second), "probability": f"{found.probability:.4f}",
        "unexplained": f"{decision.unexplained:.3g}",
        "covers": " ".join(str(int(each)) for each in held.values()),
        "numbers": "; ".join(
            f"{number_words(fitted[key])}, truly {known[key]:.3g}" for key in known
        ),
        "inclusion": " ".join(f"{name}:{p}" for name, p in visible.items()),
        "processor_s": f"{spent_s:.1f}", "commit": commit(),
    }  # fmt: skip


def _flat(case: FrozenCase, config: Config) -> dict[str, float]:
    """True numbers by key; lists, which have a value for each term, by their only one."""
    found = {key: each for key, each in case.numbers.items() if key != "modulus"}
    found[MU] = float(case.numbers["modulus"]) * config.material.mu_MPa
    found = {k: v[0] if isinstance(v, Sequence) and len(v) == 1 else v for k, v in found.items()}
    return {key: float(each) for key, each in found.items() if not isinstance(each, Sequence)}


def spent_s() -> float:
    """Return the processor time of this process and of its children that ended (s)."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def grow(protocol: str, out: Path, only: int | None, table: Path) -> None:
    """Diagnose cases that a table does not have yet; a call resumes one that was killed.

    Args:
        protocol: name of it.
        out: folder of measurements and simulations.
        only: the first so many of each kind; all where None.
        table: folder of the tables.
    """
    file = table / f"{protocol}.csv"
    table.mkdir(parents=True, exist_ok=True)
    done = {(row["kind"], int(row["number"])) for row in rows(file)} if file.exists() else set()
    with file.open("a", encoding="utf-8", newline="") as stream:
        written = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        if not done:
            written.writeheader()
        for case in frozen.cases(protocol):
            if (case.kind, case.number) in done or (only is not None and case.number >= only):
                continue
            before_s = spent_s()
            row = answered(case, diagnose(case, out / protocol), spent_s() - before_s)
            written.writerow(row)
            stream.flush()
            print(
                *(row[name] for name in COLUMNS[:7]), "|", *case.hidden, case.outsider, flush=True
            )


def scored(table: Path) -> Iterator[dict[str, str]]:
    """Answers with what is hidden, as :mod:`benchmarks.blind.score` takes them.

    Args:
        table: folder of the tables.
    """
    for file in sorted(table.glob("*.csv")):
        hidden = {(each.kind, each.number): each for each in frozen.cases(file.stem)}
        for row in rows(file):
            case = hidden[row["kind"], int(row["number"])]
            sigma = case.sigma if case.left is None else (case.left,)
            yield row | {
                "hidden": " ".join(case.hidden), "outsider": case.outsider, "exact_first": "",
                "exact_second": "", "sigma": " ".join(f"{each:.4g}" for each in sigma),
            }  # fmt: skip
