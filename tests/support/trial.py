"""The checks of every effect, on a short coarse finger against the plate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from pydantic import create_model
from support import small, taylor

from dolfingrip.config import Config, checked
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS, table
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient

SEED = 5
STRICT = ("solver.rtol=1e-12", "solver.atol_N=1e-11")
"""Iterated until rounding, so that comparisons do not show Newton's tolerance."""


def configured(
    on: Mapping[type[Effect], Mapping[str, Any]], *overrides: str, finger: Any = small.short
) -> Config:
    """A short finger's configuration with effects, be they in the index or not.

    Args:
        on: parameters of each effect that is switched on.
        overrides: as with ``--set``.
        finger: configuration of the finger from overrides.
    """
    known = dict.fromkeys([*EFFECTS, *on])
    section: Any = table(known)
    root = create_model("Config", __base__=Config, extensions=(section, section()))
    data = finger(*overrides).model_dump(exclude_none=True)
    data["extensions"] = {effect.name(): dict(values) for effect, values in on.items()}
    return checked(root, data)


def stirred(settings: Config) -> FingerModel:
    """The finger in the middle of a second load step, its displacement and history irregular."""
    print("seed", SEED)
    finger = small.model(settings, plate=True)
    rng = np.random.default_rng(SEED)
    nodes = finger.model.u.function_space.tabulate_dof_coordinates()
    # every element strained by some per cent, and each differently
    for time_s in (1.0, 2.5):
        strain = 0.03 * rng.uniform(-1, 1, (3, 3))
        waves = 0.03 * np.sin(nodes @ rng.uniform(-1, 1, (3, 3)))
        finger.model.u.x.array[:] = (nodes @ strain + waves).ravel()
        finger.model.prescribe({"pressure_kPa": 20 * time_s, "time_s": time_s})
        if time_s == 1.0:
            finger.model.accept_step()
    return finger


def orders(finger: FingerModel) -> tuple[float, float]:
    """Smallest orders of the Taylor remainders of energy and residual along a direction.

    Both are 2 where the residual is the energy's derivative and the tangent the residual's.
    """
    model, potential = finger.model, finger.model.potential
    start = model.u.x.array.copy()
    nodes = model.u.function_space.tabulate_dof_coordinates()
    rng = np.random.default_rng(SEED + 1)
    along = 0.02 * (nodes @ rng.uniform(-1, 1, (3, 3)) + np.cos(nodes @ rng.uniform(-1, 1, (3, 3))))

    def at(step: float) -> None:
        model.u.x.array[:] = start + step * along.ravel()

    def energy(step: float) -> float:
        at(step)
        return float(potential.value(model.u.x.array))

    def gradient(step: float) -> np.ndarray:
        at(step)
        rates = Gradient(model.unknowns)
        potential.add_gradient(model.u.x.array, rates)
        return rates.fields[0]

    slope = float(gradient(0.0) @ along.ravel())
    potential.carried.reset()
    tangent = fem_petsc.assemble_matrix(potential.tangent)
    tangent.assemble()
    direction, product = tangent.createVecs()
    direction.array[:] = along.ravel()
    tangent.mult(direction, product)
    assert slope != 0.0
    found = (
        taylor.rates(energy, slope, 0.1).min(),
        taylor.rates(gradient, np.array(product.array), 0.1).min(),
    )
    at(0.0)
    transposed = tangent.copy()
    transposed.transpose()
    assert (tangent - transposed).norm() < 1e-12 * tangent.norm()
    return float(found[0]), float(found[1])


def way(finger: FingerModel, unknown: GlobalUnknown) -> np.ndarray:
    """Displacement of the clamp's moving dofs for each unit of one of its global unknowns."""
    clamp = finger.model.constraint
    assert clamp is not None
    kept = unknown.value
    apart = []
    for value in (kept + 1.0, kept):
        unknown.constant.value = value
        apart.append(-clamp.apart(finger.model.u.x.array))
    return apart[0] - apart[1]


SELF = MPI.COMM_SELF
