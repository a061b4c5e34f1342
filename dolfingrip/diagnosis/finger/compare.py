"""All hypotheses of fingers compared by emulators, and claims verified by simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.case import Subset
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior, search
from dolfingrip.diagnosis.core.sensitivity import sensitivity
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.case import FingerCase, finger_case
from dolfingrip.diagnosis.finger.exact import simulated
from dolfingrip.diagnosis.finger.found import FingerDiagnosis
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import Case, simulate


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
    finger = finger_case(measurement, config, workers, names, say)
    say("comparing all causes, alone and in pairs")
    posterior = search(finger.case, np.random.default_rng(0))
    left = 0.0
    if not quick:
        finger, posterior, left = verified(finger, posterior, say)
    decision, under = sensitivity(posterior)
    return FingerDiagnosis(config, finger, posterior, decision, under, left)


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
            exact = np.column_stack(simulated(finger, fit, finger.measurement))
        except ConfigError as error:
            say(f"a simulation at fitted numbers failed: {error}")
            return finger, posterior, float("nan")
        missed = exact[:, 0] - finger.case.predicted(fit.subset, fit.zeta)
        worst = float(np.abs(missed / finger.errors.noise).max())
        say(
            f"a simulation of {name} at its fitted numbers differs by {worst:.2g} standard "
            "deviations of the noise at most"
        )
        leading = sensitivity(posterior)[0].best
        ends = causes in known or not finger.case.causes(leading.subset)
        if worst <= 1.0 and ends:
            break
        known.add(causes)
        finger = replace(finger, case=finger.case.corrected(fit.subset, fit.zeta, exact))
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
        overrides = {**finger.overrides(fit), **finger.own_overrides(fit)}
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
        finger = finger.relinearised(fit, missed)
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
