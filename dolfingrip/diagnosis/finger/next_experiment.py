"""Which further experiment would tell tied causes apart, from a simulation of each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.additions.memory import shows
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.additions.worth import (
    ENOUGH,
    MODEL_ERROR,
    AdditionWorth,
    Expected,
    chance_alone,
)
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.coupon.next_experiment import Tied, tied
from dolfingrip.diagnosis.finger.case import FingerCase
from dolfingrip.diagnosis.finger.unknowns import FAR
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.simulation.nuisances import (
    by_log_modulus,
    keys,
    modulus_keys,
    neutral_stages,
    nuisances,
)
from dolfingrip.diagnosis.simulation.simulated import Case, simulate
from dolfingrip.extensions.index import effect


def next_experiments(
    finger: FingerCase,
    posterior: Posterior,
    decision: Decision,
    say: Callable[[str], None],
) -> tuple[list[AdditionWorth], list[str]]:
    """Additions that tell the tied hypotheses apart, the best first, and why some failed.

    Nothing where no other hypothesis is tied with the leading one.
    """
    fits = tied(posterior, decision)
    if len(fits) < 2:
        return [], []
    probability = np.array([p for p, _ in fits])
    weights = np.outer(probability, probability)
    np.fill_diagonal(weights, 0.0)
    weights /= max(weights.sum(), 1e-300)
    here = [_emulated(finger, fit) for _, fit in fits]
    now = Expected.of(
        here, Covariance.of(finger.case.covariance), [(t.readings, t.slopes) for t in here]
    )
    remembers = np.array(
        [any(effect(n).kind == "dissipative" for n in fit.subset) for _, fit in fits]
    )
    found, failed = [], []
    simulation = finger.simulation
    for proposal in proposals(simulation.measurement, simulation.config):
        say(f"next experiment: {proposal.name}")
        try:
            after = [_simulated(finger, proposal, fit) for _, fit in fits]
            joint = _joint(finger, proposal, after[0].readings)
        except ConfigError as error:
            failed.append(f"{proposal.name} could not be judged: {error}")
            continue
        then = Expected.of(
            here, Covariance.of(joint),
            [
                (np.append(a.readings, b.readings), np.vstack([a.slopes, b.slopes]))
                for a, b in zip(here, after, strict=True)
            ],
        )  # fmt: skip
        # along one loading a law with memory follows any elastic one, fitted anew
        seen = shows(simulation.measurement, proposal.measurement)
        unseen = (remembers[:, None] != remembers) & (not seen)
        useful = np.minimum(then.misfit, ENOUGH) - np.minimum(now.misfit, ENOUGH)
        found.append(
            AdditionWorth(
                proposal.name, proposal.minutes,
                float((weights * (then.misfit - now.misfit)).sum()),
                float((weights * useful).sum() / proposal.minutes),
                chance_alone(probability, now, then, unseen),
            )
        )  # fmt: skip
    return sorted(found, key=lambda worth: worth.rank), failed


def _emulated(finger: FingerCase, fit: Fit) -> Tied:
    """What was measured, as a hypothesis has it."""
    case = finger.case
    step = 1e-4
    readings = case.predicted(fit.subset, fit.zeta)
    slopes = [
        (case.predicted(fit.subset, fit.zeta + step * way) - readings) / step
        for way in np.eye(len(fit.zeta))
    ]
    return Tied(fit, fit.zeta, readings, np.column_stack(slopes))


def _simulated(finger: FingerCase, proposal: Proposal, fit: Fit) -> Tied:
    """What would be measured; the rig's own errors are others then.

    Raises:
        ConfigError: one line, where a simulation fails.
    """
    simulation, case = finger.simulation, finger.case
    flat = () if proposal.known_mesh else simulation.flat
    overrides = [
        each for each in finger.overrides(fit)
        if not any(each.startswith(f"extensions.{name}.") for name in FAR)
    ]  # fmt: skip
    numbers = [
        (number, place)
        for place, number in enumerate(
            (n for name in fit.subset for n in finger.causes[name].numbers), case.own
        )
        if not any(number.key.startswith(f"extensions.{name}.") for name in FAR)
    ]
    gradients = [f"{n.key}[0]" if n.listed else n.key for n, _ in numbers]
    gradients += modulus_keys(simulation.applied)
    if finger.wall_std:
        gradients.append(finger.wall()[0])
    (run,) = simulate(
        proposal.measurement, simulation.config,
        [Case((*flat, *overrides), tuple(gradients))], simulation.workers,
    )  # fmt: skip
    if not np.isfinite(run.readings).all():
        why = "; ".join(each.sentence for each in run.failures) or "no reading"
        raise ConfigError(f"{' with '.join(fit.subset)}: {why}")
    slopes = np.zeros((len(run.readings), len(fit.zeta)))
    c, dc = case.factor(fit.zeta[0])
    by_log = by_log_modulus(proposal.measurement, run)
    for (number, place), key in zip(numbers, gradients, strict=False):
        value = float(number.at(fit.zeta[place]))
        slope = run.slopes.get(key, np.zeros(len(run.readings)))
        if number.key.endswith("_MPa"):
            by_log = by_log + slope * value * float(c)
            slope = slope * float(c)
        slopes[:, place] = slope * number.prior.slope(float(fit.zeta[place]))
    slopes[:, 0] = by_log * float(dc / c)
    if finger.wall_std:
        key, wall_mm = finger.wall()
        slopes[:, 1] = run.slopes.get(key, 0.0) * wall_mm * finger.wall_std
    return Tied(fit, fit.zeta, run.readings, slopes)


def _joint(finger: FingerCase, proposal: Proposal, readings: np.ndarray) -> np.ndarray:
    """Covariance of the readings so far and of an addition's."""
    simulation = finger.simulation
    measurement = proposal.measurement
    config = simulation.config.overridden(() if proposal.known_mesh else simulation.flat)
    case = Case(neutral_stages(config), keys(measurement, config), headroom=True)
    (base,) = simulate(measurement, config, [case], simulation.workers)
    fitted = {"modulus", *(["wall"] if finger.wall_std else [])}
    new = {
        each.name: np.nan_to_num(each.change)
        for each in nuisances(measurement, base) if each.name not in fitted
    }  # fmt: skip
    old = {each.name: each.change for each in finger.errors.shared}
    n, m = len(finger.case.value), len(readings)
    found = np.zeros((n + m, n + m))
    found[:n, :n] = finger.case.covariance
    listed = measurement.listed()
    noise = np.array([_noise(finger, str(name)) for name in listed["column"]])
    error = np.array([
        0.5 * MODEL_ERROR if name == "coupon" else MODEL_ERROR for name in listed["experiment"]
    ])  # fmt: skip
    found[n:, n:] = np.diag(noise**2 + (error * readings) ** 2)
    for name, change in new.items():
        found[n:, n:] += np.outer(change, change)
        if name in old and not name.startswith("plate_gap"):  # a plate that is set once more
            found[:n, n:] += np.outer(old[name], change)
            found[n:, :n] += np.outer(change, old[name])
    return found


def _noise(finger: FingerCase, column: str) -> float:
    listed = finger.simulation.measurement.listed()
    same = (listed["column"] == column).to_numpy()
    return float(np.median(finger.errors.noise[same])) if same.any() else CHANNELS[column].noise
