"""Diagnose cases and write what was said, a row for each; a call resumes one that was killed."""

from __future__ import annotations

import csv
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blind.coupons import coupon
from benchmarks.blind.coupons.cases import COUNTS, Bench, Case, drawn
from dolfingrip.diagnosis.core.search import Posterior, search
from dolfingrip.diagnosis.core.sensitivity import sensitivity
from dolfingrip.diagnosis.coupon.diagnose import diagnose_coupons
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis
from dolfingrip.diagnosis.data import measurement

COLUMNS = (
    "protocol", "kind", "number", "wide", "hidden", "outsider", "outsider_strength", "sigma",
    "answer", "first", "second", "probability", "least", "unexplained", "exact_first",
    "exact_second", "rank_modulus", "rank_cause", "covers", "inclusion", "processor_s",
)  # fmt: skip


def run(
    which: str,
    protocol: str,
    out: Path,
    only: int | None = None,
    kinds: Sequence[str] | None = None,
) -> Path:
    """All cases of a set and protocol.

    Args:
        which: the set.
        protocol: its name.
        out: folder of the table.
        only: the first so many of each kind.
        kinds: these alone.
    """
    out.mkdir(parents=True, exist_ok=True)
    file = out / f"{which}-{protocol}.csv"
    done = {(row["kind"], int(row["number"])) for row in rows(file)} if file.exists() else set()
    bench = Bench(protocol, out / "scratch" / f"{which}-{protocol}")
    with file.open("a", encoding="utf-8", newline="") as stream:
        table = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        if not done:
            table.writeheader()
        counts = {k: n for k, n in COUNTS[which].items() if not kinds or k in kinds}
        for number in range(max(counts.values()) if only is None else only):
            for kind in [k for k, count in counts.items() if number < count]:
                if (kind, number) not in done:
                    case = drawn(bench, which, kind, number)
                    table.writerow(_said(bench, case, out / "scratch" / f"{which}-{protocol}"))
                    stream.flush()
    return file


def rows(file: Path) -> list[dict[str, str]]:
    """Rows of a table."""
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def diagnosed(bench: Bench, case: Case, scratch: Path) -> CouponDiagnosis:
    """A case is measured, written, read, and diagnosed up to its verdict."""
    rng = np.random.default_rng((*case.seed, 1))
    forces = coupon.measured(bench.protocol, case.truth, rng)
    file = coupon.write(bench.protocol, forces, scratch / f"{case.kind}-{case.number}")
    read = measurement.read([file], bench.config)
    return diagnose_coupons(read, bench.config, quick=True, kept=bench.kept)


def _said(bench: Bench, case: Case, scratch: Path) -> dict[str, Any]:
    started = time.process_time()
    found = diagnosed(bench, case, scratch)
    spent = time.process_time() - started
    decision = found.decision
    exact = _exact(bench, found) if case.kind in ("two", "nuisance") else None
    ranks = _ranks(case, found) if case.kind in ("prior", "one") else {}
    visible = {name: round(p, 4) for name, p in decision.inclusion.items() if p >= 0.002}
    row = {
        "protocol": case.protocol, "kind": case.kind, "number": case.number, "wide": case.wide,
        "hidden": " ".join(case.names), "outsider": case.truth.outsider[0],
        "outsider_strength": f"{case.truth.outsider[1]:.3g}",
        "sigma": " ".join(f"{each:.3g}" for each in case.sigma), "answer": decision.answer,
        "first": " ".join(decision.first), "second": " ".join(decision.second),
        "probability": f"{decision.probability:.4f}", "least": f"{found.sensitivity.least:.4f}",
        "unexplained": f"{decision.unexplained:.3g}",
        "exact_first": " ".join(exact.first) if exact else "",
        "exact_second": " ".join(exact.second) if exact else "",
        "inclusion": " ".join(f"{name}:{p}" for name, p in visible.items()),
        "processor_s": f"{spent:.1f}", **ranks,
    }  # fmt: skip
    print(*(row[k] for k in ("protocol", "kind", "number", "hidden", "outsider", "sigma", "answer",
                             "first", "second", "probability", "processor_s")),
          sep=" | ", flush=True)  # fmt: skip
    return row


def _exact(bench: Bench, found: CouponDiagnosis) -> Any:
    """The answer under the true covariance, and without a discrepancy, which is not there."""
    case, off = found.coupons.case, found.coupons.errors
    listed = found.coupons.simulation.measurement.listed()
    specimen = listed["specimen"].to_numpy()
    same = specimen[:, None] == specimen
    signal = off.signal
    steep = off.shared[0].change / off.shared[0].std
    true = np.diag(np.full(len(signal), coupon.NOISE_N**2) + (steep * coupon.NOISE_mm) ** 2)
    true += coupon.SCALE**2 * np.outer(signal, signal) * same
    true += coupon.SHAPE**2 * case.kernel * same
    true += 0.5 * coupon.SLACK_mm**2 * np.outer(steep, steep) * same
    for each in off.shared:
        true += np.outer(each.change, each.change)
    known = replace(case, covariance=true, kernel=np.zeros_like(true))
    return sensitivity(search(known, np.random.default_rng(0), sample=False))[0]


def _ranks(case: Case, found: CouponDiagnosis) -> dict[str, str]:
    """Rank of the true numbers among draws of the hypothesis that is true."""
    posterior: Posterior = found.posterior
    fits = [
        (p, fit)
        for p, fit in zip(posterior.probability, posterior.fits, strict=True)
        if fit.subset == case.names and p > 0
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
    true = np.r_[np.nan, case.zeta]
    factor = np.log(found.coupons.case.factor(every[:, 0])[0])
    modulus = float(weight[factor < np.log(case.truth.modulus)].sum())
    told = {"rank_modulus": f"{modulus:.4f}"}
    if len(case.zeta):
        own_ranks = [float(weight[every[:, i] < true[i]].sum()) for i in range(1, len(true))]
        told["rank_cause"] = f"{own_ranks[0]:.4f}"
        told["covers"] = " ".join(str(int(0.05 <= each <= 0.95)) for each in own_ranks)
    return told


def told(row: dict[str, str], key: str) -> list[str]:
    """Words of a cell."""
    return row[key].split()


def every(folder: Path, which: str) -> Iterator[dict[str, str]]:
    """Rows of all tables of a set."""
    for file in sorted(folder.glob(f"{which}-*.csv")):
        yield from rows(file)
