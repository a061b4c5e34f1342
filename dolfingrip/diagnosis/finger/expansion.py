"""What causes change, by derivatives of the model where they do nothing.

A cause that stiffens the body does first what stiffer moduli do, and those are known exactly. With
amplitudes v, derivatives J by these, and J₀ that of the model by the logarithm of its moduli c,

    y(c; v) ≈ y(c s; 0) + (J − J₀ κᵀ) v / s,    s = 1 + κ·v,

where J₀ κᵀ is the part of J that moduli do best, by least squares of the readings. The polynomial
law at its prior's means changes the reference finger's readings by 76 standard deviations of the
noise; J v is 33 of them off, and this is 2.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from dolfingrip.diagnosis.core.emulator import SimulatedChanges
from dolfingrip.diagnosis.core.unknown import Cause, Unknown
from dolfingrip.diagnosis.finger.model import FingerSimulation
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, SimulatedReadings, simulate

STEP: Final = 1e-3
"""Of differences of ln c, and of ζ."""

SOFTEST: Final = 0.5
"""Least s that is taken: with still softer moduli a finger may lose its equilibrium."""


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
    def _model(self) -> list[tuple[float, np.ndarray, np.ndarray]]:
        """At each node c, readings of the model, (n,), and their derivatives by ln c, (n,)."""
        at, found = self.simulation.graded_at, []
        for c in map(float, self.factor.at(self.nodes)):
            more, less = (at(c * np.exp(sign * STEP)) for sign in (1, -1))
            found.append((c, at(c), (more - less) / (2 * STEP)))
        return found

    def slopes(self, cause: Cause) -> np.ndarray:
        """(nodes, amplitudes, n) derivatives by the amplitudes, for each unit of these."""
        simulation, found = self.simulation, []
        amplitudes = [number for number in cause.numbers if number.amplitude]
        for c, *_ in self._model:
            by = c / simulation.centre
            own = [
                simulation.read(self.run, by, number.gradient)
                * (simulation.centre if number.modulus else 1.0)
                for number in amplitudes
            ]
            readings = simulation.read(self.run, by)
            found.append(simulation.graded(readings, c, np.column_stack(own))[1].T)
        return np.array(found)

    def changes(
        self, cause: Cause, zeta: np.ndarray, experiments: frozenset[str]
    ) -> SimulatedChanges | None:
        """Return what a cause changes; None where that is not known.

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
        if not np.isfinite(told).all():
            return None
        slopes = (told[:, :, 1 : d + 1] - told[:, :, d + 1 :]) / (2 * STEP)
        slopes[:, :, [not number.amplitude for number in cause.numbers]] = np.nan
        return SimulatedChanges(zeta, told[:, :, 0], slopes, self.nodes)

    def _moved(self, node: int, slopes: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(n,) change by amplitudes v, (a,), of which slopes are the derivatives, (a, n)."""
        c, base, stiffer = self._model[node]
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
