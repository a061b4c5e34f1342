"""Tied hypotheses of fingers at the readings of another experiment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dolfingrip.config import changed
from dolfingrip.diagnosis.additions.next_experiment import Then
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.additions.worth import Tied, shows_memory
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.finger.case import FingerCase
from dolfingrip.diagnosis.finger.exact import simulated
from dolfingrip.diagnosis.policy import ROUTES
from dolfingrip.diagnosis.simulation.nuisances import keys, neutral_stages, nuisances
from dolfingrip.diagnosis.simulation.simulated import Case, simulate
from dolfingrip.extensions.index import effect


def then(finger: FingerCase, proposal: Proposal, fits: Sequence[Fit]) -> Then:
    """Tied hypotheses at the readings of an addition, each simulated.

    Raises:
        ConfigError: one line, where a simulation does not reach all readings.
    """
    simulation = finger.simulation
    mesh = {} if proposal.known_mesh else simulation.flat
    # the rig's own errors are others then
    after = [
        Tied(fit.zeta, *simulated(finger, fit, proposal.measurement, mesh, rig=False))
        for fit in fits
    ]
    # along one loading a law with memory follows any elastic one, fitted anew
    seen = shows_memory(simulation.measurement, proposal.measurement)
    causes = finger.case.causes
    remembers = np.array(
        [any(effect(name).kind == "dissipative" for name in causes(fit.subset)) for fit in fits]
    )
    unseen = (remembers[:, None] != remembers) & (not seen)
    return after, *_covariances(finger, proposal), unseen


def _covariances(finger: FingerCase, proposal: Proposal) -> tuple[np.ndarray, np.ndarray]:
    """Of what nuisances change of an addition's readings, (m, m), and of these so far, (n, m)."""
    simulation = finger.simulation
    measurement = proposal.measurement
    config = changed(simulation.config, {} if proposal.known_mesh else simulation.flat)
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
