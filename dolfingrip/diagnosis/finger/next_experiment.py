"""Which further experiment would tell tied causes apart, from a simulation of each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.additions.memory import shows
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.additions.worth import MODEL_ERROR, Comparison, Tied, tied, usual_noise
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.finger.case import FingerCase
from dolfingrip.diagnosis.finger.exact import emulated, simulated
from dolfingrip.diagnosis.outcome import NextExperiment
from dolfingrip.diagnosis.simulation.nuisances import keys, neutral_stages, nuisances
from dolfingrip.diagnosis.simulation.routes import HEADROOM
from dolfingrip.diagnosis.simulation.simulated import Case, simulate
from dolfingrip.extensions.index import effect


def next_experiments(
    finger: FingerCase,
    posterior: Posterior,
    decision: Decision,
    say: Callable[[str], None],
) -> tuple[list[NextExperiment], list[str]]:
    """Additions that tell the tied hypotheses apart, the best first, and why some failed.

    Nothing where no other hypothesis is tied with the leading one.
    """
    fits = tied(posterior, decision)
    if len(fits) < 2:
        return [], []
    here = [Tied(fit.zeta, *emulated(finger, fit)) for _, fit in fits]
    comparison = Comparison.of([p for p, _ in fits], here, finger.case.covariance)
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
                Tied(fit.zeta, *simulated(finger, fit, proposal.measurement, mesh, rig=False))
                for _, fit in fits
            ]
            joint = _joint(finger, proposal, after[0].readings)
        except ConfigError as error:
            failed.append(f"{proposal.name} could not be judged: {error}")
            continue
        # along one loading a law with memory follows any elastic one, fitted anew
        seen = shows(simulation.measurement, proposal.measurement)
        unseen = (remembers[:, None] != remembers) & (not seen)
        found.append(comparison.worth(proposal, after, joint, unseen))
    return sorted(found, key=lambda worth: worth.rank), failed


def _joint(finger: FingerCase, proposal: Proposal, readings: np.ndarray) -> np.ndarray:
    """Covariance of the readings so far and of an addition's."""
    simulation = finger.simulation
    measurement = proposal.measurement
    config = simulation.config.overridden(() if proposal.known_mesh else simulation.flat)
    case = Case(neutral_stages(config), keys(measurement, config), headroom=HEADROOM)
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
    noise = usual_noise(simulation.measurement, finger.errors.noise, measurement)
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
