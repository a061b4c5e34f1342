"""Viscosity between simulations: on a short finger, free and blocked, and on a coupon."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.data.files import written
from diagnosis.simulation.here import Here
from experiments import small

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.diagnose import problem_of
from dolfingrip.diagnosis.model import free_parameters
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation import modulus, relaxation
from dolfingrip.diagnosis.simulation.base import BaseSimulation, simulate_base
from dolfingrip.diagnosis.simulation.simulated import Case, simulate
from dolfingrip.diagnosis.surface import SecantSurface
from dolfingrip.diagnosis.viscous_surface import ViscousSurface
from dolfingrip.extensions.prony import Prony

WAY = (0, 15, 30, 45, 60, 45, 30, 15, 0)
TRAVEL_mm = (0, 2, 4, 6, 8, 6, 4, 2, 0)
G, TAU_s = 0.35, 5.0
"""Between the values that the screen tries: g = 0.2, τ = 2, 13 and 90 s."""
SOFTER = 0.8
LEFT = {"bending": 0.1, "blocked_force": 0.4, "coupon": 0.1}
"""Part of the change that the law misses. Of the force most is missed in unloading: while the tip
is blocked the finger does not follow the elastic load, so the contact opens otherwise."""
NOISE = "[noise]\nangle_deg = 0.02\nforce_N = 0.002\n"
COUPON = "[coupon]\nwidth_mm = 6\nthickness_mm = 2\ngauge_length_mm = 25\n"


def config() -> Config:
    return small.short("solver.rtol=1e-9")


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    """Only the control matters here; of the coupon its force alone."""
    folder = tmp_path_factory.mktemp("viscous")
    branch = ["loading"] * 5 + ["unloading"] * 4
    files = []
    for name, control, way, column in (
        ("bending", "pressure_kPa", WAY, "angle_deg"),
        ("blocked_force", "pressure_kPa", WAY, "force_N"),
        ("coupon", "displacement_mm", TRAVEL_mm, "force_N"),
    ):
        rows = [f"{b},{i},{at},{i % 5}" for i, (b, at) in enumerate(zip(branch, way, strict=True))]
        text = "\n".join([f"branch,time_s,{control},{column}", *rows]) + "\n"
        told = f'experiment = "{name}"\n' + NOISE + (COUPON if name == "coupon" else "")
        files.append(written(folder, text, told, name=name))
    return read(files, config())


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Here:
    return Here(tmp_path_factory.mktemp("store"))


@pytest.fixture(scope="module")
def base(measurement: Measurement, store: Here) -> BaseSimulation:
    return simulate_base(measurement, config(), store, effects=("prony",))


@pytest.fixture(scope="module")
def problem(base: BaseSimulation) -> Problem:
    return problem_of(base.measurement, base)[0]


@pytest.fixture(scope="module")
def simulated(measurement: Measurement, store: Here) -> dict[float, np.ndarray]:
    """(n,) change by viscosity, by the factor of all moduli. Reference: the simulation."""
    found = {}
    for factor in (1.0, SOFTER):
        softer = modulus.overrides(config(), factor)
        viscous = (f"extensions.prony.g=[{G}]", f"extensions.prony.tau_s=[{TAU_s}]")
        cases = [Case((*softer, *viscous)), Case(softer)]
        there, here = simulate(measurement, config(), cases, store)
        found[factor] = there.readings - here.readings
    return found


@pytest.mark.parametrize("factor", [1.0, SOFTER])
def test_the_law_is_nearly_what_is_simulated(
    measurement: Measurement, base: BaseSimulation, simulated: dict[float, np.ndarray],
    factor: float,
) -> None:  # fmt: skip
    prony = Prony(g=(G,), tau_s=(TAU_s,))
    found = relaxation.change(measurement, base.simulated, prony, factor)
    listed = measurement.listed()
    for experiment, rows in listed.groupby("experiment").indices.items():
        change = simulated[factor][rows]
        off = np.linalg.norm(found[rows] - change) / np.linalg.norm(change)
        print(experiment, "off by", off, "of", np.abs(change).max())
        assert off < LEFT[str(experiment)]


def test_the_surface_is_closer_than_the_law_and_than_secants(
    problem: Problem, simulated: dict[float, np.ndarray]
) -> None:
    (candidate,) = problem.base.candidates
    own = free_parameters("prony", candidate.overrides[0], config())
    told = {"g": G, "tau_s": TAU_s}
    zeta = np.array([p.prior.zeta(told[p.key.rpartition(".")[2]]) for p in own])
    change = problem.take(simulated[SOFTER])
    law = problem.take(
        relaxation.change(problem.measurement, problem.base.simulated,
                          Prony(g=(G,), tau_s=(TAU_s,)), SOFTER)
    )  # fmt: skip
    near, secant = (
        kind(problem, candidate, own).change(zeta, SOFTER)
        for kind in (ViscousSurface, SecantSurface)
    )
    off = {
        name: float(np.linalg.norm((each - change) / problem.noise_std))
        for name, each in (("near", near), ("law", law), ("secant", secant))
    }
    print(off, np.linalg.norm(change / problem.noise_std))
    assert off["near"] < 0.5 * off["secant"]
    assert off["near"] < off["law"]


def test_the_surface_goes_through_what_was_tried(problem: Problem) -> None:
    (candidate,) = problem.base.candidates
    own = free_parameters("prony", candidate.overrides[0], config())
    surface = ViscousSurface(problem, candidate, own)
    for place, change in zip(surface.places, candidate.shapes, strict=True):
        assert surface.change(place) == pytest.approx(problem.take(change), abs=1e-9)
