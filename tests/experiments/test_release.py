"""A solid body that is held and let go: its sag, its hold, its swing, and bad input."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from mpi4py import MPI

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.rigs.first_step import adopt
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import AdoptedPart
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.solid import MeshError

SIDE, LENGTH, MU, DENSITY = 10.0, 100.0, 5.0, 1000.0


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> AdoptedPart:
    """A bar of 10 x 10 x 100 mm without a cavity, of 12 triangles."""
    drawn = tmp_path_factory.mktemp("drawn") / "bar.stl"
    pv.Box((0, SIDE, 0, SIDE, 0, LENGTH)).triangulate().save(drawn)
    return adopt(drawn, Asked(back=(-1.0, 0.0, 0.0)), MeshRequest(size_mm=8.0))


@pytest.fixture(scope="module")
def beam(part: AdoptedPart, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its mesh file."""
    file = tmp_path_factory.mktemp("beam") / "beam.msh"
    files.write(file, part.mesh)
    return file


def test_a_solid_body_is_adopted(part: AdoptedPart) -> None:
    assert part.roles.cavities == []
    assert "none: no closed shell inside" in part.roles.said["cavity"]
    assert 2 * part.quality.volume_mm3 == pytest.approx(SIDE**2 * LENGTH, rel=1e-9)
    assert part.quality.cavity_mm3 == 0
    assert set(part.mesh.facets) == {"clamp", "tip", "skin", "symmetry"}


def body(beam: Path, **further: Any) -> Config:
    """The bar, horizontal, with weight along −x; ν = 0 as in the theory of beams."""
    return config.load(
        overrides={
            "finger.kind": "adopted", "adopted.length_mm": LENGTH, "adopted.solid_body": True,
            "mesh.file": str(beam), "morph.d_mm": SIDE / 2, "contact.self_contact": False,
            "material.mu_MPa": MU, "material.nu": 0.0001, "material.density_kg_m3": DENSITY,
            "gravity.acceleration_m_s2": 9.81, "gravity.direction": [-1, 0, 0],
            **{key.replace("__", "."): value for key, value in further.items()},
        }
    )  # fmt: skip


def sag_by_theory_mm(mass_g: float = 0.0, centre_mm: float = 0.0) -> float:
    """Timoshenko's cantilever, k = 5/6, with a mass whose weight turns its end, too."""
    young, shear, area, inertia = 2 * MU, MU, SIDE**2, SIDE**4 / 12
    q, p = 1e-12 * DENSITY * 9810 * area, 1e-6 * mass_g * 9810
    even = q * LENGTH**4 / (8 * young * inertia) + q * LENGTH**2 / (2 * 5 / 6 * shear * area)
    end = p * LENGTH**3 / (3 * young * inertia) + p * LENGTH / (5 / 6 * shear * area)
    return even + end + p * centre_mm * LENGTH**2 / (2 * young * inertia)


@pytest.mark.parametrize(("mass_g", "centre_mm"), [(0.0, 0.0), (1.0, 0.0), (1.0, 10.0)])
def test_the_sag_is_a_result(beam: Path, mass_g: float, centre_mm: float) -> None:
    """Of small deflections, by the theory of beams; poses still count from the state at rest."""
    given = {"mass_g": mass_g, "centre_mm": centre_mm}
    mass = {f"extensions__tip_mass__{key}": value for key, value in given.items()}
    result = run("bending", body(beam, **mass), comm=MPI.COMM_SELF)
    assert result.failure is None
    x, y, z = result.facts.sag_mm
    assert -x == pytest.approx(sag_by_theory_mm(**given), rel=0.02)
    assert y == 0
    assert z < 0
    # of a slender bar round-off alone moves the tip by some 1e-9 mm, as processors differ
    assert result.column("tip_x_mm") == pytest.approx([0.0], abs=1e-8)


def moving(beam: Path, end_s: float, gradients: list[str] | None = None, **further: Any) -> Any:
    times = np.linspace(0.0, end_s, 41).tolist()
    asked = body(
        beam, experiment__dynamic=True, protocol__time_s=times,
        protocol__pressure_kPa=[0.0] * len(times), **further,
    )  # fmt: skip
    result = run("bending", asked, comm=MPI.COMM_SELF, gradients=gradients)
    assert result.failure is None
    return result


def test_it_starts_where_it_is_held_and_swings_about_rest(beam: Path) -> None:
    """It is level at first, which is its sag above rest, and turns as far on the other side.

    Without loss; half a period later by the frequency that ``vibrate`` tells.
    """
    told = run("vibration", body(beam), comm=MPI.COMM_SELF).column("frequency_1_Hz")[0]
    result = moving(beam, 1 / told, release__held_x_mm=0.0, release__over_s=1e-4,
                    solver__time_error_mm=0.002)  # fmt: skip
    sag_mm, x = -result.facts.sag_mm[0], result.column("tip_x_mm")
    assert x[0] == pytest.approx(sag_mm, abs=1e-4)
    assert x[20] == pytest.approx(-sag_mm, rel=0.12)  # higher modes take part
    assert x[40] == pytest.approx(sag_mm, rel=0.12)


def test_a_load_that_is_removed(beam: Path) -> None:
    """The tip starts by P L³/(3 E I) + P L/(k G A) from rest, and comes back to −that."""
    load_n = 1e-3
    x = moving(beam, 0.02, release__load_x_N=load_n).column("tip_x_mm")
    mass_g = 1e6 * load_n / 9810
    assert x[0] == pytest.approx(sag_by_theory_mm(mass_g) - sag_by_theory_mm(), rel=0.02)
    assert x[-1] < x[0]


@pytest.mark.slow
def test_derivatives_of_a_release(beam: Path) -> None:
    """A place that is held stays where it is: the load that holds it follows all parameters.

    Against central differences, with the same steps in time.
    """
    strict = {"solver.rtol": 1e-11, "solver.time_error_mm": 10.0, "solver.max_step_s": 0.0025,
              "extensions.tip_mass.mass_g": 1.0}  # fmt: skip
    base = {
        **{key.replace(".", "__"): value for key, value in strict.items()},
        "release__held_x_mm": 0.0,
    }
    keys = ["material.mu_MPa", "material.density_kg_m3", "extensions.tip_mass.mass_g"]
    changes = {"material__mu_MPa": MU, "material__density_kg_m3": DENSITY,
               "extensions__tip_mass__mass_g": 1.0}  # fmt: skip

    def swung(**further: Any) -> np.ndarray:
        return moving(beam, 0.1, **{**base, **further}).column("tip_x_mm")

    result = moving(beam, 0.1, gradients=keys, **base)
    assert np.ptp(result.column("tip_x_mm")) > 1.0
    for key, (name, value) in zip(keys, changes.items(), strict=True):
        found = np.array([
            value * float(row["derivative"]) for row in result.sensitivities
            if (row["parameter"], row["column"]) == (key, "tip_x_mm")
        ])  # fmt: skip
        step = 1e-3
        ends = [swung(**{name: value * (1 + sign * step)}) for sign in (1, -1)]
        expected = (ends[0] - ends[1]) / (2 * step)
        largest = np.abs(expected).max()
        print(key, np.abs(found - expected).max() / largest)
        assert largest > 0.1
        np.testing.assert_allclose(found, expected, atol=2e-4 * largest)


def test_refusals(beam: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"release.held_x_mm = 0.0: allowed: with experiment.dyn"):
        body(beam, release__held_x_mm=0.0)
    with pytest.raises(ConfigError, match=r"load_x_N = 1.0: allowed: not beside held_x_mm"):
        body(beam, experiment__dynamic=True, release__held_x_mm=0.0, release__load_x_N=1.0)
    with pytest.raises((ConfigError, MeshError), match="missing group cavity"):
        run("bending", body(beam, adopted__solid_body=False), comm=MPI.COMM_SELF)
