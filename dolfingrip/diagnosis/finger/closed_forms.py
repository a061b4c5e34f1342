"""Changes by causes that follow from the model without them, or from its derivatives.

An instrument's error follows from the readings themselves, a stage of the supply and a modulus that
drifts from the elastic curve, and relaxation nearly does.

A finger without memory, friction and clock turns and presses as the pressure in its cavity tells,
however that came about. So does a coupon with its travel. With all moduli c times as large the
readings are those at the pressure p/c, and c times those of a force
(:mod:`dolfingrip.diagnosis.simulation.simulated`).

Viscosity is another load, nearly: quasi-linear viscoelasticity.

All stresses of a body follow from its elastic ones by the same linear law of relaxation
(Fung, Biomechanics, Springer 1993, sect. 7.6), with branches of the parts gᵢ and times τᵢ

    σ(t) = σ_el(t) + Σ rᵢ vᵢ(t),    vᵢ' = σ_el' − vᵢ/τᵢ,    rᵢ = gᵢ/(1 − Σ g).

So do the loads that hold it in balance: the pressure p and the blocked force F are those of an
elastic body, q and F_el(q), relaxed. A finger under the pressure p turns as an elastic one under q:

    α(t) = α_el(q(t)),    F(t) = F_el(q(t)) + Σ rᵢ vᵢ(t),    p = q + Σ rᵢ wᵢ,  wᵢ' = q' − wᵢ/τᵢ.

A coupon's travel is given, so its force is that of the elastic coupon, relaxed. Contact, large
rotations and the network of :mod:`dolfingrip.forms.transient_network` are not linear. A blocked
finger does not follow the elastic load, so that its contact opens otherwise in unloading: the law
is near in free bending, and off in a blocked force. Simulations correct it
(:func:`approximate`); nothing is judged by it alone.

Causes that moduli scale follow from derivatives by their amplitudes v where they do nothing, nearly
(:class:`Expansion`). One that stiffens the body does first what stiffer moduli do. With derivatives
J by v, and J₀ by the logarithm of the moduli c,

    y(c; v) ≈ y(c s; 0) + (J − J₀ κᵀ) v / s,    s = 1 + κ·v,

where J₀ κᵀ is the part of J that moduli do best, by least squares of the readings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from dolfingrip.channels import CHANNELS, PRESSURE, TIME
from dolfingrip.config import changed
from dolfingrip.diagnosis.core.emulator import Emulator, SimulatedChanges, places, trained
from dolfingrip.diagnosis.core.unknown import Cause, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, Rows
from dolfingrip.diagnosis.finger.model import FingerSimulation, even, spread
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.simulated import (
    ModelVariant,
    SimulatedGroup,
    SimulatedReadings,
    simulate,
)
from dolfingrip.diagnosis.simulation.stops import StopSchedule
from dolfingrip.extensions.effect import Displaying, Drifting, Flow, Relaxing, Stage
from dolfingrip.extensions.index import effect

STEP: Final = 1e-3
"""Of differences of ζ."""

SOFTEST: Final = 0.5
"""Least s that is taken: with still softer moduli a finger may lose its equilibrium."""


def known(simulation: FingerSimulation, cause: Cause) -> bool:
    """Tell whether there is a closed form; those by the elastic curve need that moduli scale it."""
    kind = effect(cause.name)
    by_curve = issubclass(kind, Stage | Drifting)
    return issubclass(kind, Displaying) or (by_curve and simulation.scales)


def simulations(
    simulation: FingerSimulation,
    cause: Cause,
    box: np.ndarray,
    nodes: np.ndarray,
    factor: Unknown,
) -> SimulatedChanges:
    """Compute what a cause changes, as if it had been simulated.

    Args:
        simulation: of the model without it.
        cause: of which a closed form is :func:`known`.
        box: ranges of its numbers' ζ, (d, 2).
        nodes: ζ of the moduli.
        factor: of all moduli by that ζ.
    """
    reach = np.abs(box).max(axis=1, keepdims=True) - POLICY.read_beyond
    box = np.clip(box, -reach, reach)
    zeta = places(box, 5 * POLICY.closed_form_places)
    if len(box) == 1:
        low, high = map(float, even(box[0]))
        zeta = spread(np.linspace(low, high, POLICY.closed_form_places))[:, None]
    values = []
    for node in nodes:
        c = float(factor.at(node))
        rows = simulation.base_rows(c) if issubclass(effect(cause.name), Displaying) else {}
        values.append([_changed(simulation, cause, z, c, rows) for z in zeta])
    told = np.array(values)
    slopes = np.full((*told.shape[:2], len(box), told.shape[2]), np.nan)
    return SimulatedChanges(zeta, np.nan_to_num(told), slopes, nodes)


def _changed(
    simulation: FingerSimulation,
    cause: Cause,
    zeta: np.ndarray,
    c: float,
    rows: Rows,
) -> np.ndarray:
    config = changed(simulation.applied, cause.overrides(zeta))
    on: Any = getattr(config.extensions, cause.name)
    if rows:
        return simulation.measurement.collected(
            {
                run.group.tests: _displayed(simulation, run, on, rows[run.group.tests])
                for run in simulation.base.runs
            }
        )
    return change(simulation.measurement, simulation.base, on, c / simulation.centre)


def _displayed(
    simulation: FingerSimulation, run: SimulatedGroup, on: Displaying, own: Mapping[str, np.ndarray]
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
    box: np.ndarray,
    scale: np.ndarray,
    factor: Unknown,
) -> Emulator | None:
    """Emulate a cause by an approximate law, which simulations correct.

    Args:
        simulation: of the model without it.
        cause: whose change it is.
        box: ranges of the moduli's ζ and of its numbers', (1 + d, 2).
        scale: noise of the readings, shape (n,).
        factor: of all moduli by their ζ.

    Returns:
        The law as an emulator; None where there is none.
    """
    if not issubclass(effect(cause.name), Relaxing) or not simulation.scales:
        return None
    zeta = places(box, POLICY.tabulated)
    changes = []
    for z in zeta:
        config = changed(simulation.applied, cause.overrides(z[1:]))
        viscous: Any = getattr(config.extensions, cause.name)
        c = float(factor.at(z[0]))
        by = c / simulation.centre
        changes.append(change(simulation.measurement, simulation.base, viscous, by))
    return trained(zeta, np.nan_to_num(np.array(changes)), scale, box)


def change(
    measurement: Measurement,
    base: SimulatedReadings,
    on: Stage | Drifting | Relaxing,
    factor: float = 1.0,
) -> np.ndarray:
    """(n,) change of the readings by an effect that is another load on an elastic body.

    Args:
        measurement: that ``base`` was simulated for.
        base: without memory and clock.
        on: the effect; the travel of a coupon is what it is.
        factor: of all moduli; other than 1 where these scale.
    """
    found: dict[tuple[int, ...], dict[str, np.ndarray]] = {}
    for run in base.runs:
        way = run.group.in_time
        (curve,) = run.schedule.legs
        here = there = np.array(way.value)
        if way.control == PRESSURE.name:
            here, there = here / factor, _elastic(on, way) / factor
        own = found[run.group.tests] = {}
        for name in measurement.places(run.group.tests):
            values = run.result.columns.get(name, np.empty(0))
            if not values.size:
                continue
            load = CHANNELS[name].in_proportion
            size = factor if load else 1.0
            force = run.force(name)
            elastic, readings = (size * curve.read(values, at, force) for at in (here, there))
            if load:
                readings = _real(on, way, readings)
            own[name] = way.at_rows(readings - elastic, len(measurement.readings))
    return measurement.collected(found, 0.0)


def _elastic(on: Stage | Drifting | Relaxing, way: StopSchedule) -> np.ndarray:
    """(stops,) pressure that an elastic body has to bear to be as the real one is, in kPa."""
    time_s, value = np.array(way.time_s), np.array(way.value)
    if isinstance(on, Drifting):
        return value / on.moduli_at(time_s)
    if isinstance(on, Relaxing):
        return relaxed(on, time_s, value, inverse=True)
    return behind(on, way)


def _real(on: Stage | Drifting | Relaxing, way: StopSchedule, elastic: np.ndarray) -> np.ndarray:
    """(stops,) forces by those of the elastic body."""
    time_s = np.array(way.time_s)
    if isinstance(on, Drifting):
        return on.moduli_at(time_s) * elastic
    return relaxed(on, time_s, elastic) if isinstance(on, Relaxing) else elastic


def behind(stage: Stage, way: StopSchedule) -> np.ndarray:
    """(stops,) pressure behind a stage of the supply along a way that begins at rest, in kPa."""
    found = []
    time_s, inlet_kPa, outlet_kPa = 0.0, 0.0, 0.0
    for moment_s, now_kPa in zip(way.time_s, way.value, strict=True):
        flow = Flow(inlet_kPa, now_kPa, outlet_kPa, moment_s, moment_s - time_s)
        outlet_kPa = stage.outlet_kPa(flow)
        time_s, inlet_kPa = moment_s, now_kPa
        found.append(outlet_kPa)
    return np.array(found)


def relaxed(
    viscous: Relaxing, time_s: np.ndarray, load: np.ndarray, *, inverse: bool = False
) -> np.ndarray:
    """(stops,) a load from the elastic one, straight between stops, at rest before the first.

    Args:
        viscous: Maxwell branches.
        time_s: of each stop, shape (stops,).
        load: the elastic one, shape (stops,).
        inverse: compute the elastic load that relaxes to ``load``.
    """
    parts, times_s = map(np.array, viscous.branches())
    ratio, stress = parts / (1 - parts.sum()), np.zeros(len(parts))
    before_s = before = 0.0
    found = []
    for moment_s, value in zip(time_s, load, strict=True):
        part = (moment_s - before_s) / times_s
        stress = stress * np.exp(-part)
        # the mean of exp(-t/τ) over the step: what is left of a load that grows along it
        kept = np.where(part > 0, -np.expm1(-part) / np.where(part > 0, part, 1.0), 1.0)
        elastic = float(value)
        if inverse:
            rest = elastic - float(ratio @ (stress - kept * before))
            elastic = rest / (1 + float(ratio @ kept))
        stress = stress + kept * (elastic - before)
        found.append(elastic if inverse else elastic + float(ratio @ stress))
        before_s, before = moment_s, elastic
    return np.array(found)


@dataclass(frozen=True, eq=False)
class Expansion:
    """Changes by causes about a simulation of the model in which all of them do nothing.

    Attributes:
        simulation: of the model without causes.
        run: its readings, with derivatives by the amplitudes of the causes.
        nodes: ζ of the moduli that it is read at.
        factor: c by it.
        scale: noise of the readings, (n,).
    """

    simulation: FingerSimulation
    run: SimulatedReadings
    nodes: np.ndarray
    factor: Unknown
    scale: np.ndarray

    @classmethod
    def about(
        cls, simulation: FingerSimulation, causes: Sequence[Cause], experiments: frozenset[str],
        nodes: np.ndarray, factor: Unknown, scale: np.ndarray,
    ) -> Expansion:  # fmt: skip
        """Simulate the model with derivatives by the amplitudes of causes, which moduli scale.

        Args:
            simulation: of the model.
            causes: that are expanded.
            experiments: that can feel one of them.
            nodes, factor, scale: as above.

        Raises:
            ConfigError: one line, where there are no workers or a store is in use.
        """
        values = {**simulation.flat, **simulation.moduli(simulation.centre)}
        for each in causes:
            values |= each.resting(simulation.centre)
        keys = [n.gradient for each in causes for n in each.numbers if n.amplitude]
        variant = ModelVariant(
            values, tuple(keys), headroom=simulation.headroom, only_in=experiments
        )
        (run,) = simulate(simulation.measurement, simulation.config, [variant], simulation.workers)
        return cls(simulation, run, nodes, factor, scale)

    @cached_property
    def _model(self) -> list[tuple[float, np.ndarray, np.ndarray, np.ndarray]]:
        """At each node c, readings of the run, of the graded mesh, and these by ln c, (n,) each."""
        simulation = self.simulation
        return [
            (
                c, simulation.read(self.run, c / simulation.centre), simulation.graded_at(c),
                simulation.graded_by_log(c),
            )
            for c in map(float, self.factor.at(self.nodes))
        ]  # fmt: skip

    def slopes(self, cause: Cause) -> np.ndarray:
        """Return derivatives by a cause's amplitudes, for each unit of these.

        Args:
            cause: one of those that were expanded.

        Returns:
            Shape (nodes, amplitudes, n).
        """
        simulation, found = self.simulation, []
        amplitudes = [number for number in cause.numbers if number.amplitude]
        for c, readings, *_ in self._model:
            own = [
                simulation.read(self.run, c / simulation.centre, number.gradient)
                * (simulation.centre if number.modulus else 1.0)
                for number in amplitudes
            ]
            found.append(simulation.graded(readings, c, np.column_stack(own))[1].T)
        return np.array(found)

    def changes(
        self, cause: Cause, zeta: np.ndarray, experiments: frozenset[str]
    ) -> SimulatedChanges:
        """Return what a cause changes; NaN where the run does not come to a reading.

        Args:
            cause: one of those that were expanded.
            zeta: places, (places, d).
            experiments: that can feel it.
        """
        d = len(cause.numbers)
        steps = STEP * np.vstack([np.zeros(d), np.eye(d), -np.eye(d)])
        felt = self.simulation.measurement.listed["experiment"].isin(experiments).to_numpy()
        told = np.array([
            [[self._moved(node, own * felt, _amplitudes(cause, place + e)) for e in steps]
             for place in zeta]
            for node, own in enumerate(self.slopes(cause))
        ])  # fmt: skip
        told = np.where(felt, told, 0.0)
        slopes = (told[:, :, 1 : d + 1] - told[:, :, d + 1 :]) / (2 * STEP)
        slopes[:, :, [not number.amplitude for number in cause.numbers]] = np.nan
        return SimulatedChanges(zeta, told[:, :, 0], slopes, self.nodes)

    def _moved(self, node: int, slopes: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(n,) change by amplitudes v, (a,), of which slopes are the derivatives, (a, n)."""
        c, _, base, stiffer = self._model[node]
        white = slopes / self.scale
        by_modulus = np.where(slopes.any(axis=0), stiffer / self.scale, 0.0)
        share = white @ by_modulus / max(float(by_modulus @ by_modulus), 1e-300)
        s = max(1.0 + float(share @ v), SOFTEST)
        other = v @ (slopes - np.outer(share, stiffer))
        return np.asarray(self.simulation.graded_at(c * s) - base + other / s)


def _amplitudes(cause: Cause, zeta: np.ndarray) -> np.ndarray:
    """(a,) amplitudes at ζ, (d,), from where they do nothing."""
    return np.array([
        float(number.at(z)) - cause.neutral(number)
        for number, z in zip(cause.numbers, zeta, strict=True)
        if number.amplitude
    ])  # fmt: skip
