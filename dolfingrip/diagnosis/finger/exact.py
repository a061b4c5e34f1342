"""A hypothesis of a finger, simulated at its numbers with derivatives by all of them."""

from __future__ import annotations

import numpy as np

from dolfingrip.config import NO_CHANGE, Change, ConfigError
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.case import FingerCase
from dolfingrip.diagnosis.finger.unknowns import FAR
from dolfingrip.diagnosis.simulation.nuisances import by_log_modulus, modulus_keys
from dolfingrip.diagnosis.simulation.simulated import Case, simulate


def simulated(
    finger: FingerCase,
    fit: Fit,
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
    case = finger.case
    numbers = [
        (number, place)
        for name, places in case.places(fit.subset).items()
        for number, place in zip(finger.causes[name].numbers, places, strict=True)
        if rig or name not in FAR
    ]
    overrides = {k: v for k, v in finger.overrides(fit).items() if rig or not _of_rig(k)}
    gradients = [f"{n.key}[0]" if n.listed else n.key for n, _ in numbers]
    every = [*gradients, *modulus_keys(finger.simulation.applied)]
    if finger.wall_std:
        every.append(finger.wall()[0])
    wanted = Case({**mesh, **overrides}, tuple(every))
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
    slopes[:, 0] = by_log * case.factor.std
    if finger.wall_std:
        key, wall_mm = finger.wall()
        slopes[:, 1] = run.slopes.get(key, none) * wall_mm * finger.wall_std
    return run.readings, slopes


def _of_rig(key: str) -> bool:
    return any(key.startswith(f"extensions.{name}.") for name in FAR)
