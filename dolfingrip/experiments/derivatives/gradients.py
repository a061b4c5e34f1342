"""Derivatives of a finger's readings by its morph's parameters ξ1 and ξ2."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from dolfingrip.config import Config
from dolfingrip.experiments.derivatives.adjoints import FingerAdjoints
from dolfingrip.experiments.results.readings import Row
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.perturbation import velocities
from dolfingrip.experiments.rigs.undeformed import solid, unplaced
from dolfingrip.mechanics.readings.from_rest import FromRest
from dolfingrip.mechanics.readings.plate import PlateForce
from dolfingrip.mechanics.readings.tip import FaceAngle
from dolfingrip.meshes.measures import centroid, centroid_rate
from dolfingrip.parameter import Entry, Parameter, find

XI = ("morph.xi1", "morph.xi2")


def cog_offset_mm(
    config: Config, parameters: Sequence[Parameter] | None = None
) -> tuple[float, dict[str, float]]:
    """Offset of the undeformed finger's centre of gravity, and its derivatives.

    Args:
        config: configuration of the finger.
        parameters: parameters that the offset is derived by; None: ξ1 and ξ2.

    Returns:
        The offset (mm), and its derivatives by the parameters' keys (mm for each unit of the
        parameter).

    Raises:
        MeshError: one line, if no finger has these dimensions.
    """
    if parameters is None:
        parameters = find(config, XI)
    mesh = solid(config)
    offset = float(centroid(mesh)[0]) - config.cog.x_ref_mm
    shaped = [each for each in parameters if each.entry is Entry.SHAPE]
    moving = velocities(shaped, config, unplaced(mesh.points, config)) if shaped else {}
    slopes = {key: float(centroid_rate(mesh, each)[0]) for key, each in moving.items()}
    return offset, {each.key: slopes.get(each.key, 0.0) for each in parameters}


def by_adjoint(config: Config) -> bool:
    """Whether :func:`at_highest` finds anything.

    It finds nothing where the volume is prescribed, as the highest pressure is then known at the
    end only, and nothing with effects that remember earlier states or distort readings.
    """
    forgets = not any(effect.remembers() for effect in config.extensions.active())
    distorted = config.extensions.active("reading")
    return config.experiment.control == "pressure" and forgets and not distorted


def at_highest(found: dict[str, float]) -> Callable[[FingerModel, Row], None]:
    """A visitor of an experiment that fills ``found`` at the highest pressure.

    ``found`` has for each ξ the derivative of the blocked force (N) if there is a plate, else the
    derivative of the tip's angle (deg). It stays empty where :func:`by_adjoint` is false.
    """

    def visit(finger: FingerModel, row: Row) -> None:
        experiment = finger.config.experiment
        highest = math.isclose(row["pressure_kPa"], experiment.max_pressure_kPa)
        if highest and by_adjoint(finger.config):
            found.update(to_morph(finger))

    return visit


def to_morph(finger: FingerModel) -> dict[str, float]:
    """Derivative of force (N) or angle (deg) by each ξ at the finger's present solution."""
    model, plate = finger.model, finger.plate
    reading = FromRest(FaceAngle(model)) if plate is None else PlateForce(model, plate)
    config = finger.config
    found = FingerAdjoints(finger, [reading]).by_parameters(config, find(config, XI))
    return found[reading.column]
