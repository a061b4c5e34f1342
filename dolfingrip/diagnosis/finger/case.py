"""A measurement of fingers as a case: emulators of the model and of all causes, and errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.answer.analysed import Analysed
from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core.case import Case
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.errors import errors
from dolfingrip.diagnosis.finger.first_pass import (
    first_pass,
    refine_until_consistent,
    truncate_before_failure,
)
from dolfingrip.diagnosis.finger.model import (
    fitted_moduli,
    fitted_walls,
    model_case,
    wall_std,
)
from dolfingrip.diagnosis.finger.simulation import FingerSimulation, not_reached, rough_simulation
from dolfingrip.diagnosis.finger.training import trained_causes
from dolfingrip.diagnosis.finger.unknowns import FAR, box_of, unknowns
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL, Nuisance
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.parameter import every
from dolfingrip.sections.section import Role


@dataclass(frozen=True, eq=False)
class FingerCase(Analysed[FingerSimulation]):
    """Fingers, coupons beside them, and what could explain their readings.

    Attributes:
        wall_std: relative standard deviation of the walls; 0 where they are a linear nuisance.
    """

    wall_std: float = 0.0

    def walls(self, zeta: float | np.ndarray) -> np.ndarray:
        """Thickness of the walls by that configured."""
        return np.asarray(1 + self.wall_std * np.asarray(zeta))

    def overrides(self, fit: Fit) -> dict[str, Any]:
        """Return the change of the configuration to a fit's numbers."""
        c = self.factor(fit)
        found = dict(self.simulation.moduli(c))
        if self.wall_std:
            key, wall_mm = self.wall()
            found[key] = wall_mm * float(self.walls(fit.zeta[1]))
        return found | self.at(fit, c)

    def wall(self) -> tuple[str, float]:
        """Key and value of the walls' thickness, as configured (mm)."""
        applied = self.simulation.applied
        return f"{applied.geometry_table}.wall_mm", applied.geometry.wall_mm

    def exact(self, fit: Fit) -> np.ndarray:
        """(n,) readings at a fit's numbers, linear nuisances left out."""
        return self.case.predicted(fit.subset, fit.zeta)

    def own(self) -> dict[str, tuple[Nuisance, float]]:
        """The finger's own numbers that are linear nuisances, with their unit of change, by key.

        They are what the laboratory told a deviation of by its key, such as a chamber's width.
        """
        config = self.simulation.config
        tests = [test.setup.applied(config) for test in self.simulation.measurement.tests]
        values = [
            {(p.key, p.value(own)) for p in every(own) if p.section.role is Role.BODY}
            for own in tests
        ]
        known = {key for key, _ in set.intersection(*values)}  # alike in all tests
        found = {}
        for each in self.errors.shared:
            key, std = each.name, each.std
            if key == WALL:
                key, wall_mm = self.wall()
                std *= wall_mm
            if key in known:
                found[key] = each, std
        return found

    def own_overrides(self, fit: Fit) -> Change:
        """Return the change of these numbers to a fit."""
        fitted, applied = self.nuisances(fit), self.simulation.applied
        known = {each.key: each.value(applied) for each in every(applied)}
        moved = known | self.overrides(fit)
        return {
            key: float(moved[key]) + std * fitted[each.name]
            for key, (each, std) in self.own().items()
        }

    def by_own(self, fit: Fit) -> np.ndarray:
        """(n,) what these change of the readings at a fit, linear in them."""
        fitted = self.nuisances(fit)
        found = np.zeros(len(self.case.value))
        for each, _ in self.own().values():
            found += fitted[each.name] * each.change
        return found

    def relinearised(self, fit: Fit, missed: np.ndarray) -> FingerCase:
        """With the finger's own numbers linear between their middle and a fit.

        Args:
            fit: where they are so far out that derivatives at their middle mislead.
            missed: (n,) exact readings there less linear ones. The number that changes most takes
                it over.
        """
        fitted = self.nuisances(fit)
        most = max(
            (each for each, _ in self.own().values()),
            key=lambda each: float(np.linalg.norm(fitted[each.name] * each.change)),
        )
        change = most.change + missed / fitted[most.name]
        more = np.outer(change, change) - np.outer(most.change, most.change)
        shared = tuple(replace(e, change=change) if e is most else e for e in self.errors.shared)
        off = replace(
            self.errors, shared=shared, fitted=self.errors.fitted + more,
            covariance=self.errors.covariance + more,
        )  # fmt: skip
        case = replace(self.case, covariance=self.case.covariance + more)
        return replace(self, errors=off, case=case)

    def nuisances(self, fit: Fit) -> dict[str, float]:
        """The most probable linear nuisances at a fit, by their standard deviations."""
        rest = self.case.value - self.case.predicted(fit.subset, fit.zeta)
        left = scipy.linalg.solve(self.case.covariance, rest, assume_a="pos")
        return {each.name: float(each.change @ left) for each in self.errors.shared}


def finger_case(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    names: Sequence[str] | None = None,
    say: Callable[[str], None] = lambda text: None,
    *,
    fully: bool = False,
) -> FingerCase:
    """Simulate the model and what causes change, and make emulators of it.

    Args:
        measurement: of fingers, and of coupons beside them.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        names: of the causes that are tried; the whole catalogue where None.
        say: told what is being done.
        fully: simulate every cause as far as one that the readings may have.

    Raises:
        ConfigError: one line, where nothing can be simulated.
    """
    simulation, off, plain = _model(measurement, config, workers, say)
    centre = simulation.centre
    causes = unknowns(simulation.measurement, _lab(simulation), names, walls=bool(simulation.walls))
    say(f"simulating what {len(causes)} causes change")
    middle = float(np.clip(np.log(centre) / plain.factor.std, *plain.ground_box[0]))
    trained = trained_causes(
        simulation, causes, off.noise, plain.factor, middle, plain, say, fully=fully
    )  # fmt: skip
    felt = {each.name: each for each in causes if each.name in trained.emulators}
    case = replace(
        plain, emulators={name: trained.emulators[name] for name in felt},
        boxes={name: box_of(each) for name, each in felt.items()},
        rig=frozenset(FAR) & frozenset(felt),
    )  # fmt: skip
    std = wall_std(simulation)
    return FingerCase(
        case, felt, off, simulation, trained.unseen, trained.failed, wall_std=std,
        not_reached=not_reached(
            measurement, simulation.measurement, simulation.base.readings,
            simulation.failures or simulation.base.failures,
        ),
    )  # fmt: skip


def _model(
    measurement: Measurement, config: Config, workers: Workers, say: Callable[[str], None]
) -> tuple[FingerSimulation, Errors, Case]:
    """The model without causes, simulated where its moduli and walls follow the readings."""
    rough, configured = first_pass(measurement, config, workers, say)
    for _ in range(POLICY.passes):
        say("simulating the measurement on a graded mesh")
        simulation = refine_until_consistent(rough, configured)
        off = errors(simulation)
        plain = model_case(simulation, off)
        while (walls := _beyond(simulation, plain)) is not None:
            say(f"the walls are about {walls:.2g} times as thick as configured; simulating there")
            simulation = simulation.with_walls(walls)
            plain = model_case(simulation, off)
        centre = fitted_moduli(plain, simulation.centre, POLICY.near_enough)
        if centre == simulation.centre:
            break
        say(f"the moduli are about {centre:.2g} times those configured; simulating there")
        rough = truncate_before_failure(
            rough_simulation(measurement, config, workers, simulation.flat, centre)
        )
    return simulation, off, plain


def _beyond(simulation: FingerSimulation, plain: Case) -> float | None:
    """Walls that the readings ask for beyond those that were simulated; None where they do not."""
    known = simulation.walls
    if not known:
        return None
    walls = fitted_walls(plain, wall_std(simulation))
    tried = simulation.tried_walls
    if min(known) <= walls <= max(known) or walls in tried or walls <= 0:
        return None
    return walls


def _lab(simulation: FingerSimulation) -> Config:
    applied = [t.setup.applied(simulation.config) for t in simulation.measurement.tests]
    return max(applied, key=lambda each: each.gravity.acceleration_m_s2)
