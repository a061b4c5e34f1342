"""A finger on so few elements that a run takes seconds: for trends, not for figures."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from support.paths import by_pressure

from dolfingrip import config
from dolfingrip.experiments.rigs.finger import FingerModel, build
from dolfingrip.experiments.rigs.undeformed import load_domain
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.sections.tables import assignments

COARSE = ("mesh.size_mm=6", "mesh.edge_size_mm=6")
SHORT = (
    *COARSE,
    "finger.length_mm=38",
    "finger.bellows=2",
    "experiment.max_pressure_kPa=50",
)
"""A quarter of the bellows and of the cost."""
FEW = ("mesh.size_mm=10", "mesh.edge_size_mm=10", "contact.self_contact=false")
"""Still fewer elements, and bellows that do not touch: for a diagnosis, which simulates often."""

SELF = MPI.COMM_SELF


def coarse(*overrides: str) -> config.Config:
    """The reference finger, coarsely meshed."""
    return config.load(None, assignments([*COARSE, *overrides]))


def short(*overrides: str) -> config.Config:
    """A short finger of two bellows, coarsely meshed."""
    return config.load(None, assignments([*SHORT, *overrides]))


def model(settings: config.Config, *, plate: bool, comm: MPI.Comm = MPI.COMM_SELF) -> FingerModel:
    """The unpressurised finger."""
    return build(settings, load_domain(settings, comm), plate=plate)


def pressurise(finger: FingerModel, pressures_kPa: Iterable[float]) -> Iterable[float]:
    """Load the finger to each of the pressures (kPa) in turn, and yield there."""
    path = by_pressure(Newton(finger.model, finger.config.solver))
    for pressure in pressures_kPa:
        arrival = path.advance({"pressure_kPa": pressure})
        assert arrival.failure is None, arrival.failure.sentence()
        yield pressure


def clamp_force_N(finger: FingerModel) -> np.ndarray:
    """Force (3,) of the clamp on the whole finger (N), on one rank."""
    space = finger.model.u.function_space
    nodes = fem.locate_dofs_topological(space, 2, finger.model.domain.facets("clamp"))
    return finger.model.domain.copies * finger.model.reactions()[nodes].sum(axis=0)
