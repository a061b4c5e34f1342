"""The table of hidden causes and of answers: a row for each case; it grows."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blind import frozen
from benchmarks.blind.case import Case, Hidden
from benchmarks.blind.frozen import FrozenCase
from benchmarks.outcomes import commit
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.search import ModelPosterior

COLUMNS = (
    "protocol", "kind", "number", "wide", "hidden", "outsider", "outsider_strength", "sigma",
    "answer", "first", "second", "probability", "least", "unexplained", "exact_first",
    "exact_second", "rank_modulus", "rank_cause", "covers", "inclusion", "processor_s",
    "seed", "commit",
)  # fmt: skip
SHOWN = (
    "protocol", "kind", "number", "hidden", "outsider", "sigma", "answer", "first", "second",
    "probability", "processor_s",
)  # fmt: skip


@dataclass(frozen=True)
class Bench[C]:
    """A protocol whose cases can be drawn and diagnosed.

    Attributes:
        drawn: a case, by set, kind and number.
        diagnosed: what is found out about it.
        exact: the answer of exact evidence, where there is one.
        measured: writes its readings and what the laboratory tells.
        frozen: what is hidden in it, as a row.
    """

    drawn: Callable[[str, str, int], C]
    diagnosed: Callable[[C], Diagnosis]
    exact: Callable[[C, Diagnosis], Decision | None] = lambda case, found: None
    measured: Callable[[C], Path] = field(kw_only=True)
    frozen: Callable[[C], FrozenCase] = field(kw_only=True)


def grow[T: Hidden](
    file: Path, bench: Bench[Case[T]], which: str, counts: Mapping[str, int]
) -> None:
    """Cases of a set that a table does not have yet; a call resumes one that was killed.

    Args:
        file: the table.
        bench: draws and diagnoses.
        which: the set.
        counts: cases by kind.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    done = {(row["kind"], int(row["number"])) for row in rows(file)} if file.exists() else set()
    with file.open("a", encoding="utf-8", newline="") as stream:
        table = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        if not done:
            table.writeheader()
        for number in range(max(counts.values(), default=0)):
            for kind in [k for k, count in counts.items() if number < count]:
                if (kind, number) not in done:
                    row = said(bench, bench.drawn(which, kind, number))
                    table.writerow(row)
                    stream.flush()
                    print(*(row[name] for name in SHOWN), sep=" | ", flush=True)


def freeze[T: Hidden](
    bench: Bench[Case[T]], which: str, counts: Mapping[str, int], folder: Path = frozen.FOLDER
) -> None:
    """Write cases of a set as files, which are not there yet; a call resumes one that was killed.

    Args:
        bench: draws and measures.
        which: the set.
        counts: cases by kind.
        folder: of the files.
    """
    known: set[str] | None = None
    for number in range(max(counts.values(), default=0)):
        for kind in [k for k, count in counts.items() if number < count]:
            if known is not None and f"{kind}-{number}" in known:
                continue
            case = bench.drawn(which, kind, number)
            known = known or {each.name for each in frozen.cases(case.protocol, folder)}
            if f"{kind}-{number}" not in known:
                hidden = bench.frozen(case)
                frozen.add(hidden, bench.measured(case), folder)
                print(*hidden.row().values(), sep=" | ", flush=True)


def said[T: Hidden](bench: Bench[Case[T]], case: Case[T]) -> dict[str, Any]:
    """A row of the table: a case is diagnosed."""
    started = _processor_s()
    found = bench.diagnosed(case)
    spent = _processor_s() - started
    decision = found.decision
    exact = bench.exact(case, found) if case.kind in ("two", "nuisance") else None
    ranks = _ranks(case, found) if case.kind in ("prior", "one") else {}
    visible = {name: round(p, 4) for name, p in decision.inclusion.items() if p >= 0.002}
    sigma = case.sigma
    if case.kind == "outsider" and not sigma:
        sigma = (left_by_one(found.posterior),)
    return {
        "protocol": case.protocol, "kind": case.kind, "number": case.number, "wide": case.wide,
        "hidden": " ".join(case.names), "outsider": case.truth.outsider[0],
        "outsider_strength": f"{case.truth.outsider[1]:.3g}",
        "sigma": " ".join(f"{each:.3g}" for each in sigma), "answer": decision.answer,
        "first": " ".join(decision.first), "second": " ".join(decision.second),
        "probability": f"{decision.probability:.4f}", "least": f"{found.sensitivity.least:.4f}",
        "unexplained": f"{decision.unexplained:.3g}",
        "exact_first": " ".join(exact.first) if exact else "",
        "exact_second": " ".join(exact.second) if exact else "",
        "inclusion": " ".join(f"{name}:{p}" for name, p in visible.items()),
        "processor_s": f"{spent:.1f}", "seed": " ".join(map(str, case.seed)), "commit": commit(),
        **ranks,
    }  # fmt: skip


def _processor_s() -> float:
    """Time of processor of this process and of those that it started and that have ended."""
    return sum(os.times()[:4])


def left_by_one(posterior: ModelPosterior) -> float:
    """Standard deviations that the best single cause leaves, beyond those of noise."""
    alone = [
        fit
        for fit in posterior.fits
        if fit.level == 0 and len(posterior.problem.causes(fit.subset)) < 2
    ]
    n = len(posterior.problem.value)
    return float(np.sqrt(max(min(fit.misfit for fit in alone) - n, 0.0)))


def _ranks[T: Hidden](case: Case[T], found: Diagnosis) -> dict[str, str]:
    """Rank of the true numbers among draws of the true causes' hypotheses."""
    posterior, model = found.posterior, found.analysis.problem
    fits = [
        (p, fit)
        for p, fit in zip(posterior.probability, posterior.fits, strict=True)
        if model.causes(fit.subset) == model.causes(case.names) and p > 0
    ]
    if not fits:
        return {}
    draws, weights = [], []
    rng = np.random.default_rng((*case.seed, 2))
    for p, fit in fits:
        if fit.draws is not None:
            own, weight = fit.draws
        else:
            lower = np.linalg.cholesky(np.linalg.inv(fit.hessian))
            own = fit.zeta + rng.standard_normal((400, len(fit.zeta))) @ lower.T
            weight = np.full(len(own), 1 / len(own))
        draws.append(own)
        weights.append(p * weight)
    every, weight = np.vstack(draws), np.concatenate(weights)
    weight = weight / weight.sum()
    modulus = float(weight[model.factor.at(every[:, 0]) < case.truth.modulus].sum())
    told = {"rank_modulus": f"{modulus:.4f}"}
    if len(case.zeta):
        below = every[:, model.nuisance_count : model.nuisance_count + len(case.zeta)] < np.array(
            case.zeta
        )
        own_ranks = (weight @ below).tolist()
        told["rank_cause"] = f"{own_ranks[0]:.4f}"
        told["covers"] = " ".join(str(int(0.05 <= each <= 0.95)) for each in own_ranks)
    return told


def rows(file: Path) -> list[dict[str, str]]:
    """Rows of a table."""
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def every(folder: Path, which: str) -> Iterator[dict[str, str]]:
    """Rows of all tables of a set."""
    for file in sorted(folder.glob(f"{which}-*.csv")):
        yield from rows(file)
