"""Interpolation between solved designs, and the wizard's files."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import given, seed
from hypothesis import strategies as st
from support.small import short

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.design.campaign import campaign, plan
from dolfingrip.design.surrogate.surrogate import Surrogate
from dolfingrip.diagnosis.data import rig as rigs
from dolfingrip.experiments.filling import RestingFinger
from dolfingrip.explore import describe, rig, server, space
from dolfingrip.explore.library import Library, weights
from dolfingrip.explore.wanted import Wanted, curve, read
from dolfingrip.jobs.cluster import Where
from dolfingrip.report.page import run_scene, sources
from dolfingrip.report.page.scene import Scene
from dolfingrip.sections.tables import assignments


@seed(1)
@given(st.integers(1, 3), st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_weights_reproduce_what_is_known(parameters: int, count: int, draw: int) -> None:
    """Values at the places themselves; linear functions where there are places enough for them."""
    random = np.random.default_rng(draw)
    places = random.random((count, parameters))
    at = random.random(parameters)
    found = weights(places, at)
    assert found.sum() == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(weights(places, places[0]), np.eye(count)[0], atol=1e-6)
    if count > parameters + 1:
        slope = random.random(parameters)
        assert found @ (places @ slope) == pytest.approx(at @ slope, abs=1e-6)
        alike = weights(np.repeat(places, 3, axis=1), np.repeat(at, 3))  # shared by three chambers
        assert alike @ (places @ slope) == pytest.approx(at @ slope, abs=1e-6)


def test_the_files_of_a_measurement(tmp_path: Path) -> None:
    design = config.load(None, assignments(["finger.wall_mm=1.8", "morph.xi1=0.3"]))
    answers = {
        "experiments": ["bending", "blocked_force"], "rate_kPa_per_s": 10, "gap_mm": 1.5,
        "angle_deg": 0.3, "force_N": None, "gauge_length_mm": "",
        "protocol": {"highest_pressure_kPa": 100, "step_kPa": 50, "cycles": 1, "tip": True},
    }  # fmt: skip
    found = rig.files(answers, design)
    assert found.header == (
        "experiment,specimen,cycle,branch,time_s,pressure_kPa,angle_deg,force_N,tip_x_mm,tip_z_mm"
    )
    assert "protocol" not in found.setup
    file = tmp_path / "rig.toml"
    file.write_text(found.plan, encoding="utf-8")
    measurement, _ = rigs.read(file, config.Config())
    assert not measurement.warnings
    assert found.readings == len(measurement.readings) == 2 * 3
    setup = measurement.tests[1].setup
    assert setup.rate == 10
    assert setup.noise["angle_deg"] == 0.3
    applied = measurement.tests[1].applied(config.Config())
    assert (applied.finger.wall_mm, applied.morph.xi1, applied.plate.gap_mm) == (1.8, 0.3, 1.5)


@pytest.mark.parametrize(
    ("answers", "said"),
    [
        ({}, "experiments: none; allowed: bending, blocked_force, coupon"),
        ({"experiments": ["bending"], "gap_mm": "x"}, "gap_mm = x: allowed: a number"),
        (
            {"experiments": ["bending"], "protocol": {"cycles": 0}},
            "cycles = 0: allowed: at least 1",
        ),
        ({"experiments": ["bending"], "rate_kPa_per_s": -1}, "rate_kPa_per_s = -1"),
    ],
)
def test_answers_that_are_not_allowed(answers: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError) as error:
        rig.files(answers, config.Config())
    assert said in str(error.value)
    assert "\n" not in str(error.value)
    assert "/tmp" not in str(error.value)


@pytest.mark.slow
def test_a_campaign_that_keeps_its_shapes_is_interpolated(tmp_path: Path) -> None:
    """The middle one of three is left out; a straight line in the thickness is 3 % off there.

    From four designs on there is a number, with its error. Another one has a chamber with a wall of
    its own. Reference: the middle design's own simulation.
    """
    base = short("experiment.max_pressure_kPa=50", "experiment.step_kPa=25")
    keys = "finger.wall_mm", "finger.override.2.wall_mm"
    shares = (1.5, 1.7, 1.9, 1.6, 1.8)
    walls = (*((wall, wall) for wall in shares), (1.5, 1.9))
    points = tuple(dict(zip(keys, pair, strict=True)) for pair in walls)
    asked = plan.Plan(base, keys, points, ("angle_deg",), fields=tmp_path / "fields")
    campaign.run(asked, tmp_path, Where())
    found = sources.find([tmp_path])
    assert [each.kind for each in found] == ["doe"]  # a page has no run for each design
    designed = space.of_results(found, None, {}, ["finger.wall_mm=1.5:1.9"])
    library = Library(designed)
    folders = (tmp_path / "fields" / design.key / "bending" for design in asked.designs())
    *shared, single = folders
    kept = dict(zip(shares, shared, strict=True))
    assert library.add(kept[1.5])
    assert library.add(kept[1.9])
    middle = {"finger.wall_mm": 1.7}
    wanted = Wanted("bending", middle, designed.base.changed(finger={"wall_mm": 1.7}))
    blend = library.blend(wanted)
    assert blend is not None
    assert not blend.exact
    shape = blend.scene().parts[0].frames
    said = describe.described(designed, library, wanted, tmp_path / "none")
    assert said["badge"] == "estimate, error unknown"
    assert (said["charts"], said["numbers"][1]["value"]) == ([], "–")
    assert library.add(kept[1.6])
    assert library.add(kept[1.8])
    said = describe.described(designed, library, wanted, tmp_path / "none")
    angle = re.fullmatch(r"([\d.]+) ± ([\d.]+)°", said["numbers"][1]["value"])
    assert angle
    badge = re.fullmatch(r"estimate ± ([\d.]+)°, shape ± [\d.]+ mm", said["badge"])
    assert badge
    assert float(badge[1]) == pytest.approx(float(angle[2]), rel=0.01)
    assert library.add(kept[1.7])
    exact = library.blend(wanted)
    assert exact is not None
    assert exact.exact
    solved = exact.scene().parts[0].frames
    moved = np.abs(solved[-1] - solved[0]).max()
    assert np.abs(shape[-1] - solved[-1]).max() < 0.1 * moved
    np.testing.assert_allclose(shape[0], solved[0], atol=1e-6)  # its dimensions are its own
    off = abs(float(angle[1]) - exact.reading("angle_deg")[-1])
    assert off < 2 * float(angle[2])
    outside = designed.base.changed(finger={"wall_mm": 2.2})
    assert library.blend(Wanted("bending", {}, outside)) is None
    own = read(designed, {"view": "bending", "inputs": dict(zip(keys, walls[-1], strict=True))})
    assert library.blend(own) is None  # chambers alike do not tell what a single one does
    assert library.add(single)
    alone = library.blend(own)
    assert alone is not None
    assert alone.exact
    # a wall of the whole range is as far in one chamber alone as its share of all walls
    first, _, last, *_ = (library.places[folder.resolve()].place for folder in shared)
    place = library.places[single.resolve()].place
    assert np.linalg.norm(last - first) == pytest.approx(1.0)
    assert np.linalg.norm(place - first) == pytest.approx(1 / np.sqrt(3))


def test_the_experiment_that_is_solved_is_shown_first() -> None:
    text, _ = server.rendered(space.of_results([], None, {}, ()), "blocked_force")
    assert re.findall(r'data-view="(\w+)" aria-pressed="true"', text) == ["blocked_force"]
    assert re.search(r'title="finger.wall_mm: [^"]+">\s*<label[^>]*>Wall thickness \(mm\)<', text)


def test_triangles_of_mirrored_fingers_are_wound_outwards(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each half of a finger has the same volume, seen from a point of its plane of symmetry."""
    monkeypatch.setattr(Scene, "packed", lambda scene: scene)
    nothing = space.of_results([], None, {}, ())
    wanted = Wanted("grasp", {}, short())
    scene = describe.described(nothing, Library(nothing), wanted, tmp_path)["scenes"][0]
    halves = [part for part in scene.parts if part.name in run_scene.NAMES]
    assert len(halves) == 6
    for own, mirrored in zip(halves[::2], halves[1::2], strict=True):
        middle = (own.skin.points[0] + mirrored.skin.points[0]) / 2
        volumes = [
            np.linalg.det(part.skin.points[part.skin.triangles] - middle).sum() / 6
            for part in (own, mirrored)
        ]
        assert volumes[0] > 100  # mm³
        assert volumes[1] == pytest.approx(volumes[0], rel=1e-6)


def test_a_surrogate_says_nothing_of_what_it_did_not_learn(tmp_path: Path) -> None:
    ends = SimpleNamespace(low=np.array([-0.2, -0.5]), high=np.array([1.0, 0.5]))
    of_form = SimpleNamespace(
        input_names=["morph.xi1", "morph.xi2"], output_names=["angle_deg"], inputs=ends,
        predict=lambda inputs: np.full((len(inputs), 1), 33.0),
    )  # fmt: skip
    designed = space.of_results([], None, {}, ())
    learnt = replace(designed, surrogate=cast("Surrogate", of_form), errors={"angle_deg": 0.5})

    def told(**message: object) -> list[str]:
        wanted = read(learnt, {"view": "bending", **message})
        numbers = describe.described(learnt, Library(learnt), wanted, tmp_path)["numbers"]
        return [each["value"] for each in numbers if each["said"] == "surrogate"]

    assert told() == told(inputs={"morph.xi1": 0.2}) == ["33.00 ± 0.50°"]
    assert told(inputs={"finger.wall_mm": 1.8}) == []
    assert told(inputs={"finger.override.3.wall_mm": 1.8}) == []
    assert told(pressure_kPa=100) == []


def test_a_supply_fills_designs_that_are_solved_at_rest(tmp_path: Path) -> None:
    """The design is that of a configuration without one; a syringe is refused."""
    file = tmp_path / "filled.toml"
    tables = short(
        "supply.board=programmable-air", "experiment.max_pressure_kPa=40",
        "protocol.time_s=[0,0,1]", "protocol.pressure_kPa=[0,40,40]",
    )  # fmt: skip
    file.write_text(config.dumps(tables), encoding="utf-8")
    varied = ["finger.wall_mm=1.4:2.2"]
    found = space.of_results([], file, {}, varied)
    assert found.supply == tables.supply
    file.write_text(config.dumps(short("experiment.max_pressure_kPa=40")), encoding="utf-8")
    without = space.of_results([], file, {}, varied)
    assert read(found, {"view": "bending"}).design == read(without, {"view": "bending"}).design
    syringe = {"supply.source": "syringe", "experiment.control": "volume"}
    with pytest.raises(ConfigError, match=r'supply\.source = "syringe"'):
        space.of_results([], None, syringe, varied)


@pytest.mark.parametrize(
    ("rise_s", "told"),
    [
        (0.4, "it follows the curve within "),
        (0.05, "the cavity is 27.5 kPa below the curve after 0.05 s, though the valve is fully"),
    ],
)
def test_a_supply_follows_the_curve_of_a_tab(rise_s: float, told: str) -> None:
    """A choked valve fills 4 cm³ from a large tank: C p₁ = 0.01 dm³/s, or 250 kPa/s at most."""
    tank = assignments([
        "supply.source=tank", "supply.tank_cm3=1e6", "supply.tank_kPa=898.675",
        "supply.valve_dm3_per_s_bar=0.001", "supply.exhaust_dm3_per_s_bar=1",
        "supply.tube_cm3=0.01", "supply.exponent=1", "experiment.max_pressure_kPa=40",
    ])  # fmt: skip
    found = space.of_results([], None, tank, ["finger.wall_mm=1.4:2.2"])
    wanted = read(found, {"view": "bending"})
    rigid = RestingFinger(np.array([0.0, 40.0]), np.full(2, 4000.0), np.zeros(2))
    asked = curve({"curve": {"rise_s": rise_s, "hold_s": 0.2}}, 40.0)
    assert asked[0] == pytest.approx([0, rise_s, rise_s + 0.2, 2 * rise_s + 0.2, 2 * rise_s + 0.4])
    shown = describe.followed(found, wanted, rigid, asked)
    valve = np.array(shown["chart"]["below"]["series"][0]["y"])
    assert valve[5] == pytest.approx(min(40 / rise_s / 250, 1.0), rel=0.02)
    assert shown["said"][0].startswith("at best the cavity has 95 % of 40 kPa 0.15 s after")
    assert shown["said"][1].startswith(told)
