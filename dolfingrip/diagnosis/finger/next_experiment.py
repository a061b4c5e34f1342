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
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.coupon.next_experiment import Tied, tied
from dolfingrip.diagnosis.finger.case import FingerCase
from dolfingrip.diagnosis.finger.exact import emulated, simulated
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.simulation.nuisances import keys, neutral_stages, nuisances
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
    here = [Tied(fit, fit.zeta, *emulated(finger, fit)) for _, fit in fits]
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
            mesh = () if proposal.known_mesh else simulation.flat
            # the rig's own errors are others then
            after = [
                Tied(fit, fit.zeta, *simulated(finger, fit, proposal.measurement, mesh, rig=False))
                for _, fit in fits
            ]
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
