"""A diagnosis: the answer, fitted numbers and their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from dolfingrip.config import Config, changed
from dolfingrip.diagnosis.answer.analysis import (
    Alternative,
    Analysis,
    alternatives,
    hidden_effects,
)
from dolfingrip.diagnosis.answer.artefacts import Artefact
from dolfingrip.diagnosis.answer.refining import refined
from dolfingrip.diagnosis.answer.statistics import fitted_numbers
from dolfingrip.diagnosis.core.decision import (
    Decision,
    Sensitivity,
    held,
    sensitivity,
)
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.core.problem import NONE
from dolfingrip.diagnosis.core.search import ModelPosterior, search
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.extensions.index import effect
from dolfingrip.files.diagnosis import (
    Downstream,
    FittedNumber,
    HeldOutError,
    NextExperiment,
    Slip,
    SpecimensApart,
    Verdict,
)
from dolfingrip.jobs.run import Say, silent
from dolfingrip.sections.section import Role


@dataclass(eq=False)
class Diagnosis:
    """The result; its statistics are in :mod:`.statistics`, its words in the room of files.

    Attributes:
        config: the model that was diagnosed.
        analysis: readings, simulations and covariance.
        posterior: probabilities of all hypotheses.
        decision: the answer.
        sensitivity: answers under other priors.
        gain: errors on readings that were left out.
        gain_claimed: whether the cause predicts these better; None where nothing was left out.
        next: additions, the best first.
        slips: doubts about the data.
        apart: specimens that stand apart, and the answer without these.
        warnings: what the data were read with, and what could not be judged.
        downstream: what the extended model changes about a campaign's designs.
        simulated_s: time of all simulations.
        quick: whether it stopped after the screen.
    """

    config: Config
    analysis: Analysis
    posterior: ModelPosterior
    decision: Decision
    sensitivity: Sensitivity
    gain: tuple[HeldOutError, ...] = ()
    gain_claimed: bool | None = None
    next: list[NextExperiment] = field(default_factory=list)
    slips: Sequence[Slip] = ()
    apart: SpecimensApart | None = None
    warnings: list[str] = field(default_factory=list)
    simulated_s: float = 0.0
    quick: bool = False
    downstream: Downstream | None = None

    @property
    def policy(self) -> Policy:
        """Numbers that it was made by."""
        return self.analysis.problem.policy

    @property
    def none(self) -> MapFit:
        """The model as it is, its modulus fitted."""
        return self.posterior.best(NONE, level=0.0)

    def numbers(self, fit: MapFit) -> list[FittedNumber]:
        """Fitted numbers by key of the configuration; moduli at the fitted modulus.

        Intervals of what is fitted in every hypothesis hold whichever of those acts that the answer
        leaves open.
        """
        numbers = fitted_numbers(self.analysis, fit)
        if fit.subset != self.decision.best.subset:
            return numbers
        ends = {number.key: [number] for number in numbers}
        for other in (*map(self.member, self.open_names), *self.members.values()):
            for number in fitted_numbers(self.analysis, other):
                ends.get(number.key, []).append(number)
        return [
            number.model_copy(update={
                "low": min(other.low for other in ends[number.key]),
                "high": max(other.high for other in ends[number.key]),
            })
            for number in numbers
        ]  # fmt: skip

    def member(self, name: str) -> MapFit:
        """Fit of a cause in the place of the first that is named, beside the second."""
        allowed = {name, *self.decision.second}
        causes = self.posterior.problem.causes
        fits = [fit for _, fit in self.posterior.weighed if name in fit.subset]
        within = [fit for fit in fits if set(causes(fit.subset)) <= allowed]
        return max(within or fits, key=lambda fit: fit.log_evidence)

    @property
    def members(self) -> dict[str, MapFit]:
        """Fits of the causes that could stand in the place of the one that is told, by name."""
        names, best = self.posterior.names, self.decision.best.subset
        return {
            name: self.member(name)
            for name in self.decision.first if name in names and name not in best
        }  # fmt: skip

    def words(self, name: str) -> str:
        """Tell what an effect does at its fitted numbers."""
        applied = self.analysis.applied
        if name not in self.analysis.causes:
            return effect(name)().words(applied)
        fit = self.member(name)
        zeta = fit.zeta[self.analysis.problem.places(fit.subset)[name]]
        on = changed(applied, self.analysis.causes[name].overrides(zeta, self.analysis.factor(fit)))
        words: str = getattr(on.extensions, name).words(applied)
        return words

    @property
    def artefacts(self) -> Sequence[Artefact]:
        """Artefacts of instruments, which the errors of the analysis have."""
        return self.analysis.errors.artefacts

    @property
    def undecided(self) -> bool:
        """Tell whether neither a cause is claimed nor that the catalogue has none."""
        vague = self.decision.probability < 0.5
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
            names = {name for other in self.alternatives for name in other.fit.subset}
            sure -= sum(
                p for p, fit in self.posterior.weighed
                if fit.shows_nothing and not names.isdisjoint(fit.subset)
            )  # fmt: skip
        return float(np.clip(sure, 0.0, 1.0))

    @property
    def claimed(self) -> bool:
        """Tell whether the answer is sure enough to be told as one.

        That no cause acts, or none of the catalogue, is not known where one was not simulated.
        """
        untried = self.analysis.not_tried
        if self.decision.answer != "cause":
            untried = [*untried, *self.analysis.failed]
        return self.probability >= self.policy.claimed and not untried

    @property
    def open_names(self) -> list[str]:
        """Causes that may act where none is named, the likeliest first.

        They are those that the readings do not exclude, and those that may be seen.
        """
        if not self.undecided:
            return []
        inclusion, numbers = self.decision.inclusion, self.posterior.problem.implausible
        least = self.policy.matters
        names = [other.fit.subset[0] for other in self.alternatives]
        seen = [n for n, p in inclusion.items() if p >= least and n not in {*numbers, *names}]
        return sorted([*names, *seen], key=lambda name: -inclusion.get(name, 0.0))

    @property
    def tied(self) -> list[str]:
        """Causes that the readings do not tell apart: those of a set, or those that may act."""
        first, second = self.decision.first, self.decision.second
        return [*first, *second] if max(len(first), len(second)) > 1 else self.open_names

    def hidden(self) -> dict[str, tuple[str, ...]]:
        """Effects that the readings do not show at their ordinary strength, and what hides them."""
        named_effects = {*self.decision.first, *self.decision.second}
        hidden = hidden_effects(self.analysis, self.none)
        return {name: behind for name, behind in hidden.items() if name not in named_effects}

    @property
    def verdict(self) -> Verdict:
        """The answer as it is told."""
        decision = self.decision
        return Verdict(
            answer=decision.answer, effects=decision.first, second=decision.second,
            nearest=decision.nearest, probability=self.probability, claimed=self.claimed,
            least=min(self.probability, self.sensitivity.least),
            takes_part=float(np.clip(held(decision.subsets, decision.first), 0, 1)),
            unexplained=float(np.clip(decision.unexplained, 0, 1)),
            by_shape=decision.by_shape,
        )  # fmt: skip

    def extended(self, fit: MapFit) -> Config:
        """The body as it was drawn for the tests, at the numbers of a fit; no set-up."""
        sections = self.analysis.measurement.tests[0].setup.sections
        classes = Config.classes()
        drawn = {name: sections[name] for name in sections if classes[name].role is Role.BODY}
        config = self.config.changed(**drawn) if drawn else self.config
        return changed(config, self.analysis.overrides(fit))


def diagnosed(
    analysis: Analysis,
    config: Config,
    slips: Sequence[Slip] = (),
    *,
    quick: bool = False,
    say: Say = silent,
) -> Diagnosis:
    """Find out what the simulation gets wrong, and why, up to the answer.

    Args:
        analysis: readings with all that could explain them.
        config: the model that is diagnosed.
        slips: doubts about the data. Artefacts would stand for a slip, or for a cause that was left
            out, so none are looked for.
        quick: verify no claim that would take long.
        say: told what is being done.

    Raises:
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    say("comparing all causes, alone and in pairs")
    analysis = analysis.judged_by_shape()
    most = 2 if quick else analysis.problem.policy.most_fits
    analysis, posterior = refined(analysis, _compared(analysis), say, most)
    while not (slips or analysis.not_tried) and (artefacts := analysis.artefacts(posterior)):
        say(f"comparing all causes beside {' and '.join(e.nuisance.name for e in artefacts)}")
        other = analysis.beside(artefacts)
        log_prior = sum(artefact.log_prior for artefact in artefacts)
        other, beside = refined(other, _compared(other), say, most)
        likelier = (
            beside.log_density + log_prior
            > posterior.log_density + analysis.problem.policy.log_odds
        )
        # of a specimen that stands apart even so, more is off than an artefact
        if not likelier or other.specimens_apart():
            break
        analysis, posterior = other, beside
    if not analysis.closed_form:
        posterior = search(analysis.problem, np.random.default_rng(0), before=posterior)
    answers = sensitivity(posterior)
    return Diagnosis(config, analysis, posterior, *answers, slips=slips, quick=quick)


def _compared(analysis: Analysis) -> ModelPosterior:
    return search(analysis.problem, np.random.default_rng(0), sample=False)
