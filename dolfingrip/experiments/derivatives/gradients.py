"""Derivatives by the parameters of a finger's shape: of its centre of gravity, and of readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.experiments.derivatives.adjoints import FingerAdjoints
from dolfingrip.experiments.derivatives.sensitivities import Sensitivities, chosen
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.results.sensitivity_table import COLUMNS
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.perturbation import velocities
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.experiments.rigs.undeformed import solid, unplaced
from dolfingrip.extensions.effect import Displaying
from dolfingrip.meshes.measures import centroid_gradients, moment_gradients, moments
from dolfingrip.meshes.solid import Floats, SolidMesh
from dolfingrip.parameter import Entry, Parameter, find

XI = ("morph.xi1", "morph.xi2")

G_PER_MM3: Final = 1e-6
"""Grams of a cubic millimetre of 1 kg/m³."""


COG, MASS = "cog_offset_mm", "mass_g"
"""Numbers of the unloaded shape."""


class MassProperties:
    """Mass of the whole finger and offset of its centre of gravity, by the mesh.

    Args:
        mesh: of the finger, or of its half.
        config: its density, and the place that the offset is told from.
    """

    def __init__(self, mesh: SolidMesh, config: Config) -> None:
        self._mesh, self._config = mesh, config
        self._volume, self._moment = moments(mesh)
        copies = 2 if "symmetry" in mesh.facets else 1
        self._density = copies * config.material.density_kg_m3 * G_PER_MM3

    def value(self, name: str) -> float:
        """The mass (g), or the offset (mm)."""
        if name == MASS:
            return self._volume * self._density
        return float(self._moment[0] / self._volume) - self._config.cog.x_ref_mm

    def slopes(self, name: str, moving: Mapping[str, Floats]) -> dict[str, float]:
        """Derivatives by parameters that move the points, and that of the mass by the density.

        Args:
            name: of the number.
            moving: velocities of the points, shape (n, 3), by key of the parameter.
        """
        slopes = {}
        if moving and name == MASS:
            by_points = moment_gradients(self._mesh)[0] * self._density
        elif moving:
            by_points = centroid_gradients(self._mesh)[0]
        for key, velocity in moving.items():
            slopes[key] = float(np.vdot(by_points, velocity))
        if name == MASS:
            slopes["material.density_kg_m3"] = (
                self.value(name) / self._config.material.density_kg_m3
            )
        return slopes


def shape_number(
    name: str, config: Config, parameters: Sequence[Parameter] | None = None
) -> tuple[float, dict[str, float]]:
    """Compute a number of the unloaded finger, and its derivatives.

    Args:
        name: :data:`COG`, the offset of the centre of gravity (mm), or :data:`MASS` (g).
        config: configuration of the finger.
        parameters: parameters that it is derived by; None: ξ1 and ξ2.

    Returns:
        The number, and its derivatives by the parameters' keys, for each unit of the parameter.

    Raises:
        MeshError: one line, if no finger has these dimensions.
    """
    if parameters is None:
        parameters = find(config, XI)
    mesh = solid(config)
    shaped = [p for p in parameters if p.entry is Entry.SHAPE]
    moving = velocities(shaped, config, unplaced(mesh.points, config)) if shaped else {}
    mass = MassProperties(mesh, config)
    slopes = mass.slopes(name, moving) if parameters else {}
    return mass.value(name), {p.key: slopes.get(p.key, 0.0) for p in parameters}


def by_adjoint(config: Config) -> bool:
    """Tell whether adjoints give derivatives by ξ1 and ξ2 at the highest pressure.

    They do not where the volume is prescribed, as the highest pressure is then known at the end
    only, nor with inertia and effects that remember earlier states, or that distort readings.

    Args:
        config: of the simulation.

    Returns:
        Whether they do.
    """
    adapted = config.adapted()
    remembers = any(effect.remembers() for effect in adapted.extensions.active())
    distorted = adapted.extensions.active(Displaying)
    at_rest = adapted.experiment.control == "pressure" and not adapted.experiment.dynamic
    return at_rest and not remembers and not distorted


class AtHighest:
    """Collects derivatives at the stop of highest pressure, by adjoints.

    Args:
        rig: of a finger.
        row: of that stop in the result, from 0 on.
        parameters: that readings are derived by.
        columns: readings that are derived, where they can be.

    Attributes:
        rows: one row for each column and parameter, by
            :data:`~dolfingrip.experiments.derivatives.sensitivities.COLUMNS`.
    """

    def __init__(
        self, rig: Rig, row: int, parameters: Sequence[Parameter], columns: Sequence[str]
    ) -> None:
        self._rig, self._row = rig, row
        self._parameters, self._columns = parameters, columns
        self.rows: list[dict[str, int | float | str]] = []

    def record(self, row: int) -> None:
        """Derive the readings of the present stop if it is that of highest pressure."""
        if row != self._row:
            return
        finger: FingerModel = self._rig.specimen
        readings = self._rig.readings.items()
        wanted = [one for name, one in readings if name in self._columns and one.differentiable]
        slopes = FingerAdjoints(finger, wanted).by_parameters(finger.config, self._parameters)
        for column, by_key in slopes.items():
            for key, slope in by_key.items():
                self.rows.append(dict(zip(COLUMNS, (row, column, key, slope), strict=True)))


def collectors(
    rig: Rig,
    config: Config,
    keys: Sequence[str],
    stops: Sequence[Stop] | None,
    columns: Sequence[str],
) -> list[Sensitivities | AtHighest]:
    """Return what collects the derivatives of a rig's readings as its path goes on.

    Args:
        rig: at its start.
        config: that the rig was prepared from.
        keys: of parameters, and of choices of the model, which are left out; (): all parameters.
        stops: of the path, where derivatives are wanted at the highest pressure alone; None: at
            every stop.
        columns: readings that are derived at the highest pressure.

    Returns:
        Adjoints for what they give, and derivatives along the path for the rest.

    Raises:
        ConfigError: one line about a key.
    """
    parameters = chosen(config, keys)
    derived: list[Sensitivities | AtHighest] = []
    if stops is not None and by_adjoint(config):
        adjoint = [parameter for parameter in parameters if parameter.key in XI]
        parameters = [parameter for parameter in parameters if parameter.key not in XI]
        highest = max(range(len(stops)), key=lambda i: stops[i].value)
        if adjoint:
            derived.append(AtHighest(rig, highest, adjoint, columns))
    if parameters:
        derived.append(Sensitivities(rig, config, parameters))
    return derived
