"""Hidden causes of each case, their strengths, and their diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from support.stiffened import stiffened

from benchmarks.blind import said
from benchmarks.blind.case import (
    FAR,
    HIDDEN,
    SEEN,
    Case,
    by_cause,
    is_wide,
    names_of,
    ordinary,
    strength,
    truncated,
)
from benchmarks.blind.fingers import finger
from benchmarks.blind.fingers.finger import MODULUS, PROTOCOLS, Truth
from benchmarks.blind.fingers.outsiders import OUTSIDERS
from benchmarks.blind.frozen import FrozenCase
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.core.unknown import causes
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.extensions.index import camera_errors
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool

COUNTS: Final[Mapping[str, Mapping[str, int]]] = {
    "development": {"one": 3, "with_outsider": 3, "outsider": 3, "nuisance": 5, "two": 2,
                    "none": 4},
    "confirmation": {"one": 12, "with_outsider": 12, "outsider": 12, "nuisance": 10, "two": 6,
                     "none": 20},
}  # fmt: skip
"""Cases of each protocol."""
SEEDS: Final = {"development": 101, "confirmation": 662607}
"""Of the sets: one to mend the analyser on, one for figures alone."""

NUISANCES: Final = ("pressure_gain", "pressure_offset", "plate_gap", "wall_offset", "modulus")
WIDEST: Final = 2.0
"""Standard deviations at which nuisances that are not far out are cut off."""
REACH: Final = 2.5
"""Largest |ζ| of a cause's number."""
STRENGTHS: Final = (0.3, 3.0)
"""Of outsiders, by the ordinary ones."""
TRIES: Final = 300


class Bench:
    """A protocol with its simulations.

    Args:
        protocol: of the tests.
        scratch: folder of measurements and simulations.
        workers: processes.
        effects: that are hidden and tried; the whole catalogue where None.
    """

    def __init__(
        self,
        protocol: finger.Protocol,
        scratch: Path,
        workers: int = 2,
        effects: Sequence[str] | None = None,
    ) -> None:
        self.protocol = protocol
        self.coarse = replace(self.protocol, mesh=self.protocol.strength_mesh)
        self.scratch = scratch
        self.effects = effects
        where = Where(workers=workers)
        # a case is drawn up to TRIES times: its processes start once, and end with Python's
        self.workers = Workers(scratch / "generator", where, kept=Pool(where))
        # no camera is told, and without one its errors are those of the angle's own instrument
        of_cameras = {cls.name() for cls in camera_errors()}
        self.causes = {
            cause.name: cause for cause in causes(self.protocol.analysed(), effects)
            if cause.name not in of_cameras
        }  # fmt: skip
        self.plain = self.readings(Truth())
        self.by_modulus = self.readings(Truth(modulus=1.05)) - self.plain
        told = [self.readings(Truth(far={name: 1.0})) - self.plain for name in NUISANCES[:-1]]
        self.told = np.column_stack(told)

    def readings(self, truth: Truth) -> np.ndarray:
        """Readings (n,) without noise, by its standard deviation, on the mesh of strengths."""
        return finger.flat(self.coarse, finger.measured(self.coarse, truth, self.workers))

    def sigma(self, truth: Truth, own: str = "") -> float:
        """Length of what is changed after the modulus and what nuisances may change.

        Args:
            truth: what is hidden.
            own: a nuisance that it is.

        Returns:
            Standard deviations; 0 where it cannot be simulated.
        """
        try:
            change = self.readings(truth) - self.plain
        except (ValueError, ConfigError):
            return 0.0
        return self.strength(change, own)

    def strength(self, change: np.ndarray, own: str = "") -> float:
        """Length of a change after the modulus and what nuisances may change.

        Args:
            change: of the readings by their noise, in the order of :func:`finger.flat`, shape (n,).
            own: a nuisance that it is of.

        Returns:
            Standard deviations.
        """
        others = self.told[:, [name != own for name in NUISANCES[:-1]]]
        return strength(change, np.eye(len(change)) + others @ others.T, self.by_modulus)

    def strength_of(self, name: str, zeta: np.ndarray) -> float:
        """Length of what a cause changes after the modulus and what nuisances may change.

        Args:
            name: of the cause.
            zeta: its numbers, shape (d,).

        Returns:
            Standard deviations, by a simulation of the hidden finger.
        """
        return self.sigma(Truth(self.causes[name].overrides(zeta)))


def drawn(bench: Bench, which: str, kind: str, number: int) -> Case[Truth]:
    """A case of a set."""
    seed = (SEEDS[which], list(PROTOCOLS).index(bench.protocol.name), len(kind), number)
    return drawn_from(bench, seed, kind, number)


def drawn_from(
    bench: Bench, seed: tuple[int, ...], kind: str, number: int, least: float = SEEN
) -> Case[Truth]:
    """A case, drawn again until what is hidden is seen, and can be simulated.

    Args:
        bench: simulates the hidden finger.
        seed: of the draw.
        kind, number: of the case.
        least: standard deviations from which on something is seen.

    Raises:
        ValueError: where nothing is seen in :data:`TRIES` draws.
    """
    rng = np.random.default_rng(seed)
    wide = is_wide(kind, number)
    for _ in range(TRIES):
        truth = Truth(modulus=float(np.exp(MODULUS * _within(rng))),
                      far={name: _within(rng) for name in NUISANCES[:-1]})  # fmt: skip
        names = names_of(tuple(bench.causes), HIDDEN.get(kind, 0), rng)
        zeta, sigma = [], []
        for name in names:
            cause = bench.causes[name]
            own = ordinary(rng, cause, 2.0 if wide else 1.0, REACH)
            sigma.append(bench.strength_of(name, own))
            truth = replace(truth, causes={**truth.causes, **cause.overrides(own)})
            zeta += own.tolist()
            if sigma[-1] < least:
                break
        if min(sigma, default=least) < least:
            continue
        if kind in ("outsider", "with_outsider"):
            size = float(np.exp(rng.uniform(*np.log(STRENGTHS))))
            truth = replace(truth, outsider=(str(rng.choice(list(OUTSIDERS))), size))
            alone = bench.sigma(Truth(outsider=truth.outsider))
            if alone < least:
                continue
            # alone it counts by what the best cause of the catalogue leaves, known afterwards
            sigma = [*sigma, alone] if names else []
        if kind == "nuisance":
            names = (NUISANCES[number % len(NUISANCES)],)
            truth, alone, size = _far(truth, names[0], rng)
            sigma = [abs(size) if names[0] == "modulus" else bench.sigma(alone, names[0])]
        try:
            finger.measured(bench.protocol, truth, bench.workers)
        except (ValueError, ConfigError):
            continue
        return Case(
            bench.protocol.name, kind, number, wide, truth, names, tuple(zeta), tuple(sigma), seed
        )
    raise ValueError(f"{bench.protocol.name}, {kind} {number}: nothing that is seen in {TRIES}")


def _within(rng: np.random.Generator) -> float:
    """A standard normal number that is cut off."""
    return float(truncated(rng, np.array([[-WIDEST, WIDEST]]), 1.0)[0])


def _far(truth: Truth, name: str, rng: np.random.Generator) -> tuple[Truth, Truth, float]:
    """With a nuisance 3 to 5 standard deviations from what was told; it alone; and how far."""
    size = float(rng.uniform(*FAR) * rng.choice([-1, 1]))
    if name == "modulus":
        modulus = float(np.exp(MODULUS * size))
        return replace(truth, modulus=modulus), Truth(modulus=modulus), size
    if name == "plate_gap":  # nearer it would touch
        size = abs(size)
    own = {name: size}
    return replace(truth, far=truth.far | own), Truth(far=own), size


def measured(bench: Bench, case: Case[Truth]) -> Path:
    """Measure a case and write it."""
    true = finger.measured(bench.protocol, case.truth, bench.workers)
    readings = finger.scattered(bench.protocol, true, np.random.default_rng((*case.seed, 1)))
    folder = bench.scratch / f"{case.kind}-{case.number}"
    return finger.write(bench.protocol, readings, folder)


def frozen(bench: Bench, case: Case[Truth]) -> FrozenCase:
    """Tell what is hidden in a case, with strengths by the hidden simulation."""
    truth = case.truth
    alone = by_cause(case, bench.causes)
    sigma = [bench.sigma(Truth(each)) for each in alone.values()]
    if truth.outsider[0]:
        sigma.append(bench.sigma(Truth(outsider=truth.outsider)))
    if case.kind == "nuisance":
        sigma = list(case.sigma)
    config = finger.configured(bench.protocol, truth)
    numbers = {
        "modulus": truth.modulus,
        "finger.wall_mm": config.finger.wall_mm,
        "plate.gap_mm": config.plate.gap_mm,
        "extensions.pressure_gain.gain": config.extensions.pressure_gain.gain,
        "extensions.pressure_offset.offset_kPa": config.extensions.pressure_offset.offset_kPa,
        **stiffened(truth.causes, truth.modulus),
    }
    return FrozenCase(case.protocol, case.kind, case.number, case.wide, case.names,
                      *truth.outsider, tuple(sigma), _left(case), numbers, case.seed)  # fmt: skip


def _left(case: Case[Truth]) -> float | None:
    """Standard deviations that the best single cause leaves of an outsider, by its diagnosis."""
    if case.kind != "outsider":
        return None
    scored = Path(__file__).with_name("scored") / f"confirmation-{case.protocol}.csv"
    own = [
        float(row["sigma"])
        for row in said.rows(scored)
        if row["kind"] == "outsider" and int(row["number"]) == case.number
    ]
    return own[0] if own else None


def diagnosed(bench: Bench, case: Case[Truth]) -> Diagnosis:
    """A case is measured, written, read, and diagnosed up to its verdict."""
    folder, file = bench.scratch / f"{case.kind}-{case.number}", measured(bench, case)
    how = DiagnosisSettings(
        bench.workers.where.workers, bench.scratch / "analyser", effects=bench.effects
    )
    return diagnose([file], bench.protocol.analysed(), folder, how)


def bench(
    protocol: str, scratch: Path, workers: int = 2, effects: Sequence[str] | None = None
) -> said.Bench[Case[Truth]]:
    """A protocol's cases; measurements and simulations are kept in ``scratch``."""
    own = Bench(PROTOCOLS[protocol], scratch, workers, effects)
    return said.Bench(partial(drawn, own), partial(diagnosed, own),
                      measured=partial(measured, own), frozen=partial(frozen, own))  # fmt: skip
