"""An analysis: readings with all that could explain them, and what they do not tell."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import scipy.linalg

from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.answer.artefacts import Artefact, possible_artefacts
from dolfingrip.diagnosis.answer.errors import Errors, without_memory
from dolfingrip.diagnosis.answer.specimens import Apart, Individual, apart
from dolfingrip.diagnosis.core.evidence import (
    LEVELS,
    NONE,
    InferenceProblem,
    MapFit,
    Subset,
    Visibility,
    taken,
)
from dolfingrip.diagnosis.core.search import ModelPosterior, pursued
from dolfingrip.diagnosis.core.unknown import MODULUS, Cause, Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion, shows_memory
from dolfingrip.diagnosis.policy import ADDITIONS, POLICY
from dolfingrip.diagnosis.simulation.simulated import Simulator, scaled_moduli
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.extensions.index import NAMES, effect
from dolfingrip.jobs.run import Say
from dolfingrip.parameter.nuisances import WALL, wall


@dataclass(frozen=True, eq=False)
class Analysis[S: Simulator](ABC):
    """Everything that the inference needs of coupons, or of fingers.

    Attributes:
        problem: readings, emulators and covariance.
        causes: by name; of coupons numbers of the rig, too, which are no effects.
        errors: what the covariance is made of.
        simulation: of the model.
        unseen: causes that no reading feels.
        failed: why others could not be simulated, by name.
        not_reached: tests with readings that the model does not reach, and why.
    """

    problem: InferenceProblem
    causes: dict[str, Cause]
    errors: Errors
    simulation: S
    unseen: Sequence[str]
    failed: Mapping[str, str] = field(default_factory=dict)
    not_reached: Sequence[str] = ()

    @property
    def closed_form(self) -> bool:
        """Tell whether simulations cost nothing."""
        return self.simulation.closed_form

    @property
    def configured(self) -> np.ndarray:
        """(n,) readings of the model as configured; NaN where it does not come so far."""
        return self.simulation.configured

    @property
    def measurement(self) -> Measurement:
        """The readings, and how they were taken."""
        return self.simulation.measurement

    @property
    def scaled(self) -> np.ndarray:
        """(n,) whether a reading is proportional to the moduli."""
        return in_proportion(self.measurement)

    @property
    def effects(self) -> dict[str, Cause]:
        """Causes that are no numbers of the rig."""
        return {name: one for name, one in self.causes.items() if name not in self.problem.rig}

    @property
    def applied(self) -> Config:
        """Configuration of the first test's set-up; its material is that of all."""
        return self.measurement.tests[0].applied(self.simulation.config)

    @property
    def mesh_errors(self) -> dict[str, float]:
        """Root mean square of what the mesh gets wrong, by channel; empty where it is not known."""
        error, channels = self.simulation.mesh, self.measurement.channels()
        rms = {name: np.sqrt(np.mean(error[own] ** 2)) for name, own in channels.items()}
        return {name: float(each) for name, each in rms.items() if each}

    def judged_by_shape(self) -> Self:
        """With curves that causes with memory have to do better than, where these have rivals."""
        remembering = told_by_shape(self.causes, self.measurement)
        if not remembering:
            return self
        curves = without_memory(self.measurement, self.errors)
        return replace(self, problem=replace(self.problem, remembering=remembering, curves=curves))

    def specimens_apart(self) -> Apart | None:
        """Find specimens that stand apart from the others, by some of the readings.

        Returns:
            None where none does, or where too few specimens could tell.
        """
        errors = self.errors
        if not errors.scatter.estimated:
            return None
        every = Individual(self.measurement, errors.covariance, errors.along, errors.signal)
        alike = errors.covariance - every.apart(errors.scatter.scale, errors.scatter.shape)
        some = np.arange(0, len(errors.signal), -(-len(errors.signal) // POLICY.some))
        return apart(Individual(self.measurement, alike, errors.along, errors.signal, some))

    # -- artefacts of instruments -----------------------------------------------------------------

    def artefacts(self, posterior: ModelPosterior) -> list[Artefact]:
        """Find those that the evidence asks for beside some hypothesis.

        Args:
            posterior: of all hypotheses without them.
        """
        have = {each.kind for each in self.errors.artefacts}
        along, steep = self.errors.along, self.errors.steep
        every = possible_artefacts(self.measurement, along, steep, have)
        changes = np.array([each.nuisance.change for each in every])
        columns = changes.reshape(len(every), len(self.errors.noise)).T
        log_prior = np.array([each.log_prior for each in every])
        of = np.unique([each.kind for each in every], return_inverse=True)[1]
        return [every[place] for place in pursued(posterior, columns, log_prior, of)]

    def beside(self, found: Sequence[Artefact]) -> Self:
        """Return the analysis of readings that have some artefacts.

        Args:
            found: these.
        """
        errors = self.errors.beside(found)
        problem = replace(self.problem, covariance=errors.covariance)
        return replace(self, errors=errors, problem=problem)

    # -- a fit as a configuration -----------------------------------------------------------------

    def factor(self, fit: MapFit) -> float:
        """Return the factor of all moduli, by those configured."""
        return float(self.problem.factor.at(fit.zeta[0]))

    def numbers(self, fit: MapFit) -> Iterator[tuple[Cause, Unknown, int]]:
        """Iterate over the numbers of a fit's causes: cause, number, and which of ζ it is."""
        for name, places in self.problem.places(fit.subset).items():
            for number, place in zip(self.causes[name].numbers, places, strict=True):
                yield self.causes[name], number, int(place)

    def overrides(self, fit: MapFit, *, rig: bool = True) -> Change:
        """Return the change of the configuration to the numbers that every simulation is of.

        Args:
            fit: the hypothesis.
            rig: whether numbers of the rig that are far out are so there, too.
        """
        c = self.factor(fit)
        found = dict(scaled_moduli(self.applied, c)) if c != 1.0 else {}
        for number, zeta in zip(self.problem.always[1:], fit.zeta[1:], strict=False):
            found[number.key] = float(number.at(zeta)) * (c if number.modulus else 1.0)
        for name, places in self.problem.places(fit.subset).items():
            if name in NAMES and (rig or name not in self.problem.rig):
                found |= self.causes[name].overrides(fit.zeta[places], c)
        return found

    # -- what is linear ---------------------------------------------------------------------------

    def left(self, fit: MapFit) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual of an exact simulation at a fit, by C⁻¹ and itself, (n,) each."""
        rest = self.problem.value - self.exact(fit)
        total = self.problem.covariance + fit.level**2 * self.problem.kernel
        return np.asarray(scipy.linalg.solve(total, rest, assume_a="pos")), rest

    def fitted(self, fit: MapFit) -> np.ndarray:
        """(n,) exact readings at a fit, with the rig's numbers and the specimens' own as fitted."""
        weighed, rest = self.left(fit)
        return np.asarray(self.problem.value - rest + self.errors.fitted @ weighed)

    def nuisances(self, fit: MapFit) -> dict[str, float]:
        """The most probable linear nuisances at a fit, by their standard deviations."""
        weighed, _ = self.left(fit)
        found = {each.name: float(each.change @ weighed) for each in self.errors.shared}
        for name, places in self.problem.places(fit.subset).items():
            if name in found:
                found[name] += POLICY.implausible_width * float(fit.zeta[places[0]])
        return found

    @property
    def fitted_names(self) -> tuple[str, ...]:
        """The model's own numbers by what a laboratory tells them as."""
        others = (WALL if each.names else each.key for each in self.problem.always[1:])
        return MODULUS, *others

    def configured_number(self, each: Nuisance) -> tuple[str, float]:
        """Key of a nuisance, of the configuration where it is one, and its deviation there."""
        if each.name != WALL:
            return each.name, each.std
        key, wall_mm = wall(self.applied)
        return key, each.std * wall_mm

    # -- exact simulations ------------------------------------------------------------------------

    def emulator_error(self, fit: MapFit, exact: np.ndarray) -> float:
        """Largest difference of the emulators at a fit from exact readings, (n,), by the noise."""
        missed = exact - self.problem.predicted(fit.subset, fit.zeta)
        return float(np.abs(missed / self.errors.noise).max())

    @abstractmethod
    def exact(self, fit: MapFit) -> np.ndarray:
        """(n,) readings at a fit's numbers, linear nuisances left out."""

    def simulated(
        self, fit: MapFit, addition: Proposal | None = None, *, derived: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Simulate a fit: readings, (m,), and derivatives by ζ, (m, d); no linear nuisances.

        Args:
            fit: the hypothesis.
            addition: whose protocols are followed, by a rig that is as reported; the measurement's
                where None.
            derived: whether derivatives are wanted; else most are 0.

        Returns:
            NaN where a simulation in closed form has no equilibrium.

        Raises:
            ConfigError: one line, where the simulation does not reach all readings.
        """
        problem, simulator, rig = self.problem, self.simulation, addition is None
        if addition is not None:
            simulator = simulator.of(addition.measurement, known_mesh=addition.known_mesh)
        own = [(number, place) for place, number in enumerate(problem.always[1:], 1)]
        own += [
            (number, place)
            for cause, number, place in self.numbers(fit)
            if cause.name in NAMES and (rig or cause.name not in problem.rig)
        ]
        c, box = self.factor(fit), np.vstack([problem.baseline_box, problem.box(fit.subset)])
        step = np.where(fit.zeta + POLICY.step > box[:, 1], -POLICY.step, POLICY.step)
        rates = [
            float(number.slope(fit.zeta[place])) * (c if number.modulus else 1.0)
            for number, place in own
        ]
        steps = [(n, rate * float(step[at])) for (n, at), rate in zip(own, rates, strict=True)]
        found = simulator.at(self.overrides(fit, rig=rig), steps if derived else ())
        value, slopes = found.readings, np.zeros((len(found.readings), len(fit.zeta)))
        slopes[:, 0] = found.slopes[MODULUS] * problem.factor.log_std
        for (number, place), rate in zip(own, rates, strict=True):
            slopes[:, place] = found.slopes.get(number.gradient, 0.0) * rate
        for name, places in problem.places(fit.subset).items():
            if rig and name not in NAMES:  # no simulation has it
                emulator, at = problem.emulators[name], np.r_[0, places]
                (g,), (by_zeta,) = emulator.with_slopes(fit.zeta[None, at])
                value = value + emulator.columns @ g
                slopes[:, at] += emulator.columns @ by_zeta
        return value, slopes

    @abstractmethod
    def covariances(
        self, addition: Proposal, readings: np.ndarray
    ) -> tuple[np.ndarray, float | np.ndarray]:
        """Return covariances by nuisances of an addition: (m, m), with the readings so far (n, m).

        Args:
            addition: what may be measured.
            readings: (m,) that are expected.
        """

    @abstractmethod
    def verified(self, posterior: ModelPosterior, say: Say) -> tuple[Self, ModelPosterior, float]:
        """Hold likely hypotheses against exact simulations, and compare all anew.

        Returns:
            The problem with what these tell, its posterior, and the largest difference of the
            leading fit's emulators from a simulation, by the noise; NaN where that did not end.
        """


def told_error(known: Iterable[tuple[MapFit, float]], fit: MapFit) -> float:
    """Estimate what emulators miss at a fit that simulations near by have corrected.

    With value and slopes known at a place, errors grow by the square from there.

    Args:
        known: simulated fits of the same causes, and what emulators missed there, by the noise.
        fit: another one of these.

    Returns:
        The least of these estimates, by the noise; infinity where nothing is known.
    """
    grown = (0.5 * missed * float(np.square(e.zeta - fit.zeta).sum()) for e, missed in known)
    return min(grown, default=np.inf)


def remembers_state(name: str) -> bool:
    """Tell whether a cause is an effect of what was before: a material remembers, a line lags.

    Args:
        name: of the cause.
    """
    return name in NAMES and (effect(name).kind == "dissipative" or effect(name).clock)


def told_by_shape(causes: Iterable[str], measurement: Measurement) -> frozenset[str]:
    """List causes with memory that readings tell by a shape that something else has, too.

    Along one loading an elastic law has it. Along the loop of a coupon friction in the testing
    machine has it. An elastic law is felt in all experiments. So it is no rival of a cause that one
    of them does not feel, as free bending does not feel a plate's friction.

    Args:
        causes: their names.
        measurement: with the experiments.
    """
    if shows_memory(measurement) and any(test.of_finger for test in measurement.tests):
        return frozenset()
    rigs = [EXPERIMENTS[test.experiment].parts for test in measurement.tests]
    return frozenset(
        name for name in causes if remembers_state(name) and all(map(effect(name).felt_on, rigs))
    )


@dataclass(frozen=True, eq=False)
class Alternative:
    """A cause that follows the readings about as well as none does, other numbers being others.

    Attributes:
        fit: the hypothesis.
        factor: its evidence by that of none, or by the best.
        behind: numbers that take its change over.
        stronger: the same where its cause does one standard deviation more.
    """

    fit: MapFit
    factor: float
    behind: tuple[str, ...]
    stronger: MapFit


def hidden_effects(analysis: Analysis, none: MapFit) -> dict[str, tuple[str, ...]]:
    """List the effects of which less than what counts as visible is seen.

    Args:
        analysis: the readings with all that could explain them.
        none: fit without causes.

    Returns:
        The numbers that take an effect's change over, by its name; none where it is faint by
        itself.
    """
    problem = analysis.problem
    seen = Visibility(problem, none.zeta[: problem.nuisance_count])
    found: dict[str, tuple[str, ...]] = dict.fromkeys(analysis.unseen, ())
    for name, cause in analysis.effects.items():
        zeta = cause.at_strength(problem.boxes[name])
        if seen.strength(name, zeta) < POLICY.visible_sigma:
            _, found[name] = _taken(analysis, seen, seen.change(name, zeta))
    return found


def _taken(
    analysis: Analysis, seen: Visibility, change: np.ndarray
) -> tuple[float, tuple[str, ...]]:
    """Length of a change, (n,), by the noise alone, and the numbers that take most of it over."""
    noise = analysis.errors.noise
    alone = float(np.linalg.norm(change / noise))
    if alone < POLICY.visible_sigma:
        return alone, ()
    always, shared = analysis.problem.always, analysis.errors.shared
    names = [each.names[0] if each.names else each.key for each in always]
    names += [each.name for each in shared]
    columns = np.column_stack([seen.own, *(each.change for each in shared)]) / noise[:, None]
    parts = np.abs(taken(change / noise, columns)) * np.linalg.norm(columns, axis=0)
    order = np.argsort(parts)[::-1]
    return alone, tuple(names[i] for i in order if parts[i] >= 0.5 * parts.max())


def alternatives(
    analysis: Analysis, posterior: ModelPosterior, *, off: bool = False
) -> list[Alternative]:
    """List single causes that the readings do not exclude beside none, the likeliest first.

    Prior odds do not count: that none acts needs evidence as strong as that a cause does. A cause
    whose own change could not be seen, whatever else is free, is none of them.

    Args:
        analysis: the readings with all that could explain them.
        posterior: of all hypotheses.
        off: whether something is off, so that the best evidence counts in the place of none's.
    """
    problem, evidence = posterior.problem, _evidence(posterior)
    against = max(evidence.values()) if off else evidence[NONE]
    fits = {(each.subset, each.level): each for each in posterior.fits}
    found = []
    for subset, log in evidence.items():
        factor = float(np.exp(log - against))
        if len(subset) != 1 or problem.causes(subset) != subset or factor < np.exp(-ADDITIONS.tied):
            continue
        fit, own = fits[subset, 0.0], problem.nuisance_count
        seen = Visibility(problem, fit.zeta[:own])
        change = problem.predicted(subset, fit.zeta) - problem.predicted(NONE, seen.at)
        more = _room(analysis, fit, change)
        more_of_readings = problem.slopes(subset, fit.zeta)[:, own:] @ more[own:]
        alone, behind = _taken(analysis, seen, change + more_of_readings)
        if alone >= POLICY.implausible_sigma:
            box = np.vstack([problem.baseline_box, problem.box(subset)])
            stronger = replace(fit, zeta=np.clip(fit.zeta + more, *box.T))
            found.append(Alternative(fit, factor, behind, stronger))
    return sorted(found, key=lambda each: -each.factor)


def _room(analysis: Analysis, fit: MapFit, change: np.ndarray) -> np.ndarray:
    """(d,) the step of ζ that changes most by a fit's causes, one standard deviation of these.

    Its sign is that of the change so far, (n,); the model's own numbers follow.
    """
    own = analysis.problem.nuisance_count
    slopes = analysis.problem.slopes(fit.subset, fit.zeta)[:, own:]
    covariance = np.linalg.inv(fit.hessian)
    lower = np.linalg.cholesky(covariance[own:, own:])
    white = slopes @ lower / analysis.errors.noise[:, None]
    way = np.linalg.svd(white, full_matrices=False)[2][0]
    step = covariance[:, own:] @ np.linalg.solve(lower.T, way)
    return np.asarray(step if (slopes @ lower @ way) @ change >= 0 else -step)


def _evidence(posterior: ModelPosterior) -> dict[Subset, float]:
    """ln p(y) of each set of causes, by all levels of a discrepancy."""
    logs: dict[Subset, list[float]] = defaultdict(list)
    for fit in posterior.fits:
        logs[fit.subset].append(fit.log_evidence + float(np.log(LEVELS[fit.level])))
    return {subset: float(np.logaddexp.reduce(each)) for subset, each in logs.items()}
