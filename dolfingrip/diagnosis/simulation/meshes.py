"""The graded mesh of the base simulation, and the ungraded one on which effects are tried.

An ungraded mesh takes a third of the time. What it gets wrong is wrong with and without an effect,
so that changes are taken between two simulations on it; a part of what grading changes
is a nuisance, for what the graded mesh still gets wrong.

Readings on the ungraded mesh are mapped to those on the graded one by an elastic curve. What a
coarse mesh gets wrong grows with the deformation, so it is taken at the same reading, not at the
same pressure: δ(y) = graded − ungraded along the base model's curve, where the ungraded one reads
y. A softer finger bends further and is off by more. With moduli c times as large a force is off by
c δ(F/c). Displacements of the tip, which turn round or stand still on the way, keep what they are
off by at their pressure.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from scipy.interpolate import PchipInterpolator

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import MODEL
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings

MAPPED: Final = frozenset(each.name for each in CHANNELS.values() if each.grows)
"""Readings that grow with the load."""


@dataclass(frozen=True)
class _Curve:
    """δ of some readings by their value: ``places`` in the list."""

    places: np.ndarray
    delta: PchipInterpolator
    in_proportion: bool


@dataclass
class MeshMap:
    """The map from ungraded to graded readings.

    Attributes:
        measurement: of all arrays.
        graded, plain: base model on both meshes.
    """

    measurement: Measurement
    graded: SimulatedReadings
    plain: SimulatedReadings
    _curves: list[_Curve] = field(init=False)

    def __post_init__(self) -> None:
        """Prepare the curves; what has none keeps the difference that it has at its pressure."""
        self._curves = []
        for fine, rough in zip(self.graded.runs, self.plain.runs, strict=True):
            if rough.schedule is not rough.group.curve:
                continue
            for name, places in self.measurement.places(rough.group.tests).items():
                if name not in MAPPED:
                    continue
                at = rough.result.columns.get(name, np.empty(0))
                values = fine.result.columns.get(name, np.empty(0))
                count = min(len(at), len(values))
                if rough.schedule.value[:count] != fine.schedule.value[:count]:
                    continue
                rising = _rising(at[:count])
                if rising is not None:
                    order, own = rising
                    smooth = PchipInterpolator(own, (values[:count] - at[:count])[order])
                    self._curves.append(_Curve(places, smooth, CHANNELS[name].in_proportion))

    def to_graded(
        self, readings: np.ndarray, jacobian: np.ndarray, factor: float = 1.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Readings, shape (n,), and derivatives, shape (n, p), as the graded mesh would have them.

        Args:
            readings, jacobian: on the ungraded mesh.
            factor: of all moduli.
        """
        found = readings + np.nan_to_num(self.graded.readings - self.plain.readings)
        slopes = jacobian.copy()
        for curve in self._curves:
            scale = factor if curve.in_proportion else 1.0
            own = readings[curve.places] / scale
            ends = curve.delta.x  # beyond them a straight line goes on
            inside = np.clip(own, ends[0], ends[-1])
            slope = curve.delta(inside, 1)
            delta = curve.delta(inside) + slope * (own - inside)
            found[curve.places] = readings[curve.places] + scale * delta
            slopes[curve.places] *= (1 + slope)[:, None]
        return found, slopes


def _rising(values: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Order in which values rise, and the values; None where the curve turns round."""
    if len(values) < 3:
        return None
    steps = np.diff(values)
    way = 1.0 if values[-1] > values[0] else -1.0
    if (way * steps < 0).any():
        return None
    order = np.arange(len(values)) if way > 0 else np.arange(len(values))[::-1]
    at = values[order]
    new = np.concatenate([[True], np.diff(at) > 1e-9 * max(float(np.ptp(at)), 1e-12)])
    return (order[new], at[new]) if new.sum() > 2 else None


def coarser(config: Config) -> list[Change]:
    """Changes to the meshes that causes may be simulated on, the coarsest first.

    The first is not graded at all, the last is the mesh as configured. Those between are for thick
    walls: of a cast block one element, 4 mm wide, does not bear 5 kPa.
    """
    if config.mesh.file is not None or not config.hexahedra:
        return [{}]
    size_mm, edge_mm = config.mesh.hexahedra_mm(config.geometry)
    between = [by * edge_mm for by in MODEL.edges if by * edge_mm < size_mm]
    sizes_mm = [size_mm, *between] if edge_mm < size_mm else []
    return [*({"mesh.edge_size_mm": each} for each in sizes_mm), {}]
