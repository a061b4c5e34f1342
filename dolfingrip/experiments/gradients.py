"""Derivatives of what is read off a finger with respect to its morph's ξ1 and ξ2."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.config import Config
from dolfingrip.experiments.finger import FingerModel
from dolfingrip.experiments.result import Row
from dolfingrip.experiments.undeformed import morph, solid
from dolfingrip.forms import tip_face
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.morph import velocity
from dolfingrip.mechanics.sensitivity.adjoint import Adjoint, Direction
from dolfingrip.meshes.measures import centroid, centroid_rate

XI = ("morph.xi1", "morph.xi2")


def cog_offset_mm(config: Config) -> tuple[float, dict[str, float]]:
    """Offset of the undeformed finger's centre of gravity, and its derivatives (mm).

    Raises:
        MeshError: one line, where there is no such finger.
    """
    mesh, moved = solid(config), morph(config)
    offset = float(centroid(mesh)[0]) - config.cog.x_ref_mm
    fields = moved.velocity(moved.inverse().points(mesh.points))
    slopes = [float(centroid_rate(mesh, field)[0]) for field in fields]
    return offset, dict(zip(XI, slopes, strict=True))


def at_highest(found: dict[str, float]) -> Callable[[FingerModel, Row], None]:
    """A visitor of an experiment that fills ``found`` at the highest pressure.

    By ξ: the derivative of the blocked force (N) where there is a plate, else of the tip's
    angle (deg). Nothing is found where the volume is led, as the pressure then is no parameter,
    nor of an angle under gravity, whose zero moves, too, nor with extensions of more than
    geometry: they have unknowns, histories or readings that the adjoint knows nothing of.
    """

    def visit(finger: FingerModel, row: Row) -> None:
        experiment = finger.config.experiment
        zero_stays = finger.plate is not None or not finger.config.gravity.acceleration_m_s2
        highest = math.isclose(row["pressure_kPa"], experiment.max_pressure_kPa)
        plain = not finger.config.extensions.active()
        if experiment.control == "pressure" and highest and zero_stays and plain:
            found.update(to_morph(finger))

    return visit


def to_morph(finger: FingerModel) -> dict[str, float]:
    """By ξ the derivative of force (N) or angle (deg) at the finger's present solution."""
    plate, domain = finger.plate, finger.model.domain
    output = _angle_deg(finger) if plate is None else plate.reaction
    adjoint = Adjoint(finger.model, output)
    found = {}
    for name, field in zip(XI, velocity(domain, morph(finger.config)), strict=True):
        rates = [] if plate is None else [(plate.offset, plate.offset_rate(field))]
        found[name] = adjoint.derivative(Direction(field, [r for r in rates if r[1]]))
    return found


def _angle_deg(finger: FingerModel) -> ufl.Form:
    """The tip's angle, made linear in its face's area vector; the meshed part's share.

    The undeformed face stays plane under a morph, so that the angle at rest stays 0.
    """
    model = finger.model
    mesh = model.domain.mesh
    degree = model.u.function_space.ufl_element().degree
    tip = model.domain.surface("tip", quadrature_degree=2 * degree)
    vector = tip_face.area_vector(model.u, mesh)
    x, z = (
        mesh.comm.allreduce(
            fem.assemble_scalar(fem.form(vector[i] * tip, jit_options=jit.options())), MPI.SUM
        )
        for i in (0, 2)
    )
    scale = math.degrees(1.0) / (x**2 + z**2) / model.domain.copies
    weights = fem.Constant(mesh, np.array([-z * scale, 0.0, x * scale]))
    return ufl.inner(weights, vector) * tip
