"""Which further experiment would tell tied causes apart, from a simulation of each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.additions.worth import Comparison, Tied, shows_memory, tied
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.finger.case import FingerCase
from dolfingrip.diagnosis.finger.exact import emulated, simulated
from dolfingrip.diagnosis.outcome import NextExperiment
from dolfingrip.diagnosis.policy import ROUTES
from dolfingrip.diagnosis.simulation.nuisances import keys, neutral_stages, nuisances
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
    simulation = finger.simulation
    comparison = Comparison(
        simulation.measurement, finger.errors.noise, finger.case.covariance,
        np.array([p for p, _ in fits]), [Tied(fit.zeta, *emulated(finger, fit)) for _, fit in fits],
    )  # fmt: skip
    remembers = np.array(
        [
            any(effect(n).kind == "dissipative" for n in finger.case.causes(fit.subset))
            for _, fit in fits
        ]
    )
    found, failed = [], []
    for proposal in proposals(simulation.measurement, simulation.config):
        say(f"next experiment: {proposal.name}")
        try:
            mesh = () if proposal.known_mesh else simulation.flat
            # the rig's own errors are others then
            after = [
                Tied(fit.zeta, *simulated(finger, fit, proposal.measurement, mesh, rig=False))
                for _, fit in fits
            ]
            shared, cross = _covariances(finger, proposal)
        except ConfigError as error:
            failed.append(f"{proposal.name} could not be judged: {error}")
            continue
        # along one loading a law with memory follows any elastic one, fitted anew
        seen = shows_memory(simulation.measurement, proposal.measurement)
        unseen = (remembers[:, None] != remembers) & (not seen)
        found.append(comparison.worth(proposal, after, shared, cross, unseen))
    return sorted(found, key=lambda worth: worth.rank), failed


def _covariances(finger: FingerCase, proposal: Proposal) -> tuple[np.ndarray, np.ndarray]:
    """Of what nuisances change of an addition's readings, (m, m), and of these so far, (n, m)."""
    simulation = finger.simulation
    measurement = proposal.measurement
    config = simulation.config.overridden(() if proposal.known_mesh else simulation.flat)
    case = Case(neutral_stages(config), keys(measurement, config), headroom=ROUTES.headroom)
    (base,) = simulate(measurement, config, [case], simulation.workers)
    fitted = {"modulus", *(["wall"] if finger.wall_std else [])}
    old = {each.name: each.change for each in finger.errors.shared}
    n, m = len(finger.case.value), len(base.readings)
    shared, cross = np.zeros((m, m)), np.zeros((n, m))
    for each in nuisances(measurement, base):
        if each.name in fitted:
            continue
        change = np.nan_to_num(each.change)
        shared += np.outer(change, change)
        if each.name in old and not each.name.startswith("plate_gap"):  # that is set once more
            cross += np.outer(old[each.name], change)
    return shared, cross
