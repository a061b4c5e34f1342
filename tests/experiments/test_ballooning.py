"""The forecast of ballooning against a balloon's closed form and a solved finger."""

from __future__ import annotations

import math
import re
import time
from functools import partial
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from mpi4py import MPI
from support import hollow_box
from support.command import run_command
from support.example import EXAMPLES

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import ballooning, run
from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.material_fit.law import LAWS, balloon, limit_points
from dolfingrip.experiments.rigs import finger_rig
from dolfingrip.experiments.rigs.finger_rig import FingerRig
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.path.failure import FailureKind
from dolfingrip.meshes import files
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.sections.tables import assignments


def test_a_balloon_of_neo_hooke_is_greatest_at_the_sixth_root_of_seven() -> None:
    """p = 2 μ t/r (1/λ − 1/λ⁷) has its maximum at λ⁶ = 7."""
    stretch = 7 ** (1 / 6)
    expected = 2.93 * (1 / stretch - stretch**-7)
    found = ballooning.most(config.Config().material)
    assert found is not None
    assert found[0] == pytest.approx(stretch, rel=1e-6)
    assert found[1] == pytest.approx(expected, rel=1e-4)


def test_the_greatest_pressure_is_that_of_the_fit() -> None:
    """Coupons' page finds the limit points of the same balloon."""
    values = {"C10_MPa": 0.3, "C01_MPa": 0.01}
    law = LAWS["mooney-rivlin"]
    energy = partial(law.energy, list(values.values()))
    at, greatest = limit_points(energy, 5.0)[0]
    assert greatest
    (pressure,) = balloon(energy, np.array([at]))
    change = {"material.law": "polynomial", **{f"material.{k}": v for k, v in values.items()}}
    found = ballooning.most(config.load(None, change).material)
    assert found == (pytest.approx(at, rel=1e-6), pytest.approx(pressure, rel=1e-4))


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
        (["material.mu_MPa=0.5", "protocol.time_s=[0.0, 9.0]",
          "protocol.pressure_kPa=[0.0, 50.0]"], False),
        (["material.mu_MPa=0.5", "protocol.time_s=[0.0, 9.0]",
          "protocol.pressure_kPa=[0.0, 250.0]"], True),
    ],
)  # fmt: skip
def test_a_run_is_told_of_walls_that_balloon(changes: list[str], *, told: bool) -> None:
    found = [each for each in Bending().notes(config.load(None, assignments(changes))) if
             "balloon near" in each]  # fmt: skip
    assert bool(found) == told
    assert all("experiment.control=auto" in each for each in found)


ADOPTED = {
    "finger.kind": "adopted", "mesh.file": "own.msh", "adopted.chamber_mm": 30.0,
    "adopted.wall_mm": 2.0, "material.mu_MPa": 0.088, "experiment.max_pressure_kPa": 20.0,
}  # fmt: skip


@pytest.mark.parametrize("ratio", [1.0, 0.5, 0.0])
def test_an_adopted_part_balloons_as_its_widest_chamber(ratio: float) -> None:
    """1.24 μ t/r of neo-Hooke's thin balloon (Ogden 1984, section 5.2), in the chamber itself."""
    asked = config.load(None, {**ADOPTED, "cavity.cavity.pressure_ratio": ratio})
    found = ballooning.forecast(asked)
    if not ratio:  # no pressure, no balloon
        assert found is None
        return
    assert found is not None
    assert found.pressure_kPa * ratio == pytest.approx(1.24 * 88 * 2 / 15, rel=1e-3)
    assert bool(ballooning.note(asked)) == (ratio == 1)  # 20 kPa are near 14.5, and not 29
    assert ballooning.forecast(asked.changed(adopted={"chamber_mm": 0.0})) is None


@pytest.mark.parametrize(
    ("ratios", "allowed"),
    [((1.0, 0.0), True), ((0.5, 2.0), True), ((0.0, 0.0), False), ((1.0, -0.5), False)],
)
def test_a_volume_is_that_of_the_chambers_under_pressure(
    ratios: tuple[float, float], *, allowed: bool
) -> None:
    changes = {
        f"cavity.{name}.pressure_ratio": each
        for name, each in zip(("cavity", "cavity_2"), ratios, strict=True)
    }
    asked = {**ADOPTED, **changes, "experiment.control": "volume"}
    if allowed:
        config.load(None, asked)
        return
    with pytest.raises(ConfigError, match=r'experiment.control = "?volume"?: allowed: "pressure"'):
        config.load(None, asked)


def cylinder(file: Path, length_mm: float) -> Path:
    """A closed tube of 44 mm, walls and webs of 2 mm, four chambers, drawn by OCC."""
    occ, inner_mm = gmsh.model.occ, length_mm - 8
    with session("cylinder"):
        body, inside = (3, occ.addCylinder(0, 0, 0, 0, 0, length_mm, 22)), []
        for x in (-20, 1):
            for y in (-20, 1):
                whole = [(3, occ.addCylinder(0, 0, 4, 0, 0, inner_mm, 20))]
                quarter = [(3, occ.addBox(x, y, 4, 19, 19, inner_mm))]
                inside += occ.intersect(whole, quarter)[0]
        solid, _ = occ.cut([body], inside)
        occ.rotate(solid, 0, 0, 0, 0, 0, 1, math.pi / 4)
        occ.synchronize()
        gmsh.write(str(file))
    return file


def soft(folder: Path, length_mm: float) -> Config:
    """The adopted cylinder of silicone, one chamber of four under pressure."""
    part = cylinder(folder / "part.step", length_mm)
    asked = ["--clamp", "0,0,0", "--size-mm", "4.9", "--out", str(folder / "out")]
    assert run_command("adopt", str(part), *asked) == 0
    shut = {f"cavity.cavity_{k}.pressure_ratio": 0.0 for k in (2, 3, 4)}
    silicone = {"material.mu_MPa": 0.088, "material.nu": 0.499, "solver.element": "P2-P1"}
    stops = {"experiment.max_pressure_kPa": 30.0}
    return config.load(folder / "out" / "adopted.toml", {**shut, **silicone, **stops})


@pytest.mark.slow
def test_a_soft_cylinder_says_where_its_wall_balloons(tmp_path: Path) -> None:
    """A limit point after few iterations, by steps and where one step asks for more than it bears.

    The search goes as far as the reading, and not as far as the first step towards it. Reference:
    the greatest of the pressures under volume control, readings of which are half a volume apart,
    so 1 % may lie between them.
    """
    asked = soft(tmp_path, 22)
    volume = {"control": "volume", "max_volume_ratio": 4.5, "step_volume_ratio": 0.5}
    inflated = run("bending", asked.changed(experiment=volume))
    assert inflated.failure is None
    pressures = inflated.column("pressure_kPa")
    print(pressures)
    assert 2 < pressures.argmax() < len(pressures) - 1
    for step_kPa in (10.0, 30.0):
        begun_s = time.process_time()
        found = run("bending", asked.changed(experiment={"step_kPa": step_kPa}))
        took_s = time.process_time() - begun_s
        assert found.failure is not None
        said = found.failure.sentence()
        print(said, took_s, found.column("largest_stretch"), found.facts.newton.iterations)
        assert found.failure.kind is FailureKind.LIMIT_POINT
        told = re.search(r"(the walls .*) balloon at ([\d.]+) kPa, stretch ([\d.]+)", said)
        assert told is not None, said
        assert told[1] == "the walls of cavity"
        pressure, stretch = float(told[2]), float(told[3])
        assert pressure == pytest.approx(pressures.max(), rel=0.01)
        assert found.failure.last_good["pressure_kPa"] == pytest.approx(pressure, rel=5e-3)
        assert stretch > found.column("largest_stretch")[-1]
        assert found.facts.newton.iterations < 120
        assert took_s < 60  # 9 s; the iterations of the search are counted nowhere


def test_one_search_tells_of_all_readings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Up to the pressure that is found the forecast is not believed again; above, it is sought."""
    files.write(tmp_path / "box.msh", hollow_box.mesh())
    asked = {**ADOPTED, "mesh.file": str(tmp_path / "box.msh")}
    rig = FingerRig.built(config.load(None, asked), MPI.COMM_SELF, Profile(), plate=False)
    forecast = ballooning.forecast(config.load(None, asked))
    assert forecast is not None
    near_kPa = forecast.pressure_kPa / 2  # it is good to a factor of two
    assert [rig.foreseen({"pressure_kPa": p * near_kPa}) for p in (0.9, 1.1)] == [False, True]
    sought: list[float] = []

    def greatest(model: Model, pressure: Control, *rest: Any) -> tuple[float, State]:
        sought.append(rest[2])
        return 18.0, model.state()

    monkeypatch.setattr(finger_rig, "greatest", greatest)
    assert not rig.passable({"pressure_kPa": 15.0})  # 18 kPa are borne
    assert [rig.foreseen({"pressure_kPa": p}) for p in (17.9, 18.1)] == [False, True]
    assert rig.passable({"pressure_kPa": 19.0})
    assert sought == [20.0, 20.0]  # as far as the run goes
