"""Coupons of a case are diagnosed, and held against exact evidence."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from support import hidden_coupon
from support.hidden_coupon import Truth

from benchmarks.blind import said
from benchmarks.blind.case import Case
from benchmarks.blind.coupons.cases import Bench, drawn, frozen
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.answer.diagnosis import diagnosed as diagnose
from dolfingrip.diagnosis.core.decision import Decision, sensitivity
from dolfingrip.diagnosis.core.search import search


def bench(protocol: str, scratch: Path) -> said.Bench[Case[Truth]]:
    """A protocol's cases; measurements are written into ``scratch``."""
    own = Bench(protocol, scratch)
    return said.Bench(
        partial(drawn, own), partial(diagnosed, own, scratch), partial(exact, own),
        measured=partial(measured, own, scratch), frozen=partial(frozen, own),
    )  # fmt: skip


def measured(bench: Bench, scratch: Path, case: Case[Truth]) -> Path:
    """Measure a case and write it."""
    rng = np.random.default_rng((*case.seed, 1))
    forces = hidden_coupon.measured(bench.protocol, case.truth, rng)
    return hidden_coupon.write(bench.protocol, forces, scratch / f"{case.kind}-{case.number}")


def diagnosed(bench: Bench, scratch: Path, case: Case[Truth]) -> Diagnosis:
    """A case is measured, written, read, and diagnosed up to its verdict."""
    return diagnose(bench.analysed(measured(bench, scratch, case)), bench.config)


def exact(bench: Bench, case: Case[Truth], found: Diagnosis) -> Decision:
    """The answer under the true covariance, and without a discrepancy, which is not there."""
    model, off = found.analysis.problem, found.analysis.errors
    listed = found.analysis.simulation.measurement.listed
    specimen = listed["specimen"].to_numpy()
    same = specimen[:, None] == specimen
    signal = off.signal
    steep = off.steep
    true = np.diag(
        np.full(len(signal), hidden_coupon.NOISE_N**2) + (steep * hidden_coupon.NOISE_mm) ** 2
    )
    true += hidden_coupon.SCALE**2 * np.outer(signal, signal) * same
    true += hidden_coupon.SHAPE**2 * model.kernel * same
    true += 0.5 * hidden_coupon.SLACK_mm**2 * np.outer(steep, steep) * same
    known = replace(model, covariance=true, kernel=np.zeros_like(true))
    return sensitivity(search(known, np.random.default_rng(0), sample=False))[0]
