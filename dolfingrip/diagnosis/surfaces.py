"""Which surface an effect has between the screen's simulations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.diagnosis.lag_surface import LagSurface
from dolfingrip.diagnosis.model import can_be_fitted, free_parameters
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation.groups import path_independent
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.diagnosis.surface import SecantSurface
from dolfingrip.diagnosis.viscous_surface import ViscousSurface
from dolfingrip.extensions.index import effect

BY_THE_ELASTIC_CURVE: Final[Mapping[str, type[SecantSurface]]] = {
    "stage": LagSurface,
    "relaxation": ViscousSurface,
}
"""Surfaces by the law with which an effect follows from the elastic curve."""


def surface_of(problem: Problem, candidate: Candidate, shape: int) -> SecantSurface | None:
    """The surface of an effect; None where its parameters cannot be fitted.

    Args:
        problem: the readings.
        candidate: the effect, as the screen tried it.
        shape: number of the shape whose other parameters are held.
    """
    config = problem.measurement.tests[0].setup.applied(problem.base.config)
    overrides = candidate.overrides[shape]
    if not can_be_fitted(candidate.name, overrides, config):
        return None
    own = free_parameters(candidate.name, overrides, config)
    elastic = path_independent(config) and problem.base.scales
    law = effect(candidate.name).by_elastic_curve if elastic else ""
    return BY_THE_ELASTIC_CURVE.get(law, SecantSurface)(problem, candidate, own)
