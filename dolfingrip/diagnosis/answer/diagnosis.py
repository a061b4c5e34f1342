"""A diagnosis: the answer, fitted numbers and their intervals."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.answer.analysis import (
    Alternative,
    Analysis,
    alternatives,
    hidden_effects,
)
from dolfingrip.diagnosis.answer.artefacts import Artefact
from dolfingrip.diagnosis.answer.gain import HeldOut
from dolfingrip.diagnosis.answer.refining import refined
from dolfingrip.diagnosis.core.decision import (
    Decision,
    Sensitivity,
    sensitivity,
)
from dolfingrip.diagnosis.core.evidence import NONE, MapFit
from dolfingrip.diagnosis.core.search import ModelPosterior, search
from dolfingrip.diagnosis.policy import ADDITIONS, POLICY
from dolfingrip.diagnosis.simulation.nuisances import UNITS
from dolfingrip.diagnosis.simulation.unknowns import told_as
from dolfingrip.extensions.index import effect
from dolfingrip.files.diagnosis import Downstream, FittedNumber, NextExperiment
from dolfingrip.jobs.run import Say, silent
from dolfingrip.parameter import find, named
from dolfingrip.parameter.nuisances import WALL, modulus_keys
from dolfingrip.sections.section import Role

MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as it cannot be told: it may be named as an "
    "effect; compare readings with {finer}"
)
"""Said where neither a second mesh nor a bisection tells it."""


@dataclass(eq=False)
class Diagnosis:
    """Everything that was found.

    Attributes:
        config: the model that was diagnosed.
        analysis: readings, emulators and covariance.
        posterior: probabilities of all hypotheses.
        decision: the answer.
        sensitivity: answers under other priors.
        held_out: errors on readings that were left out; None where nothing was.
        next: additions, the best first.
        suspicions: doubts about the data, a sentence each.
        warnings: what else to beware of.
        downstream: what the extended model changes about a campaign's designs.
        simulated_s: time of all simulations.
        quick: whether it stopped after the screen.
    """

    config: Config
    analysis: Analysis[Any]
    posterior: ModelPosterior
    decision: Decision
    sensitivity: Sensitivity
    held_out: HeldOut | None = None
    next: list[NextExperiment] = field(default_factory=list)
    suspicions: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    simulated_s: float = 0.0
    quick: bool = False
    downstream: Downstream | None = None

    @property
    def load(self) -> str:
        """Name of the load that readings lie along."""
        return "strain" if self.analysis.closed_form else "pressure"

    @property
    def beside(self) -> str:
        """Nuisances that are fitted beside the causes, in words."""
        if self.analysis.closed_form:
            return "each coupon's own stiffness and slack"
        return "what else the rig may be off by"

    @property
    def none(self) -> MapFit:
        """The model as it is, its modulus fitted."""
        return self.posterior.best(NONE, level=0.0)

    def nuisance_values(self, c: np.ndarray, zeta: np.ndarray) -> dict[str, np.ndarray]:
        """The model's own numbers that are fitted, by key, shape (places,).

        Args:
            c: factor of all moduli, shape (places,).
            zeta: shape (places, d).
        """
        model = self.analysis.applied
        found = {each.key: each.value(model) * c for each in find(model, modulus_keys(model))}
        problem = self.analysis.problem
        for place, number in enumerate(problem.always[1 : problem.simulated_count], 1):
            found[number.key] = number.at(zeta[:, place]) * (c if number.modulus else 1.0)
        return found

    def configured(self) -> dict[str, float]:
        """Return the nuisances as configured."""
        middle = np.zeros((1, self.analysis.problem.nuisance_count))
        return {
            key: float(values[0])
            for key, values in self.nuisance_values(np.ones(1), middle).items()
        }

    def numbers(self, fit: MapFit) -> list[FittedNumber]:
        """Fitted numbers by key of the configuration; moduli at the fitted modulus.

        Intervals of what is fitted in every hypothesis hold whichever of those acts that the answer
        leaves open.
        """
        found = self._numbers(fit)
        if fit.subset != self.decision.best.subset:
            return found
        ends = {each.key: [each] for each in found}
        for other in (*map(self.member, self.open_names), *self.members.values()):
            for each in self._numbers(other):
                ends.get(each.key, []).append(each)
        return [
            each.model_copy(update={
                "low": min(other.low for other in ends[each.key]),
                "high": max(other.high for other in ends[each.key]),
            })
            for each in found
        ]  # fmt: skip

    def _numbers(self, fit: MapFit) -> list[FittedNumber]:
        draws, weights = fit.draws or _by_hessian(fit)
        every = np.vstack([fit.zeta, draws])
        c = self.analysis.problem.factor.at(every[:, 0])
        values = list(self.nuisance_values(c, every).items())
        for _, number, place in self.analysis.numbers(fit):
            scale = c if number.modulus else 1.0
            values.append((number.key, number.at(every[:, place]) * scale))
        return [_estimated(key, float(each[0]), each[1:], weights) for key, each in values]

    def member(self, name: str) -> MapFit:
        """Fit of a cause in the place of the first that is named, beside the second."""
        allowed = {name, *self.decision.second}
        causes = self.posterior.problem.causes
        fits = [fit for _, fit in self.posterior.weighed if name in fit.subset]
        own = [fit for fit in fits if set(causes(fit.subset)) <= allowed]
        return max(own or fits, key=lambda each: each.log_evidence)

    @property
    def members(self) -> dict[str, MapFit]:
        """Fits of the causes that could stand in the place of the one that is told, by name."""
        known, best = self.posterior.names, self.decision.best.subset
        return {
            name: self.member(name)
            for name in self.decision.first if name in known and name not in best
        }  # fmt: skip

    def words(self, name: str) -> str:
        """Tell what an effect does at its fitted numbers."""
        applied = self.analysis.applied
        if name not in self.analysis.causes:
            return effect(name)().words(applied)
        fit = self.member(name)
        own = fit.zeta[self.analysis.problem.places(fit.subset)[name]]
        on = changed(applied, self.analysis.causes[name].overrides(own, self.analysis.factor(fit)))
        told: str = getattr(on.extensions, name).words(applied)
        return told

    def fitted(self, fit: MapFit) -> str:
        """Tell in a sentence which numbers of the model were fitted."""
        sigma = abs(float(fit.zeta[0]))
        factor = self.analysis.factor(fit)
        same = f"{factor:.2f}" == "1.00"
        told = (
            "The configured modulus" if same else f"A modulus {_times(factor)} the configured one"
        )
        if sigma > POLICY.implausible_sigma:
            std = 100 * self.analysis.problem.factor.log_std
            told += f" (prior ±{std:.2g} %: {sigma:.1f} standard deviations)"
        if WALL not in self.analysis.fitted_names:
            return f"{told} is fitted."
        place = self.analysis.fitted_names.index(WALL)
        walls = self.analysis.problem.always[place].prior
        thicker = 100 * (walls.at(float(fit.zeta[place])) / walls.at(0.0) - 1)
        way = "thicker" if thicker > 0 else "thinner"
        return f"{told} and walls {abs(thicker):.2g} % {way} than configured are fitted."

    def nuisances(self, fit: MapFit) -> dict[str, float]:
        """Fitted nuisances by their standard deviations."""
        own = dict(zip(self.analysis.fitted_names, map(float, fit.zeta), strict=False))
        return own | self.analysis.nuisances(fit)

    def setup_estimates(self, fit: MapFit) -> list[SetupEstimate]:
        """Numbers of rig and body that the laboratory told, at a fit, but those known exactly."""
        deviations, problem = self.nuisances(fit), self.analysis.problem
        artefacts = {each.nuisance.name for each in self.artefacts}
        changes = [
            (each.unknown, deviations[each.name] * each.change)
            for each in self.analysis.errors.shared
            if each.std
            and not each.name.startswith("specimen_scale")
            and each.name not in artefacts
        ]
        here = problem.predicted(fit.subset, fit.zeta)
        for place, number in enumerate(problem.always):
            if place and told_as(number) != WALL:
                as_told = np.where(np.arange(len(fit.zeta)) == place, 0.0, fit.zeta)
                changes.append((number, here - problem.predicted(fit.subset, as_told)))
        found = []
        for number, change in changes:
            name = told_as(number)
            unit = number.unit or UNITS.get(name) or (named(name).unit if "." in name else "")
            # a number of the configuration is absolute, all others without a unit are relative
            size, unit = (1.0, unit) if unit or "." in name else (100.0, "%")
            std = size * number.prior.spread
            seen = np.linalg.norm(change / self.analysis.errors.noise) >= POLICY.visible_sigma
            share = self.share(change) if seen else 0.0
            found.append(SetupEstimate(name, unit, std, deviations[name] * std, share))
        return found

    @property
    def artefacts(self) -> Sequence[Artefact]:
        """Artefacts of instruments, which the errors of the analysis have."""
        return self.analysis.errors.artefacts

    @property
    def irregular(self) -> list[str]:
        """A sentence about all artefacts of instruments; none where there are none."""
        sizes = self.nuisances(self.decision.best)
        told = [each.sentence(sizes[each.nuisance.name]) for each in self.artefacts]
        return [f"{'; '.join(told)}. The diagnosis takes that out."] if told else []

    def with_best_modulus(self) -> np.ndarray:
        """(n,) readings of the model without causes, what is its own fitted."""
        return self.analysis.fitted(self.none)

    @property
    def undecided(self) -> bool:
        """Tell whether neither a cause is claimed nor that the catalogue has none."""
        vague = self.decision.probability < POLICY.likelier
        return self.decision.answer == "none" or (self.decision.answer == "unknown" and vague)

    @cached_property
    def alternatives(self) -> Sequence[Alternative]:
        """Causes that the readings do not exclude where none is named; none where one is."""
        if not self.undecided:
            return ()
        off = self.decision.answer == "unknown"
        return alternatives(self.analysis, self.posterior, off=off)

    @cached_property
    def probability(self) -> float:
        """Probability of the answer.

        That nothing acts is no more probable than what may hide leaves it.
        """
        sure = self.decision.probability
        if self.decision.answer == "none":
            names = {name for each in self.alternatives for name in each.fit.subset}
            sure -= sum(
                p for p, fit in self.posterior.weighed
                if fit.shows_nothing and not names.isdisjoint(fit.subset)
            )  # fmt: skip
        return float(np.clip(sure, 0.0, 1.0))

    @property
    def claimed(self) -> bool:
        """Tell whether the answer is sure enough to be told as one: all causes were looked at."""
        return self.probability >= POLICY.claimed and not self.analysis.not_tried

    @property
    def open_names(self) -> list[str]:
        """Causes that may act where none is named, the likeliest first.

        They are those that the readings do not exclude, and those that may be seen.
        """
        if not self.undecided:
            return []
        inclusion, own = self.decision.inclusion, self.posterior.problem.implausible
        names = [each.fit.subset[0] for each in self.alternatives]
        seen = [n for n, p in inclusion.items() if p >= POLICY.verified and n not in {*own, *names}]
        return sorted([*names, *seen], key=lambda name: -inclusion.get(name, 0.0))

    @property
    def tied(self) -> list[str]:
        """Causes that the readings do not tell apart: those of a set, or those that may act."""
        first, second = self.decision.first, self.decision.second
        return [*first, *second] if max(len(first), len(second)) > 1 else self.open_names

    def hidden(self) -> str:
        """Effects that the readings do not show at their ordinary strength, in words."""
        told = {*self.decision.first, *self.decision.second}
        hidden = hidden_effects(self.analysis, self.none)
        return in_words({name: behind for name, behind in hidden.items() if name not in told})

    @property
    def finer(self) -> str:
        """A finer mesh in words of the configuration."""
        mesh = self.config.mesh
        return "a mesh file of smaller cells" if mesh.file else "a smaller mesh.size_mm"

    def undecided_channels(self) -> list[str]:
        """Channels whose mesh is off by much of what the model misses, a sentence each."""
        value, simulated = self.analysis.problem.value, self.analysis.configured
        channels, found = self.analysis.measurement.channels(), []
        for name, error in self.analysis.mesh_errors.items():
            at = channels[name] & np.isfinite(simulated)
            missed = float(np.sqrt(np.mean((value - simulated)[at] ** 2))) if at.any() else 0.0
            noise = float(np.median(self.analysis.errors.noise[channels[name]]))
            if error > max(POLICY.mesh_decides * missed, noise):
                unit = CHANNELS[name].unit
                found.append(
                    f"This mesh cannot decide about {name}: its own error is about {error:.2g} "
                    f"{unit}, where the model is {missed:.2g} {unit} off; take {self.finer}"
                )
        return found

    def cautions(self) -> list[str]:
        """List what to beware of, a sentence each."""
        analysis, scatter = self.analysis, self.analysis.errors.scatter
        found = []
        if scatter.estimated and scatter.scale > POLICY.scatters * scatter.prior_scale:
            found.append(
                f"the specimens' stiffness scatters by {100 * scatter.scale:.2g} %, where "
                f"{100 * scatter.prior_scale:.2g} % is believed (nuisance.specimen_scale)"
            )
        if not (analysis.closed_form or analysis.mesh_errors):
            found.append(MESH_UNKNOWN.format(finer=self.finer))
        found += [f"{name} could not be tried: {why}" for name, why in analysis.failed.items()]
        if analysis.problem.extrapolated(self.decision.best) > POLICY.exactly:
            found.append("the leading fit was not simulated: its readings are extrapolated")
        return found

    def overrides(self, fit: MapFit) -> Change:
        """Return the change that makes the configuration the fitted one."""
        return self.analysis.overrides(fit)

    def share(self, change: np.ndarray) -> float:
        """A change of the readings, (n,), by what the model as configured misses, both rms."""
        off = self.analysis.problem.value - self.analysis.configured
        come = np.isfinite(off)
        missed = float(np.linalg.norm(off[come]))
        return float(np.linalg.norm(change[come])) / missed if missed else 0.0

    def extended(self, fit: MapFit) -> Config:
        """The body as it was drawn for the tests, at the numbers of a fit; no set-up."""
        sections = self.analysis.measurement.tests[0].setup.sections
        classes = Config.classes()
        drawn = {name: sections[name] for name in sections if classes[name].role is Role.BODY}
        config = self.config.changed(**drawn) if drawn else self.config
        return changed(config, self.overrides(fit))


def diagnosed(
    analysis: Analysis[Any], config: Config, *, quick: bool = False, say: Say = silent
) -> Diagnosis:
    """Find out what the simulation gets wrong, and why, up to the answer.

    Args:
        analysis: readings with all that could explain them.
        config: the model that is diagnosed.
        quick: verify no claim that would take long.
        say: told what is being done.

    Raises:
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    say("comparing all causes, alone and in pairs")
    analysis = analysis.judged_by_shape()
    analysis, posterior = refined(analysis, _compared(analysis), say, _most(quick))
    while found := analysis.artefacts(posterior):
        say(f"comparing all causes beside {' and '.join(e.nuisance.name for e in found)}")
        other = analysis.beside(found)
        log_prior = sum(each.log_prior for each in found)
        other, beside = refined(other, _compared(other), say, _most(quick))
        likelier = beside.log_density + log_prior > posterior.log_density + ADDITIONS.tied
        # of a specimen that stands apart even so, more is off than an artefact
        if not likelier or other.specimens_apart():
            break
        analysis, posterior = other, beside
    if not analysis.closed_form:
        posterior = search(analysis.problem, np.random.default_rng(0), before=posterior)
    return Diagnosis(config, analysis, posterior, *sensitivity(posterior), quick=quick)


def _most(quick: bool) -> int:
    return POLICY.quick_fits if quick else POLICY.simulated_fits


def _compared(analysis: Analysis[Any]) -> ModelPosterior:
    return search(analysis.problem, np.random.default_rng(0), sample=False)


@dataclass(frozen=True, slots=True)
class SetupEstimate:
    """A number of the rig, as the readings tell it.

    Attributes:
        name, unit: of it.
        prior_std: its prior standard deviation.
        value: difference from what was told.
        share: what it changes by what the model misses as configured, root mean square; 0 where
            the noise hides the change.
    """

    name: str
    unit: str
    prior_std: float
    value: float
    share: float

    @property
    def telling(self) -> bool:
        """True if it is implausible by its prior, or explains much of what the model misses."""
        return (
            abs(self.value) > POLICY.implausible_sigma * self.prior_std
            or self.share >= POLICY.telling
        )


def _by_hessian(fit: MapFit) -> tuple[np.ndarray, np.ndarray]:
    """Draws from the normal distribution about the most probable numbers."""
    rng = np.random.default_rng(0)
    lower = np.linalg.cholesky(np.linalg.inv(fit.hessian))
    draws = fit.zeta + rng.standard_normal((POLICY.draws, len(fit.zeta))) @ lower.T
    return draws, np.full(POLICY.draws, 1 / POLICY.draws)


def _estimated(key: str, value: float, draws: np.ndarray, weights: np.ndarray) -> FittedNumber:
    """A number and its interval, by draws of it with weights, shapes (draws,)."""
    tail = (1 - POLICY.interval) / 2
    ends = np.quantile(draws, [tail, 1 - tail - 1e-9], weights=weights, method="inverted_cdf")
    low, high = map(float, ends)
    return FittedNumber(key=key, value=value, low=min(low, value), high=max(high, value))


def _times(factor: float) -> str:
    """A factor in words."""
    if 0.5 < factor < 2:
        return f"{abs(100 * (factor - 1)):.2g} % {'above' if factor > 1 else 'below'}"
    return f"{factor:.3g} times"


def in_words(hidden: Mapping[str, tuple[str, ...]]) -> str:
    """Tell effects that cannot be seen by the numbers that they hide behind.

    Args:
        hidden: these numbers, by the names of the effects.
    """
    groups: dict[tuple[str, ...], list[str]] = defaultdict(list)
    for name, behind in hidden.items():
        groups[behind].append(name)
    faint = groups.pop((), [])
    parts = [f"behind {' and '.join(behind)}: {', '.join(own)}" for behind, own in groups.items()]
    if faint:
        parts.append(f"too faint for these readings: {', '.join(faint)}")
    return "; ".join(parts)
