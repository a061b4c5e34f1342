"""Where fits begin and when they end; no simulation."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from dolfingrip.config import Config
from dolfingrip.diagnosis.descent import descend
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.model import FitFailure, FreeParameter, free_parameters
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation.mesh_map import MeshMap
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.diagnosis.simulation.strengths import ordinary
from dolfingrip.diagnosis.surface import SecantSurface, numbers
from dolfingrip.extensions.effect import Prior

PRESSURE_kPa = np.linspace(0, 250, 11)
STD = 0.3
COVARIANCE = Covariance.of(STD**2 * np.eye(11))


def creep_deg(g: float, tau_s: float, factor: float = 1.0) -> np.ndarray:
    """What a viscous finger bends further: invented, in proportion to g, its shape by τ."""
    x = PRESSURE_kPa / 250 / factor
    return np.asarray(40 * g * x ** (1 + 0.2 * np.log(tau_s)))


def surface() -> tuple[SecantSurface, Sequence[FreeParameter]]:
    (tried,) = [each for each in ordinary(Config()) if each.effect == "prony"]
    changes = []
    for shape in tried.shapes:
        told = numbers(shape.overrides)
        changes.append(
            creep_deg(told["extensions.prony.g"], told["extensions.prony.tau_s"]) / shape.part
        )
    shapes = tried.shapes
    candidate = Candidate(
        "prony", tried.kind, np.array(changes), tuple(s.label for s in shapes),
        tuple(s.overrides for s in shapes), tuple(s.part for s in shapes), tried.spread,
        tried.one_sided, "graded",
    )  # fmt: skip
    index = pd.DataFrame(
        {"experiment": "bending", "channel": "angle_deg", "run": 0, "cycle": 1,
         "branch": "loading", "pressure_kPa": PRESSURE_kPa}
    )  # fmt: skip
    problem = SimpleNamespace(take=lambda values: values, index=index)
    own = free_parameters("prony", tried.shapes[0].overrides, Config())
    return SecantSurface(cast(Problem, problem), candidate, own), own


@pytest.mark.parametrize(("g", "tau_s"), [(0.2, 5.0), (0.35, 9.0), (0.1, 15.0)])
def test_a_surface_goes_through_and_between_what_was_tried(g: float, tau_s: float) -> None:

    found, own = surface()
    at = dict(zip((p.key.rpartition(".")[2] for p in own), (p.prior for p in own), strict=True))
    zeta = np.array([at["g"].zeta(g), at["tau_s"].zeta(tau_s)])
    assert [p.key.rpartition(".")[2] for p in own] == ["g", "tau_s"]
    change = found.change(zeta)
    # a parabola in ln τ through three places, of a power law of it
    np.testing.assert_allclose(change, creep_deg(g, tau_s), atol=0.05 * creep_deg(g, tau_s).max())
    softer = found.change(zeta, 0.95)
    exact = creep_deg(g, tau_s, 0.95)
    assert np.abs(softer - exact).max() < 0.5 * np.abs(change - exact).max()


def parameter(name: str, mean: float, spread: float) -> FreeParameter:
    return FreeParameter(name, Prior(mean, spread, "invented"), -10.0, 10.0)


def curved(values: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Readings that are a little curved in two parameters, and their derivatives."""
    a, b = values
    x = PRESSURE_kPa / 250
    readings = 100 * a * x + 30 * b * x**2 + 5 * a**2 * x**3
    return readings, np.column_stack([100 * x + 10 * a * x**3, 30 * x**2])


def test_a_search_ends_where_its_tangent_serves() -> None:
    """Two simulations: from the second on the curvature tells how far the tangent holds."""
    value, _ = curved([1.2, 0.6])
    both = [parameter("a", 1.0, 0.5), parameter("b", 0.5, 0.5)]
    ended = descend(curved, both, value, COVARIANCE, [0.7, 0.3], 0.01, 20, straight=1.5)
    exact = descend(curved, both, value, COVARIANCE, [0.7, 0.3], 1e-9, 20)
    assert len(ended.visited) == 2
    assert len(exact.visited) > 2
    # nowhere further from the end than the readings tell
    white = COVARIANCE.whiten(ended.last.jacobian @ (ended.stepped - exact.stepped))
    assert np.linalg.norm(white) < 1.5


def test_what_stays_behind_is_given_up() -> None:
    value = 100 * np.cos(PRESSURE_kPa)
    both = [parameter("a", 1.0, 0.5), parameter("b", 0.5, 0.5)]
    seen: list[float] = []

    def hopeless(place: Any, gain: float) -> bool:
        seen.append(gain)
        return True

    ended = descend(curved, both, value, COVARIANCE, [3.0, -2.0], 1e-9, 20, hopeless)
    assert ended.hopeless
    assert len(ended.visited) == 2  # never at first sight
    assert len(seen) == 1


def test_a_first_simulation_that_fails_is_told() -> None:
    def fails(values: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
        raise FitFailure("buckled")

    with pytest.raises(FitFailure, match="buckled"):
        descend(fails, [parameter("a", 1, 1)], PRESSURE_kPa, COVARIANCE, [1.0], 0.01, 20)


def test_a_mesh_is_off_by_the_deformation_not_by_the_pressure() -> None:
    """A finger of another modulus, whose mesh is off by 5 % of the square of its angle."""
    true_deg = 140 * (PRESSURE_kPa / 250) ** 1.2
    off_deg = 0.0004 * true_deg**2

    def run(values: np.ndarray) -> Any:
        group = SimpleNamespace(tests=(0,))
        route = SimpleNamespace(value=tuple(PRESSURE_kPa))
        result = SimpleNamespace(columns={"angle_deg": values})
        return SimpleNamespace(config=Config(), group=group, route=route, result=result)

    listed = pd.DataFrame({"column": ["angle_deg"] * 11, "test": [0] * 11})
    measurement = SimpleNamespace(listed=lambda: listed)
    plain = true_deg - off_deg
    both = [SimpleNamespace(readings=v, runs=[run(v)]) for v in (true_deg, plain)]
    mapped = MeshMap(cast(Any, measurement), cast(Any, both[0]), cast(Any, both[1]))
    softer_deg = 140 * (PRESSURE_kPa / 250 * 0.9) ** 1.2
    rough_deg = softer_deg - 0.0004 * softer_deg**2
    found, slopes = mapped.to_graded(rough_deg, rough_deg[:, None])
    np.testing.assert_allclose(found, softer_deg, atol=0.02)
    assert np.abs(rough_deg + off_deg - softer_deg).max() > 1.0  # at its pressure
    assert (slopes[1:, 0] > rough_deg[1:]).all()
