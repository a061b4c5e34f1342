"""A measurement of fingers as a case: emulators of the model and of all causes, and errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from dolfingrip.config import Config
from dolfingrip.diagnosis.core import discrepancy
from dolfingrip.diagnosis.core.curved import Coordinate, Simulations, trained_on
from dolfingrip.diagnosis.core.emulator import Mended
from dolfingrip.diagnosis.core.evidence import Case, Fit, Level
from dolfingrip.diagnosis.core.numbers import Cause
from dolfingrip.diagnosis.core.search import NONE, levels
from dolfingrip.diagnosis.coupon.covariance import CouponErrors
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.errors import errors
from dolfingrip.diagnosis.finger.simulation import (
    FingerSimulation,
    finger_simulation,
    same_material,
)
from dolfingrip.diagnosis.finger.training import overrides_at, trained_causes
from dolfingrip.diagnosis.finger.unknowns import FAR, WALLS, box_of, unknowns
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.walls import PART

BY_WALLS: tuple[float, ...] = (-1.0, 0.0, 1.0)
"""Walls that the base emulator is read at, by the change that was simulated."""


@dataclass(frozen=True, eq=False)
class FingerCase:
    """Everything that the inference needs of fingers.

    Attributes:
        case: readings, emulators and covariance.
        causes: by name.
        errors: what the covariance is made of.
        simulation: of the model.
        unseen: causes that no reading feels.
        failed: why others could not be simulated, by name.
        wall_std: relative standard deviation of the walls; 0 where they are a linear nuisance.
    """

    case: Case
    causes: dict[str, Cause]
    errors: CouponErrors
    simulation: FingerSimulation
    unseen: tuple[str, ...]
    failed: dict[str, str]
    wall_std: float

    def factor(self, fit: Fit) -> float:
        """Of all moduli, by those configured."""
        return float(self.case.factor(fit.zeta[0])[0])

    def walls(self, zeta: float | np.ndarray) -> np.ndarray:
        """Thickness of the walls by that configured."""
        return np.asarray(1 + self.wall_std * far(zeta))

    def overrides(self, fit: Fit) -> tuple[str, ...]:
        """The configuration at a fit's numbers, as with ``--set``."""
        c = self.factor(fit)
        found = [*self.simulation.moduli(c)]
        if self.wall_std:
            key, wall_mm = self.wall()
            found.append(f"{key}={wall_mm * float(self.walls(fit.zeta[1]))!r}")
        at = self.case.own
        for name in fit.subset:
            d = len(self.case.boxes[name])
            found += overrides_at(self.causes[name], fit.zeta[at : at + d], c)
            at += d
        return tuple(found)

    def wall(self) -> tuple[str, float]:
        """Key and value of the walls' thickness, as configured (mm)."""
        applied = self.simulation.applied
        return f"{applied.geometry_table}.wall_mm", applied.geometry.wall_mm

    def exact(self, fit: Fit) -> np.ndarray:
        """(n,) readings at a fit's numbers, linear nuisances left out."""
        return self.case.predicted(fit.subset, fit.zeta)

    def nuisances(self, fit: Fit) -> dict[str, float]:
        """The most probable linear nuisances at a fit, by their standard deviations."""
        rest = self.case.value - self.case.predicted(fit.subset, fit.zeta)
        left = scipy.linalg.solve(self.case.covariance, rest, assume_a="pos")
        return {each.name: float(each.change @ left) for each in self.errors.shared}

    def corrected(self, fit: Fit, missed: np.ndarray) -> FingerCase:
        """With what an exact simulation differs by from the emulators at a fit.

        The strongest cause's emulator takes it over, or the model's own where there is none; all
        that act there are surer near it.

        Args:
            fit: of a cause, or of several.
            missed: exact less emulated readings and their derivatives by ζ, shape (n, 1 + d).
        """
        takes = tuple(range(self.case.own))
        if not fit.subset:
            assert self.case.ground is not None
            every = np.arange(self.case.own)
            mended = Mended.of(
                self.case.ground, every, takes, fit.zeta, missed, POLICY.mended_length, 1.0
            )
            return replace(self, case=replace(self.case, ground=mended))
        strongest = max(zip(fit.strengths, fit.subset, strict=True))[1]
        emulators = dict(self.case.emulators)
        at = self.case.own
        for name in fit.subset:
            d = len(self.case.boxes[name])
            old = emulators[name]
            if name != strongest:
                emulators[name] = replace(old, errors=POLICY.surer * old.errors)
            else:
                own = np.r_[np.array(takes, int), np.arange(at, at + d)]
                inside = np.r_[np.array(old.takes, int), len(takes) + np.arange(d)]
                emulators[name] = Mended.of(
                    old, inside, takes, fit.zeta[own], missed[:, np.r_[0, 1 + own]],
                    POLICY.mended_length, POLICY.surer,
                )  # fmt: skip
            at += d
        return replace(self, case=replace(self.case, emulators=emulators))


def finger_case(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    names: Sequence[str] | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> FingerCase:
    """Simulate the model and what every cause changes, and make emulators of it.

    Args:
        measurement: of fingers, and of coupons beside them.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        names: of the causes that are tried; the whole catalogue where None.
        say: told what is being done.

    Raises:
        ConfigError: one line, where nothing can be simulated.
    """
    say("simulating the measurement as configured")
    simulation = finger_simulation(measurement, config, workers)
    off = errors(simulation)
    plain = _base(simulation, off)
    centre = _centre(plain)
    if centre != 1.0:
        say(f"the moduli are about {centre:.2g} times those configured; simulating there")
        simulation = finger_simulation(measurement, config, workers, centre)
        off = errors(simulation)
        plain = _base(simulation, off)
    walls = simulation.walls is not None
    causes = unknowns(simulation.measurement, _lab(simulation), names, walls=walls)
    say(f"simulating what {len(causes)} causes change")
    box = plain.ground_box[0]
    grid = np.linspace(float(box[0]), float(box[1]), 401)
    middle = float(np.interp(np.log(centre), np.log(plain.factor(grid)[0]), grid))
    trained = trained_causes(
        simulation, causes, off.noise, lambda z: plain.factor(z)[0], middle, box
    )
    felt = {each.name: each for each in causes if each.name in trained.emulators}
    case = replace(
        plain, emulators={name: trained.emulators[name] for name in felt},
        boxes={name: box_of(each) for name, each in felt.items()},
        rig=frozenset(FAR) & frozenset(felt),
    )  # fmt: skip
    std = _wall_std(simulation)
    return FingerCase(case, felt, off, simulation, trained.unseen, trained.failed, std)


def far(zeta: float | np.ndarray) -> np.ndarray:
    """Standard deviations that the walls are off by; far out they lose less than a normal one."""
    return np.asarray(np.sinh(POLICY.tail * np.asarray(zeta)) / POLICY.tail)


def near(off: np.ndarray) -> np.ndarray:
    """ζ of so many standard deviations."""
    return np.asarray(np.arcsinh(POLICY.tail * off) / POLICY.tail)


def _lab(simulation: FingerSimulation) -> Config:
    applied = [t.setup.applied(simulation.config) for t in simulation.measurement.tests]
    return max(applied, key=lambda each: each.gravity.acceleration_m_s2)


def _centre(plain: Case) -> float:
    """The fitted factor of all moduli, under whichever discrepancy the model without causes needs.

    In few steps, so that another measurement of the finger finds its simulations.
    """
    rest = np.zeros(plain.own - 1)
    starts = [np.r_[start, rest] for start in POLICY.starts]
    fits = [Level(plain, level).of(NONE).fit(starts) for level in levels()]
    best = max(fits, key=lambda fit: fit.log_evidence)
    factor = float(plain.factor(best.zeta[0])[0])
    step = np.log(POLICY.recentred)
    return float(np.exp(step * np.round(np.log(factor) / step)))


def _wall_std(simulation: FingerSimulation) -> float:
    if simulation.walls is None:
        return 0.0
    return min(t.setup.nuisances[WALL] for t in simulation.measurement.tests)


def _base(simulation: FingerSimulation, off: CouponErrors) -> Case:
    """The case without causes: its ground is the model at any moduli and walls."""
    measurement = simulation.measurement
    listed = measurement.listed()
    n = len(listed)
    std = max(t.setup.nuisances["modulus"] for t in measurement.tests)
    free = same_material(measurement, simulation.config) and std > 0
    std = std if free else 1e-6
    at = np.arcsinh(POLICY.tail * np.log(POLICY.stiffest) / std) / POLICY.tail
    box = np.array([[-at, at]]) if free else np.array([[-1.0, 1.0]])
    case = Case(
        listed["value"].to_numpy(), simulation.base.readings, np.zeros(n, bool), std, {},
        off.covariance, discrepancy.kernel(off.along), {}, ground_box=box,
    )  # fmt: skip
    nodes = np.linspace(float(box[0, 0]), float(box[0, 1]), POLICY.nodes)
    factors = case.factor(nodes)[0]
    wall_std = _wall_std(simulation)
    walls = np.array(BY_WALLS) * PART if wall_std else np.zeros(1)
    values = []
    for c in factors:
        here = simulation.base_at(float(c))
        told = [here if not w or simulation.walls is None
                else here + simulation.walls.change(1 + w, float(c))[0] for w in walls]  # fmt: skip
        values.append([np.nan_to_num(each - simulation.base.readings) for each in told])
    told_values = np.array(values)
    zeta = near(walls / wall_std)[:, None] if wall_std else np.zeros((1, 0))
    slopes = np.zeros((len(nodes), len(zeta), zeta.shape[1], n))
    if wall_std:
        slopes[:] = np.nan
    own = [Coordinate(far, amplitude=False)] if wall_std else []
    every = Simulations(zeta, told_values, slopes, nodes)
    takes = tuple(range(1 + len(own)))
    ground = trained_on(every, own, off.noise, takes, exact=True)
    if wall_std:
        end = float(near(np.array(POLICY.walls_reach)))
        box = np.vstack([box, [[-end, end]]])
    names = (("modulus",), (WALLS,))[: len(box)]
    return replace(case, ground=ground, ground_box=box, ground_names=names)
