"""Hidden causes of each case, and their strengths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import scipy.linalg
from support import hidden_coupon
from support.hidden_coupon import MODULUS, OUTSIDERS, PROTOCOLS, GAUGE_STD_mm, Truth
from support.stiffened import stiffened

from benchmarks.blind.case import (
    FAR,
    HIDDEN,
    SEEN,
    Case,
    after_modulus,
    by_cause,
    is_wide,
    names_of,
    ordinary,
    strength,
    truncated,
)
from benchmarks.blind.frozen import FrozenCase
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.blend import Tangents
from dolfingrip.diagnosis.core.fitting import Hypotheses
from dolfingrip.diagnosis.core.problem import Key
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data import measurement
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.screening import analyse
from dolfingrip.diagnosis.simulation.point import Point
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.extensions.effect import Prior

COUNTS: Final[Mapping[str, Mapping[str, int]]] = {
    "development": {"one": 4, "with_outsider": 6, "outsider": 6, "nuisance": 6, "two": 4,
                    "none": 12},
    "confirmation": {"one": 12, "with_outsider": 14, "outsider": 14, "nuisance": 12, "two": 10,
                     "none": 100},
    "prior": {"prior": 70},
}  # fmt: skip
"""Cases of each protocol."""
SEEDS: Final = {"development": 101, "confirmation": 466920, "prior": 77}
"""Of the sets: one to mend the analyser on, one for figures alone, one from the priors."""

NUISANCES: Final = ("coupon_slack_mm", "coupon.gauge_length_mm", "modulus")
SLACK_STD_mm: Final = hidden_coupon.SLACK_mm * 0.5**0.5


Kept = dict[str, tuple[np.ndarray, list[Tangents]]]
"""Places and changes of the readings there, by cause, of the first places that were asked for."""


class Strength:
    """Counts what a cause changes, by hidden simulations alone.

    Args:
        protocol: of the coupons.
    """

    def __init__(self, protocol: hidden_coupon.Protocol) -> None:
        self._protocol = protocol
        self._quiet = self._readings(Truth())
        slack = (
            self._readings(Truth(slack_mm=hidden_coupon.SLACK_mm)) - self._quiet
        ) / hidden_coupon.SLACK_mm
        gauge = GAUGE_STD_mm / hidden_coupon.GAUGE_mm
        specimen = np.repeat(np.eye(protocol.specimens), np.count_nonzero(protocol.read), axis=1)
        self._told = {
            "coupon_slack_mm": [SLACK_STD_mm * slack],
            "coupon.gauge_length_mm": [self._readings(Truth(gauge=1 + gauge)) - self._quiet],
            "specimens": [
                *(hidden_coupon.SCALE * self._quiet * each for each in specimen),
                *(SLACK_STD_mm * slack * each for each in specimen),
            ],
        }
        self._noise = np.diag(hidden_coupon.NOISE_N**2 + (slack * hidden_coupon.NOISE_mm) ** 2)
        self._by_modulus = self._readings(Truth(modulus=1.05)) - self._quiet

    def _readings(self, truth: Truth) -> np.ndarray:
        rng = np.random.default_rng(0)
        return np.concatenate(
            hidden_coupon.measured(self._protocol, replace(truth, quiet=True), rng)
        )

    def of(self, truth: Truth, own: str = "") -> float:
        """Standard deviations that readings change by, after modulus, rig and specimens.

        Args:
            truth: what is hidden.
            own: a number of the rig that it is.
        """
        others = np.array(
            [c for key, each in self._told.items() for c in each if key != own or not own]
        )
        covariance = self._noise + others.T @ others
        return strength(self._readings(truth) - self._quiet, covariance, self._by_modulus)


class Remembering(CouponSimulation):
    """Coupons of one set-up on one way, of which each change is simulated once.

    Args:
        read: the measurement.
        config: the model.
        kept: what was simulated before; it grows.
    """

    def __init__(self, read: measurement.Measurement, config: Config, kept: Kept) -> None:
        super().__init__(read, config)
        self._kept = kept

    def tangents(
        self, causes: Sequence[Cause], zeta: np.ndarray, points: Sequence[Point]
    ) -> list[Tangents]:
        name = " ".join(cause.name for cause in causes)
        if any(point.moduli != 1.0 for point in points):
            return super().tangents(causes, zeta, points)
        if name in self._kept and np.array_equal(self._kept[name][0], zeta):
            return self._kept[name][1]
        found = super().tangents(causes, zeta, points)
        self._kept.setdefault(name, (zeta, found))
        return found


class Bench:
    """A protocol with the analyser's view of it without a cause, by which strengths are counted."""

    def __init__(self, name: str, scratch: Path) -> None:
        self.protocol = PROTOCOLS[name]
        self.kept: Kept = {}
        self.strength = Strength(self.protocol)
        self.config = Config()
        plain = hidden_coupon.measured(self.protocol, Truth(), np.random.default_rng(1))
        self.plain = self.analysed(hidden_coupon.write(self.protocol, plain, scratch / "plain"))
        self.quiet = np.concatenate(
            hidden_coupon.measured(self.protocol, Truth(quiet=True), np.random.default_rng(0))
        )
        self._lower = scipy.linalg.cholesky(self.plain.problem.covariance, lower=True)

    def analysed(self, file: Path) -> Analysis[CouponSimulation]:
        """Analyse a measurement by the whole catalogue, with what is known of others.

        Args:
            file: the CSV, with its TOML beside it.
        """
        read = measurement.read([file], self.config)
        simulation = Remembering(read, self.config, self.kept)
        return analyse(simulation, unknowns(read, self.config))

    def sigma(self, change: np.ndarray) -> float:
        """Length of a change of the readings after the modulus."""
        white, base = (
            scipy.linalg.solve_triangular(self._lower, each, lower=True)
            for each in (change, self.plain.problem.base)
        )
        return after_modulus(white, base)

    def usually_felt(self, name: str) -> bool:
        """Tell whether readings feel a cause within the ordinary part of its prior."""
        cause, problem, found = self.plain.causes[name], self.plain.problem, []
        for reach in (-Policy().reach, Policy().reach):
            ends = np.clip(reach, *cause.box().T)
            plain = np.zeros(problem.nuisance_count)
            change = problem.predicted((name,), np.r_[plain, ends]) - problem.base
            found.append(np.sqrt(np.square(change / self.plain.errors.noise).mean()))
        return max(found) >= Policy().invisible

    def unexplained(self, truth: Truth) -> float:
        """Length of what the best single cause leaves of readings without noise."""
        quiet = replace(truth, quiet=True)
        seen = np.concatenate(
            hidden_coupon.measured(self.protocol, quiet, np.random.default_rng(0))
        )
        case = replace(self.plain.problem, value=seen)
        names = [(name,) for name in self.plain.causes]
        hypotheses = Hypotheses(case, [(), *names])
        (zero,) = hypotheses.fits({((), 0.0): [np.zeros(case.nuisance_count)]})
        starts = dict[Key, list[np.ndarray]]()
        for name, cause in self.plain.causes.items():
            start = np.clip(np.zeros(len(cause.numbers)), *cause.box().T)
            moved = [np.r_[zero.zeta, start + move] for move in (-1.0, 0.0, 1.0)]
            starts[(name,), 0.0] = moved
        least = min(fit.misfit for fit in (zero, *hypotheses.fits(starts)))
        return float(np.sqrt(max(least, 0.0)))


def frozen(bench: Bench, case: Case[Truth]) -> FrozenCase:
    """Tell what is hidden in a case, with strengths by the hidden simulation."""
    truth, by = case.truth, bench.strength
    sigma = [by.of(Truth(each)) for each in by_cause(case, bench.plain.causes).values()]
    if truth.outsider[0]:
        sigma.append(by.of(Truth(outsider=truth.outsider)))
    if case.kind == "nuisance":
        modulus = case.names == ("modulus",)
        far = replace(truth, modulus=1.0, area=1.0)
        sigma = list(case.sigma) if modulus else [by.of(far, case.names[0])]
    numbers = {
        "modulus": truth.modulus * truth.area,
        "coupon_slack_mm": truth.slack_mm,
        "coupon.gauge_length_mm": hidden_coupon.GAUGE_mm * truth.gauge,
        **stiffened(truth.causes, truth.modulus),
    }
    left = case.sigma[0] if case.kind == "outsider" else None
    return FrozenCase(case.protocol, case.kind, case.number, case.wide, case.names,
                      *truth.outsider, tuple(sigma), left, numbers, case.seed)  # fmt: skip


def drawn(bench: Bench, which: str, kind: str, number: int) -> Case[Truth]:
    """A case of a set."""
    seed = (SEEDS[which], list(PROTOCOLS).index(bench.protocol.name), len(kind), number)
    return _drawn(bench, kind, number, seed)


def _drawn(bench: Bench, kind: str, number: int, seed: tuple[int, ...]) -> Case[Truth]:
    rng = np.random.default_rng(seed)
    wide = is_wide(kind, number)
    # by the analyser's priors each number is far from what was told, or is not
    chance = Policy().rare / (1 + Policy().rare) if kind == "prior" else 0.0
    far = tuple(name for name in NUISANCES if chance and rng.random() < chance)
    width = {
        name: Prior(0.0, 1.0, "as reported").wide if name in far else 1.0 for name in NUISANCES
    }
    modulus = width["modulus"] * float(rng.standard_normal())
    factor = float(np.exp(MODULUS * modulus))
    if kind == "prior":
        factor = float(bench.plain.problem.factor.at(modulus))
    slack, gauge = (width[name] * float(rng.standard_normal()) for name in NUISANCES[:2])
    truth = Truth(modulus=factor, slack_mm=SLACK_STD_mm * slack,
                  gauge=1 + GAUGE_STD_mm / hidden_coupon.GAUGE_mm * gauge)  # fmt: skip
    effects = tuple(filter(bench.usually_felt, bench.plain.causes))
    names: tuple[str, ...] = ()
    zeta: list[float] = []
    sigma: list[float] = []
    hidden = HIDDEN.get(kind, 0)
    if kind == "prior":
        hidden = int(rng.choice(3, p=Policy().prior_by_size))
        share = (1 - Policy().discrepancy_off) / len(Policy().discrepancy_levels)
        odds = [Policy().discrepancy_off, *[share] * len(Policy().discrepancy_levels)]
        level = float(rng.choice([0.0, *Policy().discrepancy_levels], p=odds))
        truth = replace(truth, discrepancy=level)
    for _ in range(1000):
        names = names_of(effects, hidden, rng)
        zeta, sigma, overrides = [], [], {}
        for name in names:
            cause = bench.plain.causes[name]
            by_prior = kind == "prior"  # else as strong as is usual
            wider = 2.0 if wide else 1.0
            if by_prior:
                tail = bench.plain.problem.tail((name,))
                width = np.where(rng.random(len(tail)) < Policy().rare, tail, 1.0)
                own = truncated(rng, cause.box(), width)
            else:
                own = ordinary(rng, cause, wider)
            plain = np.zeros(bench.plain.problem.nuisance_count)
            there = bench.plain.problem.predicted((name,), np.r_[plain, own])
            sigma.append(bench.sigma(there - bench.plain.problem.base))
            overrides |= cause.overrides(own)
            zeta += own.tolist()
        if kind == "prior" or min(sigma, default=SEEN) >= SEEN:
            truth = replace(truth, causes=overrides)
            break
    if kind in ("outsider", "with_outsider"):
        truth, left = _with_outsider(bench, truth, rng, alone=kind == "outsider")
        sigma.append(left)
    if kind == "nuisance":
        truth, names, one = _far(bench, truth, number, rng)
        sigma = [one]
    named = (*names, *far)
    return Case(
        bench.protocol.name, kind, number, wide, truth, named, tuple(zeta), tuple(sigma), seed
    )


def _with_outsider(
    bench: Bench, truth: Truth, rng: np.random.Generator, *, alone: bool
) -> tuple[Truth, float]:
    """An outsider of 6 σ and more: alone, of what the best single cause leaves of it."""
    for _ in range(200):
        name = str(rng.choice(list(OUTSIDERS)))
        strength = float(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))
        found = replace(truth, outsider=(name, strength))
        only = Truth(outsider=(name, strength), quiet=True)
        if alone:
            left = bench.unexplained(only)
        else:
            seen = hidden_coupon.measured(bench.protocol, only, np.random.default_rng(0))
            left = bench.sigma(np.concatenate(seen) - bench.quiet)
        if left >= SEEN:
            return found, left
    raise ValueError("no outsider is strong enough")


def _far(
    bench: Bench, truth: Truth, number: int, rng: np.random.Generator
) -> tuple[Truth, tuple[str, ...], float]:
    """A number of the rig 3 to 5 standard deviations from what was told."""
    name = NUISANCES[number % len(NUISANCES)]
    size = float(rng.uniform(*FAR) * rng.choice([-1, 1]))
    if name == "coupon_slack_mm":
        truth = replace(truth, slack_mm=SLACK_STD_mm * size)
    elif name == "modulus":
        truth = replace(truth, area=float(np.exp(MODULUS * size)), modulus=1.0)
    else:
        truth = replace(truth, gauge=1 + GAUGE_STD_mm / hidden_coupon.GAUGE_mm * size)
    quiet = replace(truth, quiet=True, area=1.0)
    seen = hidden_coupon.measured(bench.protocol, quiet, np.random.default_rng(0))
    return (
        truth,
        (name,),
        abs(size) if name == "modulus" else bench.sigma(np.concatenate(seen) - bench.quiet),
    )
