"""The forecast of ballooning against a balloon's closed form and a solved finger."""

from __future__ import annotations

import math
import re
from pathlib import Path

import gmsh
import numpy as np
import pytest
from support.command import run_command
from support.example import EXAMPLES

from dolfingrip import config
from dolfingrip.experiments import ballooning, run
from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.material_fit.law import LAWS, balloon, limit_points
from dolfingrip.mechanics.path.failure import FailureKind
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.sections.tables import assignments


def test_a_balloon_of_neo_hooke_is_greatest_at_the_sixth_root_of_seven() -> None:
    """p = 2 μ t/r (1/λ − 1/λ⁷) has its maximum at λ⁶ = 7."""
    stretch = 7 ** (1 / 6)
    expected = 2.93 * (1 / stretch - stretch**-7)
    found = ballooning.most(config.Config().material)
    assert found == pytest.approx(expected, rel=1e-4)


def test_the_greatest_pressure_is_that_of_the_fit() -> None:
    """Coupons' page finds the limit points of the same balloon."""
    values = {"C10_MPa": 0.3, "C01_MPa": 0.01}
    law = LAWS["mooney-rivlin"]
    at, greatest = limit_points(law, list(values.values()), 5.0)[0]
    assert greatest
    (pressure,) = balloon(law, np.array([at]), list(values.values()))
    change = {"material.law": "polynomial", **{f"material.{k}": v for k, v in values.items()}}
    assert ballooning.most(config.load(None, change).material) == pytest.approx(pressure, rel=1e-4)


def test_chains_that_end_soon_have_no_maximum() -> None:
    change = {"material.law": "gent", "material.gent_mu_MPa": 0.1, "material.gent_limit": 1.5}
    assert ballooning.most(config.load(None, change).material) is None


def test_the_thin_bellows_balloon_near_their_forecast() -> None:
    """Solved, their greatest pressure is about 174 kPa (examples/thin_bellows.toml)."""
    found = ballooning.forecast(config.load(EXAMPLES / "thin_bellows.toml"))
    assert found is not None
    assert found.wall_mm == 0.5
    assert found.pressure_kPa == pytest.approx(174, rel=0.15)


def test_a_film_that_hardly_stretches_does_not_balloon() -> None:
    """Measured actuators of this block balloon at 35 kPa, and its model has a limit point at 29."""
    changes = ("film.silk.Et_N_per_mm=1e-6",)
    file = EXAMPLES / "ecoflex_actuators" / "coupon_alone.toml"
    found = ballooning.forecast(config.load(file))
    alone = ballooning.forecast(config.load(file, assignments(changes)))
    assert found is not None
    assert alone is not None
    assert (found.wall_mm, alone.wall_mm) == pytest.approx((7.0, 0.5), rel=1e-3)
    assert 29 / 2 < found.pressure_kPa < 29 * 2


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ([], False),
        (["finger.kind=pneunet"], False),
        (["finger.kind=round_bellows", "material.mu_MPa=0.01"], False),
        (["finger.kind=pneunet", 'material.name="Ecoflex 00-50"'], True),
        (["material.mu_MPa=0.5"], True),
        (["material.mu_MPa=0.5", "experiment.max_pressure_kPa=50"], False),
        (["material.mu_MPa=0.5", "experiment.control=volume"], False),
    ],
)  # fmt: skip
def test_a_run_is_told_of_walls_that_balloon(changes: list[str], *, told: bool) -> None:
    found = [each for each in Bending().notes(config.load(None, assignments(changes))) if
             "balloon near" in each]  # fmt: skip
    assert bool(found) == told
    assert all("experiment.control=auto" in each for each in found)


ADOPTED = {
    "finger.kind": "adopted", "mesh.file": "own.msh", "adopted.width_mm": 44.0,
    "adopted.depth_mm": 44.0, "adopted.wall_mm": 2.0, "material.mu_MPa": 0.088,
    "experiment.max_pressure_kPa": 20.0,
}  # fmt: skip


@pytest.mark.parametrize(("ratio", "by_volume"), [(1.0, True), (0.5, False), (0.0, None)])
def test_an_adopted_part_balloons_as_one_chamber_of_its_walls(
    ratio: float, *, by_volume: bool | None
) -> None:
    """1.24 μ t/r of neo-Hooke's balloon; no control is asked for that ratios do not allow."""
    asked = config.load(None, {**ADOPTED, "cavity.cavity.pressure_ratio": ratio})
    found = ballooning.forecast(asked)
    if by_volume is None:  # no pressure, no balloon
        assert found is None
        return
    assert found is not None
    assert found.pressure_kPa * ratio == pytest.approx(1.24 * 88 * 2 / 22, rel=1e-3)
    (said,) = ballooning.note(asked)
    assert ("experiment.control=auto" in said) == by_volume


def cylinder(file: Path) -> Path:
    """A closed tube of 44 mm and 60 mm, walls and webs of 2 mm, four chambers, drawn by OCC."""
    occ = gmsh.model.occ
    with session("cylinder"):
        body, inside = (3, occ.addCylinder(0, 0, 0, 0, 0, 60, 22)), []
        for x in (-20, 1):
            for y in (-20, 1):
                box = (3, occ.addBox(x, y, 4, 19, 19, 52))
                inside += occ.intersect([(3, occ.addCylinder(0, 0, 4, 0, 0, 52, 20))], [box])[0]
        solid, _ = occ.cut([body], inside)
        occ.rotate(solid, 0, 0, 0, 0, 0, 1, math.pi / 4)
        occ.synchronize()
        gmsh.write(str(file))
    return file


@pytest.mark.slow
def test_a_soft_cylinder_says_where_its_wall_balloons(tmp_path: Path) -> None:
    """One chamber of four: the run ends as a limit point, after a search by the volume.

    The pressure that it tells is above what was reached and below what was not, and the walls are
    stretched more there than at the last reading.
    """
    part = cylinder(tmp_path / "part.step")
    assert run_command(
        "adopt", str(part), "--clamp", "0,0,0", "--size-mm", "4.9", "--out", str(tmp_path / "out")
    ) == 0  # fmt: skip
    shut = {f"cavity.cavity_{k}.pressure_ratio": 0.0 for k in (2, 3, 4)}
    soft = {"material.mu_MPa": 0.088, "material.nu": 0.499, "solver.element": "P2-P1"}
    stops = {"experiment.max_pressure_kPa": 20.0, "experiment.step_kPa": 5.0}
    asked = config.load(tmp_path / "out" / "adopted.toml", {**shut, **soft, **stops})
    found = run("bending", asked)
    assert found.failure is not None
    assert found.failure.kind is FailureKind.LIMIT_POINT
    told = re.search(r"walls balloon at ([\d.]+) kPa, stretch ([\d.]+)", found.failure.sentence())
    assert told is not None, found.failure.sentence()
    print(found.failure.sentence(), found.column("largest_stretch"))
    pressure, stretch = map(float, told.groups())
    assert found.column("pressure_kPa")[-1] == 10 < pressure < 20
    assert found.failure.last_good["pressure_kPa"] == pytest.approx(pressure, rel=5e-3)
    assert stretch > found.column("largest_stretch")[-1]
