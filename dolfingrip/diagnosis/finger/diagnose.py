"""A diagnosis of fingers: all hypotheses by emulators, claims verified by simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.answer.gain import held_out
from dolfingrip.diagnosis.core.case import Subset
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior, search
from dolfingrip.diagnosis.core.sensitivity import sensitivity
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.suspicion import suspicions
from dolfingrip.diagnosis.finger.case import FingerCase, finger_case
from dolfingrip.diagnosis.finger.exact import emulated, simulated
from dolfingrip.diagnosis.finger.found import FingerDiagnosis
from dolfingrip.diagnosis.finger.next_experiment import next_experiments
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.base import BaseSimulation
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import Case, SimulationFailure, simulate

MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as only a graded mesh of hexahedra tells it: it "
    "may be named as an effect; compare readings with a finer mesh (mesh.refine=2, mesh.size_mm)"
)
"""Said where there is no second mesh to compare with."""


def diagnose_fingers(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    names: Sequence[str] | None = None,
    *,
    quick: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> FingerDiagnosis:
    """Find out what the simulation gets wrong about fingers, and about coupons beside them.

    Args:
        measurement: of fingers and coupons.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        names: of the causes that are tried; the whole catalogue where None.
        quick: verify no claim, measure no gain and propose nothing.
        say: told what is being done.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    finger = finger_case(measurement, config, workers, names, say)
    say("comparing all causes, alone and in pairs")
    posterior = search(finger.case, np.random.default_rng(0))
    left = 0.0
    if not quick:
        finger, posterior, left = verified(finger, posterior, say)
    decision, under = sensitivity(posterior)
    found = FingerDiagnosis(config, finger, posterior, decision, under, left)
    base = finger.simulation.base
    kept = finger.measurement
    told = finger.simulation.configured
    shown = np.where(np.isfinite(told), told, base.readings)
    found.suspicions = [each.sentence() for each in suspicions(kept, shown)]
    found.not_reached = not_reached(measurement, base, finger.simulation.failures or None)
    found.warnings = [*measurement.warnings, *_cautions(found)]
    if quick or decision.answer != "cause":
        return found
    say("measuring the gain on readings that are left out")
    found.held_out = held_out(finger, posterior)
    found.next, failed = next_experiments(finger, posterior, decision, say)
    found.warnings += failed
    return found


def verified(
    finger: FingerCase, posterior: Posterior, say: Callable[[str], None]
) -> tuple[FingerCase, Posterior, float]:
    """The leading fit simulated; what its emulators missed they learn, and all is compared anew.

    Returns:
        The case, its posterior, and the largest difference of the leading fit's emulators from a
        simulation, by the noise; NaN where that did not end.
    """
    worst = float("nan")
    known: set[Subset] = set()
    for _ in range(POLICY.rounds):
        fit = _leading(posterior, known)
        causes = finger.case.causes(fit.subset)
        name = " with ".join(causes) or "the model"
        try:
            exact = simulated(finger, fit, finger.measurement)
        except ConfigError as error:
            say(f"a simulation at fitted numbers failed: {error}")
            return finger, posterior, float("nan")
        missed = np.column_stack(exact) - np.column_stack(emulated(finger, fit))
        worst = float(np.abs(missed[:, 0] / finger.errors.noise).max())
        say(
            f"a simulation of {name} at its fitted numbers differs by {worst:.2g} standard "
            "deviations of the noise at most"
        )
        leading = sensitivity(posterior)[0].best
        ends = causes in known or not finger.case.causes(leading.subset)
        if worst <= 1.0 and ends:
            break
        known.add(causes)
        finger = finger.corrected(fit, missed)
        posterior = search(finger.case, np.random.default_rng(0))
    return *_own_numbers_verified(finger, posterior, say), worst


def _own_numbers_verified(
    finger: FingerCase, posterior: Posterior, say: Callable[[str], None]
) -> tuple[FingerCase, Posterior]:
    """The finger's own numbers simulated where they are fitted, if any reading feels it."""
    for _ in range(POLICY.rounds):
        fit = sensitivity(posterior)[0].best
        change = finger.by_own(fit)
        if np.abs(change / finger.errors.noise).max() < 1.0:
            break
        overrides = (*finger.overrides(fit), *finger.own_overrides(fit))
        simulation = finger.simulation
        (run,) = simulate(
            simulation.measurement, simulation.config, [Case(overrides)], simulation.workers
        )
        if not np.isfinite(run.readings).all():
            say("the finger's own numbers, as fitted, could not be simulated")
            break
        missed = run.readings - finger.case.predicted(fit.subset, fit.zeta) - change
        worst = float(np.abs(missed / finger.errors.noise).max())
        say(
            f"a simulation at the finger's own fitted numbers differs by {worst:.2g} standard "
            "deviations of the noise at most"
        )
        if worst <= 1.0:
            break
        finger = finger.along_secant(fit, missed)
        posterior = search(finger.case, np.random.default_rng(0))
    return finger, posterior


def _leading(posterior: Posterior, known: set[Subset]) -> Fit:
    """The fit that is to be simulated: of a pair first its stronger cause alone."""
    best = sensitivity(posterior)[0].best
    causes = posterior.case.causes(best.subset)
    if len(causes) < 2:
        return best
    alone = (max(causes, key=dict(zip(best.subset, best.strengths, strict=True)).__getitem__),)
    return best if alone in known else posterior.best(alone, level=0.0)


def _cautions(found: FingerDiagnosis) -> list[str]:
    told = []
    finger = found.analysed
    if not finger.simulation.base.mesh.size:
        told.append(MESH_UNKNOWN)
    told += [f"{name} could not be tried: {why}" for name, why in finger.failed.items()]
    if not found.left_by_emulator <= 1.0:
        off = found.left_by_emulator
        told.append(
            "the leading fit could not be simulated"
            if np.isnan(off)
            else f"the fit's fast model is off by {off:.2g} standard deviations of the noise "
            "from a simulation at its numbers"
        )
    return told


def not_reached(
    measurement: Measurement,
    base: BaseSimulation,
    failures: Sequence[SimulationFailure] | None = None,
) -> list[str]:
    """For each test, readings that the base simulation does not come to, and why.

    Args:
        measurement: all that was measured.
        base: of the readings that it reaches, or of all.
        failures: of the base simulation, where it is of the readings that it reaches.
    """
    every = measurement.listed()["test"].to_numpy()
    reached = base.measurement.listed()["test"].to_numpy()[np.isfinite(base.readings)]
    found = []
    for test in measurement.tests:
        count = int((every == test.number).sum())
        lost = count - int((reached == test.number).sum())
        if lost:
            failed = base.failures if failures is None else failures
            why = [each.sentence for each in failed if test in each.tests]
            found.append(
                f"{test.experiment} of {test.specimen}: the base simulation does not reach "
                f"{lost} of {count} readings, which are left out: {'; '.join(why)}"
            )
    return found
