"""Changes by causes that follow from the model without them: no simulation is needed.

An instrument's error follows from the readings themselves, a stage of the supply and a modulus that
drifts from the elastic curve, and relaxation nearly does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from dolfingrip.channels import TIME
from dolfingrip.config import changed
from dolfingrip.diagnosis.core.emulator import Emulator
from dolfingrip.diagnosis.core.polynomial import SimulatedChanges, places, trained
from dolfingrip.diagnosis.core.unknown import Cause, Factor
from dolfingrip.diagnosis.finger.simulation import FingerSimulation
from dolfingrip.diagnosis.finger.unknowns import box_of
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation import elastic_curve
from dolfingrip.diagnosis.simulation.simulated import SimulatedGroup
from dolfingrip.extensions.effect import Displaying, Drifting, Relaxing, Stage
from dolfingrip.extensions.index import effect


def known(simulation: FingerSimulation, cause: Cause) -> bool:
    """Tell whether there is a closed form; those by the elastic curve need that moduli scale it."""
    kind = effect(cause.name)
    by_curve = issubclass(kind, Stage | Drifting)
    return issubclass(kind, Displaying) or (by_curve and simulation.scales)


def simulations(
    simulation: FingerSimulation, cause: Cause, nodes: np.ndarray, factor: Factor
) -> SimulatedChanges:
    """Compute what a cause changes, as if it had been simulated.

    Args:
        simulation: of the model without it.
        cause: of which a closed form is :func:`known`.
        nodes: ζ of the moduli.
        factor: of all moduli by that ζ.
    """
    box = np.clip(box_of(cause), -POLICY.finger_reach, POLICY.finger_reach)
    zeta = places(box, 5 * POLICY.closed_form_places)
    if len(box) == 1:
        zeta = np.linspace(float(box[0, 0]), float(box[0, 1]), POLICY.closed_form_places)[:, None]
    values = []
    for node in nodes:
        c = float(factor(node))
        rows = simulation.base_rows(c) if issubclass(effect(cause.name), Displaying) else []
        values.append([_changed(simulation, cause, z, c, rows) for z in zeta])
    told = np.array(values)
    slopes = np.full((*told.shape[:2], len(box), told.shape[2]), np.nan)
    return SimulatedChanges(zeta, np.nan_to_num(told), slopes, nodes)


def _changed(
    simulation: FingerSimulation,
    cause: Cause,
    zeta: np.ndarray,
    c: float,
    rows: Sequence[dict[str, np.ndarray]],
) -> np.ndarray:
    config = changed(simulation.applied, cause.overrides(zeta))
    on: Any = getattr(config.extensions, cause.name)
    if rows:
        return simulation.listed([
            _displayed(simulation, run, on, own)
            for run, own in zip(simulation.base.runs, rows, strict=True)
        ])  # fmt: skip
    base, by = simulation.base, c / simulation.centre
    if isinstance(on, Drifting):
        return elastic_curve.drifted(simulation.measurement, base, on, by)
    behind = partial(elastic_curve.behind, on)
    return elastic_curve.change(simulation.measurement, base, behind, by)


def _displayed(
    simulation: FingerSimulation, run: SimulatedGroup, on: Displaying, own: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Changes of a run's readings at the measured rows by an instrument, by column."""
    test, way = simulation.measurement.readings["test"].to_numpy(), run.group.in_time
    true = {**own, TIME.name: way.at_rows(np.array(way.time_s), len(test))}
    found = {name: np.full(len(test), np.nan) for name in own}
    for number in run.group.tests:
        mine = test == number
        displayed = on.reading({name: told[mine] for name, told in true.items()})
        for name, change in found.items():
            change[mine] = displayed.get(name, own[name][mine]) - own[name][mine]
    return found


def approximate(
    simulation: FingerSimulation,
    cause: Cause,
    scale: np.ndarray,
    factor: Factor,
    moduli: tuple[float, float],
) -> Emulator | None:
    """Emulate a cause by an approximate law, which simulations correct.

    Args:
        simulation: of the model without it.
        cause: whose change it is.
        scale: noise of the readings, shape (n,).
        factor: of all moduli by their ζ.
        moduli: range of that ζ.

    Returns:
        The law as an emulator; None where there is none.
    """
    if not issubclass(effect(cause.name), Relaxing) or not simulation.scales:
        return None
    box = np.vstack([moduli, box_of(cause)])
    zeta = places(box, POLICY.tabulated)
    changes = []
    for z in zeta:
        config = changed(simulation.applied, cause.overrides(z[1:]))
        viscous: Any = getattr(config.extensions, cause.name)
        c = float(factor(z[0]))
        changes.append(
            elastic_curve.viscous_change(
                simulation.measurement, simulation.base, viscous, c / simulation.centre
            )
        )
    return replace(trained(zeta, np.nan_to_num(np.array(changes)), scale, box), takes=(0,))
