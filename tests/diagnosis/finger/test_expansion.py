"""Changes by causes that derivatives tell, against simulations of these causes."""

from __future__ import annotations

import numpy as np
import pytest
from support.here import simulated

from benchmarks.reference_measurement import reference_measurement
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.errors import errors_of
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.finger import training
from dolfingrip.diagnosis.finger.closed_forms import Expansion
from dolfingrip.diagnosis.finger.model import baseline_problem
from dolfingrip.diagnosis.finger.training import CauseTraining
from dolfingrip.diagnosis.simulation import runner
from dolfingrip.diagnosis.simulation.nuisances import base_variant
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import simulate
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.jobs.cluster import Where


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> CauseTraining:
    """The reference finger, free and blocked, by the simulations that come with the package."""
    known = runner.shipped()
    assert known is not None
    known.agrees = True
    workers = Workers(
        tmp_path_factory.mktemp("store"), Where(workers=1), known=known, computes=False
    )
    measurement = reference_measurement()
    (base,) = simulate(measurement, Config(), [base_variant(measurement, Config())], workers)
    simulation = simulated(measurement.reading(base.readings), Config(), workers)
    errors = errors_of(simulation)
    plain = baseline_problem(simulation, errors)
    return CauseTraining(simulation, unknowns(measurement, Config()), plain, errors.noise)


NEAR = {
    "gent": 0.03, "yeoh": 0.1, "ogden": 0.2, "ogden_terms": 0.05, "polynomial": 0.1,
    "print_anisotropy": 0.25, "base_layer_offset": 0.1, "clamp_compliance": 0.05,
    "plate_compliance": 0.05,
}  # fmt: skip
"""Part of what a cause changes, at the place where it is simulated first, that may be missed."""


@pytest.mark.parametrize("name", NEAR)
def test_derivatives_tell_what_a_simulation_does(trained: CauseTraining, name: str) -> None:
    """At softer, told and stiffer moduli; the simulation is that of the cause by itself."""
    about = trained.expanded()[name]
    trained.compute({name: trained.designs[name].first()})
    alone = trained.changes[name]
    assert about is not None
    assert alone is not None
    np.testing.assert_array_equal(about.zeta, alone.zeta)
    for node in len(about.values) // 2 + np.array([-3, 0, 3]):
        true, told = alone.values[node] / trained.scale, about.values[node] / trained.scale
        off = np.linalg.norm(told - true) / np.linalg.norm(true)
        print(name, node, np.linalg.norm(true), off)
        assert off < NEAR[name]


def test_stiffness_that_a_cause_adds_is_no_straight_line(trained: CauseTraining) -> None:
    """A polynomial law doubles the modulus: derivatives alone miss ten times as much."""
    (cause,) = [each for each in trained.causes if each.name == "polynomial"]
    trained.compute({cause.name: trained.designs[cause.name].first()})
    alone, about = trained.changes[cause.name], expansion(trained, cause)
    assert alone is not None
    middle, zeta = len(alone.values) // 2, alone.zeta[0]
    v = [float(n.at(z)) - cause.neutral(n) for n, z in zip(cause.numbers, zeta, strict=True)]
    line = about.slopes(cause)[middle].T @ np.array(v)
    told = about.changes(cause, alone.zeta, training.FINGERS)
    assert np.isfinite(told.values).all()
    true = alone.values[middle, 0]
    ways = [
        np.linalg.norm((each - true) / trained.scale) for each in (line, told.values[middle, 0])
    ]
    print(ways, np.linalg.norm(true / trained.scale))
    assert ways[1] < 0.1 * ways[0]


def expansion(trained: CauseTraining, cause: Cause) -> Expansion:
    """About the simulation that has the derivatives by all causes."""
    some = [each.cause for each in trained.designs.values() if each.expands]
    assert cause in some
    return Expansion.about(
        trained.simulation,
        some,
        training.FINGERS | {"coupon"},
        trained.nodes,
        trained.plain.factor,
        trained.scale,
    )
