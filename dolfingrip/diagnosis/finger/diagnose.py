"""A diagnosis of fingers: all hypotheses by emulators, claims verified by simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.search import Posterior, search
from dolfingrip.diagnosis.core.sensitivity import sensitivity
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.case import FingerCase, finger_case
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.runner import Workers


def searched(
    finger: FingerCase, say: Callable[[str], None] = lambda text: None
) -> tuple[FingerCase, Posterior, float]:
    """The posterior, its leading fits verified by a simulation each.

    Returns:
        The case with what simulations corrected, its posterior, and what the leading fit's
        emulators still miss of a simulation, root mean square by the noise; NaN where none ended.
    """
    posterior = search(finger.case, np.random.default_rng(0))
    left = float("nan")
    for _ in range(POLICY.verified):
        fit = sensitivity(posterior)[0].best
        exact = finger.exact(fit)
        missed = exact - finger.case.predicted(fit.subset, fit.zeta)
        if not np.isfinite(missed).all():
            say("the leading fit could not be simulated")
            break
        left = float(np.sqrt(np.mean((missed / finger.errors.noise) ** 2)))
        worst = float(np.abs(missed / finger.errors.noise).max())
        say(f"a simulation of {' with '.join(fit.subset) or 'the model'} differs by {worst:.2g} "
            "standard deviations of the noise at most")  # fmt: skip
        if worst <= 1.0 or not fit.subset:
            break
        finger = finger.corrected(fit, missed)
        posterior = search(finger.case, np.random.default_rng(0))
    return finger, posterior, left


def diagnose_fingers(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    names: Sequence[str] | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> tuple[FingerCase, Posterior, float]:
    finger = finger_case(measurement, config, workers, names, say)
    say("comparing all causes, alone and in pairs")
    return searched(finger, say)
