"""An analysis of fingers: emulators of the model and of all causes, and errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from dolfingrip.config import NO_CHANGE, Change, Config, ConfigError
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.core.problem import InferenceProblem
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.first_pass import (
    first_pass,
    refine_until_consistent,
    truncate_before_failure,
)
from dolfingrip.diagnosis.finger.model import (
    baseline_problem,
    errors,
    fitted_moduli,
    fitted_walls,
    wall_std,
)
from dolfingrip.diagnosis.finger.simulation import FingerSimulation, not_reached, rough_simulation
from dolfingrip.diagnosis.finger.training import trained_causes
from dolfingrip.diagnosis.finger.unknowns import IMPLAUSIBLE, box_of, unknowns
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL, Nuisance, by_log_modulus, modulus_keys
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, simulate
from dolfingrip.parameter import every
from dolfingrip.sections.section import Role


def simulated(
    finger: FingerAnalysis,
    fit: MapFit,
    measurement: Measurement,
    mesh: Change = NO_CHANGE,
    *,
    rig: bool = True,
) -> tuple[np.ndarray, np.ndarray]:
    """Readings, (n,), and their derivatives by ζ, (n, d); linear nuisances are left out.

    Args:
        finger: whose causes and moduli these are.
        fit: the hypothesis.
        measurement: whose protocols are followed.
        mesh: changes to the mesh.
        rig: whether numbers of the rig that are far out are so here, too.

    Raises:
        ConfigError: one line, where the simulation does not reach all readings.
    """
    problem = finger.problem
    numbers = [
        (number, place)
        for name, places in problem.places(fit.subset).items()
        for number, place in zip(finger.causes[name].numbers, places, strict=True)
        if rig or name not in IMPLAUSIBLE
    ]
    overrides = {k: v for k, v in finger.overrides(fit).items() if rig or not _of_rig(k)}
    gradients = [number.gradient for number, _ in numbers]
    every = [*gradients, *modulus_keys(finger.simulation.applied)]
    if finger.wall_std:
        every.append(finger.wall()[0])
    wanted = ModelVariant({**mesh, **overrides}, tuple(every))
    (run,) = simulate(measurement, finger.simulation.config, [wanted], finger.simulation.workers)
    if not np.isfinite(run.readings).all():
        why = "; ".join(each.sentence for each in run.failures) or "no reading"
        raise ConfigError(f"{' with '.join(fit.subset) or 'the model'}: {why}")
    none = np.zeros(len(run.readings))
    slopes = np.zeros((len(run.readings), len(fit.zeta)))
    c = finger.factor(fit)
    by_log = by_log_modulus(measurement, run)
    for (number, place), key in zip(numbers, gradients, strict=True):
        slope = run.slopes.get(key, none)
        if number.modulus:
            slope = slope * c
            by_log = by_log + slope * float(number.at(fit.zeta[place]))
        slopes[:, place] = slope * number.prior.slope(float(fit.zeta[place]))
    slopes[:, 0] = by_log * problem.factor.std
    if finger.wall_std:
        key, wall_mm = finger.wall()
        slopes[:, 1] = run.slopes.get(key, none) * wall_mm * finger.wall_std
    return run.readings, slopes


def _of_rig(key: str) -> bool:
    return any(key.startswith(f"extensions.{name}.") for name in IMPLAUSIBLE)


@dataclass(frozen=True, eq=False)
class FingerAnalysis(Analysis[FingerSimulation]):
    """Fingers, coupons beside them, and what could explain their readings.

    Attributes:
        wall_std: relative standard deviation of the walls; 0 where they are a linear nuisance.
    """

    wall_std: float = 0.0

    def walls(self, zeta: float | np.ndarray) -> np.ndarray:
        """Thickness of the walls by that configured."""
        return np.asarray(1 + self.wall_std * np.asarray(zeta))

    def overrides(self, fit: MapFit) -> dict[str, Any]:
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

    def exact(self, fit: MapFit) -> np.ndarray:
        """(n,) readings at a fit's numbers, linear nuisances left out."""
        return self.problem.predicted(fit.subset, fit.zeta)

    def nuisance_parameters(self) -> dict[str, tuple[Nuisance, float]]:
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

    def nuisance_overrides(self, fit: MapFit) -> Change:
        """Return the change of these numbers to a fit."""
        fitted, applied = self.nuisances(fit), self.simulation.applied
        known = {each.key: each.value(applied) for each in every(applied)}
        moved = known | self.overrides(fit)
        return {
            key: float(moved[key]) + std * fitted[each.name]
            for key, (each, std) in self.nuisance_parameters().items()
        }

    def nuisance_change(self, fit: MapFit) -> np.ndarray:
        """(n,) what these change of the readings at a fit, linear in them."""
        fitted = self.nuisances(fit)
        found = np.zeros(len(self.problem.value))
        for each, _ in self.nuisance_parameters().values():
            found += fitted[each.name] * each.change
        return found

    def relinearised(self, fit: MapFit, missed: np.ndarray) -> FingerAnalysis:
        """With the finger's own numbers linear between their middle and a fit.

        Args:
            fit: where they are so far out that derivatives at their middle mislead.
            missed: (n,) exact readings there less linear ones. The number that changes most takes
                it over.
        """
        fitted = self.nuisances(fit)
        most = max(
            (each for each, _ in self.nuisance_parameters().values()),
            key=lambda each: float(np.linalg.norm(fitted[each.name] * each.change)),
        )
        change = most.change + missed / fitted[most.name]
        more = np.outer(change, change) - np.outer(most.change, most.change)
        shared = tuple(replace(e, change=change) if e is most else e for e in self.errors.shared)
        off = replace(
            self.errors, shared=shared, fitted=self.errors.fitted + more,
            covariance=self.errors.covariance + more,
        )  # fmt: skip
        problem = replace(self.problem, covariance=self.problem.covariance + more)
        return replace(self, errors=off, problem=problem)

    def nuisances(self, fit: MapFit) -> dict[str, float]:
        """The most probable linear nuisances at a fit, by their standard deviations."""
        rest = self.problem.value - self.problem.predicted(fit.subset, fit.zeta)
        left = scipy.linalg.solve(self.problem.covariance, rest, assume_a="pos")
        return {each.name: float(each.change @ left) for each in self.errors.shared}


def analyse_fingers(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    names: Sequence[str] | None = None,
    say: Callable[[str], None] = lambda text: None,
    *,
    fully: bool = False,
) -> FingerAnalysis:
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
    causes = unknowns(simulation.measurement, simulation.lab, names, walls=bool(simulation.walls))
    say(f"simulating what {len(causes)} causes change")
    middle = float(np.clip(np.log(centre) / plain.factor.std, *plain.baseline_box[0]))
    trained = trained_causes(
        simulation, causes, off.noise, plain.factor, middle, plain, say, fully=fully
    )  # fmt: skip
    felt = {each.name: each for each in causes if each.name in trained.emulators}
    problem = replace(
        plain, emulators={name: trained.emulators[name] for name in felt},
        boxes={name: box_of(each) for name, each in felt.items()},
        rig=frozenset(IMPLAUSIBLE) & frozenset(felt),
    )  # fmt: skip
    std = wall_std(simulation)
    return FingerAnalysis(
        problem, felt, off, simulation, trained.unseen, trained.failed, wall_std=std,
        not_reached=not_reached(
            measurement, simulation.measurement, simulation.base.readings,
            simulation.failures or simulation.base.failures,
        ),
    )  # fmt: skip


def _model(
    measurement: Measurement, config: Config, workers: Workers, say: Callable[[str], None]
) -> tuple[FingerSimulation, Errors, InferenceProblem]:
    """The model without causes, simulated where its moduli and walls follow the readings."""
    rough, configured = first_pass(measurement, config, workers, say)
    for _ in range(POLICY.passes):
        say("simulating the measurement on a graded mesh")
        simulation = refine_until_consistent(rough, configured)
        off = errors(simulation)
        plain = baseline_problem(simulation, off)
        while (walls := _beyond(simulation, plain)) is not None:
            say(f"the walls are about {walls:.2g} times as thick as configured; simulating there")
            simulation = simulation.with_walls(walls)
            plain = baseline_problem(simulation, off)
        centre = fitted_moduli(plain, simulation.centre, POLICY.near_enough)
        if centre == simulation.centre:
            break
        say(f"the moduli are about {centre:.2g} times those configured; simulating there")
        rough = truncate_before_failure(
            rough_simulation(measurement, config, workers, simulation.flat, centre)
        )
    return simulation, off, plain


def _beyond(simulation: FingerSimulation, plain: InferenceProblem) -> float | None:
    """Walls that the readings ask for beyond those that were simulated; None where they do not."""
    known = simulation.walls
    if not known:
        return None
    walls = fitted_walls(plain, wall_std(simulation))
    tried = simulation.tried_walls
    if min(known) <= walls <= max(known) or walls in tried or walls <= 0:
        return None
    return walls
