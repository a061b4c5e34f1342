"""Fingers of another program are measured in holds, and diagnosed; a table of the answers."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.blind.calculix.truth import CASES, COLUMNS, GAP_mm, PRESSURES_kPa, Truth, stored
from benchmarks.blind.said import rows
from benchmarks.outcomes import commit
from dolfingrip.channels import ANGLE, FORCE, PRESSURE
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.files.diagnosis_words import number_words
from dolfingrip.parameter.nuisances import USUAL, WALL

SEED: Final = 20261128
ANSWERS: Final = Path(__file__).with_name("answers.csv")
STEP_s: Final = 2.0
WAITS_s: Final = 6.0
"""The regulator steps, waits, and is read."""
GAUGE_kPa: Final = 0.3
NOISE: Final = {ANGLE.name: 0.15, FORCE.name: 0.01}
"""Half the ordinary one."""
TOLD: Final = f"""experiment = ["bending", "blocked_force"]
plate.gap_mm = {GAP_mm}
[noise]
angle_deg = {NOISE[ANGLE.name]}
force_N = {NOISE[FORCE.name]}
pressure_kPa = {GAUGE_kPa}
"""


def measured(name: str, folder: Path) -> Path:
    """Write what a laboratory would have read of a case, with noise, all in holds.

    Args:
        name: of the case.
        folder: for the table and its TOML.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng((SEED, list(CASES).index(name)))
    columns, own = [*COLUMNS.values()], stored()[name]
    lines = [",".join(["experiment", "branch", "time_s", PRESSURE.name, *columns])]
    for experiment, column in COLUMNS.items():
        true = [0.0, *own[column]]
        for place, (pressure, value) in enumerate(zip((0.0, *PRESSURES_kPa), true, strict=True)):
            read = value + NOISE[column] * rng.standard_normal() if place else 0.0
            at = pressure + GAUGE_kPa * rng.standard_normal() if place else 0.0
            shown = [f"{read:.4g}" if each == column else "" for each in columns]
            moment_s = place * (STEP_s + WAITS_s)
            lines.append(",".join([experiment, "hold", f"{moment_s:g}", f"{at:.2f}", *shown]))
    file = folder / f"{name}.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    file.with_suffix(".toml").write_text(TOLD, encoding="utf-8")
    return file


@dataclass(frozen=True, slots=True)
class Answered:
    """The answer to a case.

    Attributes:
        case, hidden: its name, and what is to be named.
        answer, probability: that was given.
        first, second: sets of causes that are named.
        may_act: causes that are told as possible where none is named.
        held: of the true numbers how many an interval has.
        numbers: true and fitted ones by key, with intervals.
        commit: whose package answered.
    """

    case: str
    hidden: str
    answer: str
    probability: str
    first: str
    second: str
    may_act: str
    held: str
    numbers: str
    commit: str

    @property
    def sets(self) -> list[set[str]]:
        """Sets of causes that are claimed."""
        return [set(each.split()) for each in (self.first, self.second) if each]

    @property
    def truths(self) -> list[set[str]]:
        """Names that are right, a set for each thing that is hidden."""
        return [set(each.split("|")) for each in self.hidden.split(" + ") if each]

    @property
    def false_and_sure(self) -> bool:
        """Tell if a claim has a set without what is hidden, or is of nothing where something is."""
        hidden = set().union(*self.truths)
        if float(self.probability) < POLICY.claimed or self.answer == "unknown":
            return False
        return any(not each & hidden for each in self.sets) if self.sets else bool(hidden)

    @property
    def told(self) -> bool:
        """Tell if what is hidden is named, or among what the page asks to tell apart."""
        if not self.hidden:
            return self.answer == "none"
        told = self.sets if self.answer == "cause" else [set(self.may_act.split())]
        return any(own & each for own in self.truths for each in told)


def answered(name: str, truth: Truth, found: Diagnosis) -> Answered:
    """The answer as a row.

    Args:
        name: of the case.
        truth: what is hidden in it.
        found: its diagnosis.
    """
    decision = found.decision
    hidden = {own for names in truth.named for own in names} & {*found.posterior.names}
    fits = [decision.best, *(found.member(each) for each in sorted(hidden))]
    fitted = {each.key: each for fit in reversed(fits) for each in found.numbers(fit)}
    known = {key: value for key, value in truth.true_numbers.items() if key in fitted}
    held = sum(fitted[key].low <= value <= fitted[key].high for key, value in known.items())
    return Answered(
        name, " + ".join("|".join(sorted(each)) for each in truth.named), decision.answer,
        f"{found.probability:.3f}", " ".join(decision.first), " ".join(decision.second),
        " ".join(found.open_names), f"{held} of {len(known)}",
        "; ".join(
            f"{number_words(fitted[key])}, truly {value:.3g}" for key, value in known.items()
        ),
        commit(),
    )  # fmt: skip


def run(names: Sequence[str], out: Path, table: Path = ANSWERS, *, quick: bool = True) -> None:
    """Diagnose cases, and write their answers in the place of those before.

    Args:
        names: of the cases.
        out: folder of measurements and simulations, which all cases share.
        table: of the answers.
        quick: as ``diagnose --quick``.
    """
    every = {each.case: each for each in answers(table)}
    for name in names:
        file = measured(name, out / name)
        settings = DiagnosisSettings(store=out / "simulations", quick=quick)
        found = diagnose([file], Config(), out / name, settings)
        every[name] = answered(name, CASES[name], found)
        print(*astuple(every[name]), sep=" | ", flush=True)
        with table.open("w", encoding="utf-8", newline="") as stream:
            shown = csv.writer(stream, lineterminator="\n")
            shown.writerow([each.name for each in fields(Answered)])
            shown.writerows(astuple(every[each]) for each in CASES if each in every)


def answers(table: Path = ANSWERS) -> Iterator[Answered]:
    """Read the answers of a table.

    Args:
        table: a file; there are none where it does not exist.
    """
    if table.exists():
        yield from (Answered(**row) for row in rows(table))


def strengths() -> dict[str, float]:
    """Standard deviations by which each case differs from the first beside modulus and walls.

    Both change the readings as in the cases that are of them, as far as their usual deviations.
    """
    read = {
        name: np.concatenate([np.array(own[each]) / NOISE[each] for each in NOISE])
        for name, own in stored().items()
    }
    changes = {name: each - read["nothing"] for name, each in read.items()}
    usual = {"modulus": USUAL["modulus"] / (CASES["modulus"].modulus - 1),
             "walls": USUAL[WALL] / (CASES["walls"].walls - 1)}  # fmt: skip
    columns = np.column_stack([usual[name] * changes[name] for name in usual])
    covariance = np.eye(len(columns)) + columns @ columns.T
    return {
        name: float(np.sqrt(each @ np.linalg.solve(covariance, each)))
        for name, each in changes.items() if name not in {"nothing", *usual}
    }  # fmt: skip


def score(found: Sequence[Answered]) -> str:
    """Figures of a table, in Markdown.

    Args:
        found: the answers of all cases.
    """
    seen = strengths().values()
    held, count = np.sum([[int(n) for n in each.held.split(" of ")] for each in found], axis=0)
    return "\n".join([
        "| figure | target | |", "|---|---|---|",
        f"| false and sure | 0 | {sum(each.false_and_sure for each in found)} of {len(found)} |",
        "| the truth is named, or among what is to be told apart | ≥ 0.8 | "
        f"{sum(each.told for each in found)} of {len(found)} |",
        f"| fitted numbers in their intervals | ≥ 0.85 | {held / count:.2f} of {count} |",
        f"\nHidden at {min(seen):.1f} to {max(seen):.1f} standard deviations.",
    ])  # fmt: skip
