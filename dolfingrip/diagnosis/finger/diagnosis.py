"""A diagnosis of fingers: hypotheses compared by emulators, claims verified by simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from dolfingrip.config import Change, Config, ConfigError, changed
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.additions.worth import PredictedAddition, Rival, shows_memory
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.answer.diagnosis import fitted as fitted_readings
from dolfingrip.diagnosis.core.decision import sensitivity
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.core.problem import Subset
from dolfingrip.diagnosis.core.search import ModelPosterior, search
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.analysis import FingerAnalysis, analyse_fingers, simulated
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL, base_variant, nuisances
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, simulate
from dolfingrip.extensions.index import effect
from dolfingrip.sections.section import Role


def _covariances(finger: FingerAnalysis, proposal: Proposal) -> tuple[np.ndarray, np.ndarray]:
    """Return covariances by nuisances: of an addition, (m, m), with the readings so far, (n, m)."""
    simulation = finger.simulation
    measurement = proposal.measurement
    config = changed(simulation.config, {} if proposal.known_mesh else simulation.flat)
    wanted = base_variant(measurement, config)
    (base,) = simulate(measurement, config, [wanted], simulation.workers)
    fitted = {"modulus", *(["wall"] if finger.wall_std else [])}
    old = {each.name: each.change for each in finger.errors.shared}
    n, m = len(finger.problem.value), len(base.readings)
    shared, cross = np.zeros((m, m)), np.zeros((n, m))
    for each in nuisances(measurement, base):
        if each.name in fitted:
            continue
        change = np.nan_to_num(each.change)
        shared += np.outer(change, change)
        if each.name in old and not each.name.startswith("plate_gap"):  # that is set once more
            cross += np.outer(old[each.name], change)
    return shared, cross


MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as only a graded mesh of hexahedra tells it: it "
    "may be named as an effect; compare readings with a finer mesh (mesh.refine=2, mesh.size_mm)"
)
"""Said where there is no second mesh to compare with."""


@dataclass(eq=False)
class FingerDiagnosis(Diagnosis):
    """Everything that was found about fingers, and coupons beside them."""

    analysis: FingerAnalysis

    load: ClassVar[str] = "pressure"
    beside: ClassVar[str] = "what else the rig may be off by"

    @property
    def model(self) -> Config:
        return self.analysis.simulation.applied

    def nuisance_values(self, c: np.ndarray, zeta: np.ndarray) -> dict[str, np.ndarray]:
        found = super().nuisance_values(c, zeta)
        if self.analysis.wall_std:
            key, wall_mm = self.analysis.wall()
            found[key] = wall_mm * self.analysis.walls(zeta[:, 1])
        return found

    def walls(self, fit: MapFit) -> str:
        if not self.analysis.wall_std:
            return ""
        thicker = 100 * (float(self.analysis.walls(fit.zeta[1])) - 1)
        return (
            f"walls {abs(thicker):.2g} % {'thicker' if thicker > 0 else 'thinner'} than configured"
        )

    def nuisances(self, fit: MapFit) -> dict[str, float]:
        found = super().nuisances(fit)
        if self.analysis.wall_std:
            found[WALL] = float(fit.zeta[1])
        return found | self.analysis.nuisances(fit)

    def setup_deviations(self, fit: MapFit) -> dict[str, float]:
        return self.analysis.nuisances(fit)

    def as_configured(self) -> np.ndarray:
        return self.analysis.simulation.configured

    def with_best_modulus(self) -> np.ndarray:
        return fitted_readings(self.analysis, self.none)

    def hidden(self) -> str:
        return ", ".join(self.analysis.unseen)

    def cautions(self) -> list[str]:
        sentences = [
            f"{name} could not be tried: {why}" for name, why in self.analysis.failed.items()
        ]
        return sentences if self.analysis.simulation.mesh.size else [MESH_UNKNOWN, *sentences]

    def predict_addition(self, proposal: Proposal, fits: Sequence[MapFit]) -> PredictedAddition:
        simulation = self.analysis.simulation
        mesh = {} if proposal.known_mesh else simulation.flat
        # the rig's own errors are others then
        after = [
            Rival(fit.zeta, *simulated(self.analysis, fit, proposal.measurement, mesh, rig=False))
            for fit in fits
        ]
        # along one loading a law with memory follows any elastic one, fitted anew
        seen = shows_memory(simulation.measurement, proposal.measurement)
        causes = self.analysis.problem.causes
        remembers = np.array(
            [any(effect(name).kind == "dissipative" for name in causes(fit.subset)) for fit in fits]
        )
        unseen = (remembers[:, None] != remembers) & (not seen)
        return after, *_covariances(self.analysis, proposal), unseen

    def advice(self) -> str:
        if self.decision.answer == "unknown":
            return "another channel, unloading, or a coupon: they would tell what kind it is of"
        if self.decision.answer == "none":
            return "nothing: the readings agree with the model within their noise"
        if len(self.decision.first) > 1:
            names = ", ".join(self.decision.first)
            return f"measure one of these by itself: {names}; the readings do not tell them apart"
        return "nothing is needed: no other cause is nearly as probable as what is named"

    @property
    def extended(self) -> Config:
        """The finger as it was drawn for the tests, at the answer's numbers; no set-up."""
        sections = self.analysis.measurement.tests[0].setup.sections
        classes = Config.classes()
        drawn = {name: sections[name] for name in sections if classes[name].role is Role.BODY}
        config = self.config.changed(**drawn) if drawn else self.config
        return changed(config, self.overrides(self.decision.best))

    def overrides(self, fit: MapFit) -> Change:
        """Return the change that makes the configuration the fitted one."""
        return {**self.analysis.overrides(fit), **self.analysis.nuisance_overrides(fit)}


def compared(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    names: Sequence[str] | None = None,
    *,
    quick: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> FingerDiagnosis:
    """Find out what the simulation gets wrong about fingers, and why, up to the answer.

    Args:
        measurement: of fingers, and of coupons beside them.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        names: of the causes that are tried; the whole catalogue where None.
        quick: verify no claim.
        say: told what is being done.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    finger = analyse_fingers(measurement, config, workers, names, say)
    say("comparing all causes, alone and in pairs")
    posterior = search(finger.problem, np.random.default_rng(0))
    left = 0.0
    if not quick:
        finger, posterior, left = verified(finger, posterior, say)
    decision, under = sensitivity(posterior)
    return FingerDiagnosis(config, finger, posterior, decision, under, left)


def verified(
    finger: FingerAnalysis, posterior: ModelPosterior, say: Callable[[str], None]
) -> tuple[FingerAnalysis, ModelPosterior, float]:
    """The leading fit simulated; what its emulators missed they learn, and all is compared anew.

    Returns:
        The problem, its posterior, and the largest difference of the leading fit's emulators from a
        simulation, by the noise; NaN where that did not end.
    """
    worst = float("nan")
    known: set[Subset] = set()
    for _ in range(POLICY.rounds):
        fit = _leading(posterior, known)
        causes = finger.problem.causes(fit.subset)
        name = " with ".join(causes) or "the model"
        try:
            exact = np.column_stack(simulated(finger, fit, finger.measurement))
        except ConfigError as error:
            say(f"a simulation at fitted numbers failed: {error}")
            return finger, posterior, float("nan")
        worst = finger.emulator_error(fit, exact[:, 0])
        say(
            f"a simulation of {name} at its fitted numbers differs by {worst:.2g} standard "
            "deviations of the noise at most"
        )
        leading = sensitivity(posterior)[0].best
        ends = causes in known or not finger.problem.causes(leading.subset)
        if worst <= 1.0 and ends:
            break
        known.add(causes)
        finger = replace(finger, problem=finger.problem.corrected(fit.subset, fit.zeta, exact))
        posterior = search(finger.problem, np.random.default_rng(0))
    return *_verify_nuisances(finger, posterior, say), worst


def _verify_nuisances(
    finger: FingerAnalysis, posterior: ModelPosterior, say: Callable[[str], None]
) -> tuple[FingerAnalysis, ModelPosterior]:
    """The finger's own numbers simulated where they are fitted, if any reading feels it."""
    for _ in range(POLICY.rounds):
        fit = sensitivity(posterior)[0].best
        change = finger.nuisance_change(fit)
        if np.abs(change / finger.errors.noise).max() < 1.0:
            break
        overrides = {**finger.overrides(fit), **finger.nuisance_overrides(fit)}
        simulation = finger.simulation
        (run,) = simulate(
            simulation.measurement, simulation.config, [ModelVariant(overrides)], simulation.workers
        )
        if not np.isfinite(run.readings).all():
            say("the finger's own numbers, as fitted, could not be simulated")
            break
        worst = finger.emulator_error(fit, run.readings - change)
        say(
            f"a simulation at the finger's own fitted numbers differs by {worst:.2g} standard "
            "deviations of the noise at most"
        )
        if worst <= 1.0:
            break
        missed = run.readings - change - finger.problem.predicted(fit.subset, fit.zeta)
        finger = finger.relinearised(fit, missed)
        posterior = search(finger.problem, np.random.default_rng(0))
    return finger, posterior


def _leading(posterior: ModelPosterior, known: set[Subset]) -> MapFit:
    """The fit that is to be simulated: of a pair first its stronger cause alone."""
    best = sensitivity(posterior)[0].best
    causes = posterior.problem.causes(best.subset)
    if len(causes) < 2:
        return best
    alone = (max(causes, key=dict(zip(best.subset, best.strengths, strict=True)).__getitem__),)
    return best if alone in known else posterior.best(alone, level=0.0)
