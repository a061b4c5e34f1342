"""By what each effect of the catalogue changes the readings, at its ordinary strength.

What a fit or a score by evidence needs of an effect is a :class:`Candidate`: the changes v of all
readings by the effect at its ordinary strength, in one shape or several. A strength s of it changes
the readings by about s v, with s of root mean square ``spread`` under the prior.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation import closed_forms, line_lag
from dolfingrip.diagnosis.simulation.simulated import Case, Simulated, SimulationFailure
from dolfingrip.diagnosis.simulation.strengths import TriedEffect, TriedShape, ordinary
from dolfingrip.extensions.index import effect

ROUNDING: Final = 1e-6
"""A change that is none, in a reading's unit."""

MeshName = Literal["graded", "ungraded"]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A cause that may explain what the base simulation gets wrong.

    Attributes:
        name: of the effect, a table of ``[extensions]``.
        kind: as in the catalogue: elastic, dissipative, geometry, set-up, loading, measurement, or
            numerical for a choice of the model.
        shapes: (k, n) changes of the readings at the ordinary strength, in each column's unit; k
            may be 0 where all simulations failed.
        labels: (k,) parameters of each shape, for people.
        overrides: (k,) the same as with ``--set``: where a fit starts.
        parts: (k,) strength that was simulated by the ordinary one, to which shapes are scaled.
        spread: root mean square of the strength under the prior, by the ordinary strength.
        one_sided: whether the strength cannot be below 0.
        mesh: that the changes were computed on.
        failures: of its simulations.
    """

    name: str
    kind: str
    shapes: np.ndarray
    labels: tuple[str, ...]
    overrides: tuple[tuple[str, ...], ...]
    parts: tuple[float, ...]
    spread: float
    one_sided: bool
    mesh: MeshName
    failures: Sequence[SimulationFailure] = ()

    @property
    def felt(self) -> bool:
        """Whether any reading changes."""
        return bool(np.abs(self.shapes).max(initial=0.0) > ROUNDING)


def felt_in(name: str, config: Config) -> frozenset[str]:
    """Experiments that can feel an effect: elsewhere it needs no simulation.

    A coupon feels what is in the material.
    """
    found = {"blocked_force"}
    if effect(name).felt_in_bending(config):
        found.add("bending")
    if effect(name).has("strain_energy"):
        found.add("coupon")
    return frozenset(found)


def tried_effects(config: Config, effects: Collection[str] | None = None) -> list[TriedEffect]:
    """What is tried beside ``config``: all effects of the catalogue, or those in ``effects``."""
    return [each for each in ordinary(config) if effects is None or each.effect in effects]


def cases(tried: TriedEffect, config: Config, mesh: tuple[str, ...]) -> list[Case]:
    """The simulations of an effect; none where the base simulation tells its change.

    Args:
        tried: the effect.
        config: without it, with the laboratory's gravity.
        mesh: overrides of the mesh that effects are tried on.
    """
    if closed_forms.has_closed_form(tried.effect) or line_lag.serves(tried.effect, config):
        return []
    only_in = felt_in(tried.effect, config)
    return [
        Case((*mesh, *shape.overrides), only_in=only_in, elsewhere=mesh, tilt_deg=shape.tilt_deg)
        for shape in tried.shapes
    ]


def candidate(
    measurement: Measurement,
    config: Config,
    tried: TriedEffect,
    graded: Simulated,
    same_mesh: Simulated,
    simulated: Sequence[Simulated],
    mesh: MeshName,
) -> Candidate:
    """The candidate of an effect.

    Args:
        measurement: of all arrays.
        config: without the effect.
        tried: the effect.
        graded: base simulation with gradients, for what follows from it alone.
        same_mesh: base simulation on the mesh of ``simulated``.
        simulated: its :func:`cases`, in order.
        mesh: theirs.
    """
    if not simulated:
        shapes = _told(measurement, config, tried, graded)
        return _made(tried, list(tried.shapes), list(shapes), "graded", ())
    kept: list[TriedShape] = []
    changes: list[np.ndarray] = []
    failures: list[SimulationFailure] = []
    for shape, run in zip(tried.shapes, simulated, strict=True):
        failures += run.failures
        change = (run.readings - same_mesh.readings) / shape.part
        if not np.isnan(change[~np.isnan(same_mesh.readings)]).any():
            kept.append(shape)
            changes.append(np.nan_to_num(change))
    return _made(tried, kept, changes, mesh, failures)


def _told(
    measurement: Measurement, config: Config, tried: TriedEffect, base: Simulated
) -> np.ndarray:
    """(k, n) changes that follow from the base simulation alone."""
    if not line_lag.is_stage(tried.effect):
        return closed_forms.changes(measurement, config, base, tried)
    return np.array(
        [
            line_lag.change(
                measurement,
                base,
                getattr(config.overridden(shape.overrides).extensions, tried.effect),
            )
            / shape.part
            for shape in tried.shapes
        ]
    )


def _made(
    tried: TriedEffect,
    shapes: Sequence[TriedShape],
    changes: Sequence[np.ndarray],
    mesh: MeshName,
    failures: Sequence[SimulationFailure],
) -> Candidate:
    return Candidate(
        tried.effect,
        tried.kind,
        np.array(changes) if len(changes) else np.zeros((0, 0)),
        tuple(shape.label for shape in shapes),
        tuple(shape.overrides for shape in shapes),
        tuple(shape.part for shape in shapes),
        tried.spread,
        tried.one_sided,
        mesh,
        tuple(failures),
    )
