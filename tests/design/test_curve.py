"""Curves that a finger's back shall follow: their files, their distance, what is out of reach.

References: differences of the same numbers, of order h²; lengths and angles by hand.
"""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import ezdxf
import numpy as np
import pytest
from support.example import EXAMPLES

from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.design.gradient import curve
from dolfingrip.design.gradient.descent import Descent, Trial
from dolfingrip.design.gradient.file import Circle, Cubic, Objective
from dolfingrip.design.gradient.read import read
from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.recorder import columns
from dolfingrip.experiments.request import Answer, Place, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.mechanics.readings.line import _curvature, _Distances
from dolfingrip.parameter import find
from dolfingrip.sections.curve import CurveTarget, Polyline

ARC = np.linspace(0, np.pi / 2, 30)
QUARTER = np.stack([-57.3 * (1 - np.cos(ARC)), 57.3 * np.sin(ARC)], axis=1)
"""A quarter circle towards −x, 90 mm long."""


def written(folder: Path, points: object, name: str = "curve.csv") -> Path:
    rows = "".join(f"{x},{z}\n" for x, z in points)  # type: ignore[attr-defined]
    file = folder / name
    file.write_text("x_mm,z_mm\n" + rows)
    return file


def loaded(file: Path, ends: str = "free") -> Config:
    asked = Objective(match=file, ends=ends)  # type: ignore[arg-type]
    return curve.given(asked, file.parent, Config())[0]


def test_files_of_all_kinds_are_one_curve(tmp_path: Path) -> None:
    text = " ".join(f"{x / 2},{z / 2 - 1}" for x, z in QUARTER)
    svg = tmp_path / "curve.svg"
    svg.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="10cm" viewBox="0 0 100 100">'
        f'<g transform="scale(2)"><polyline transform="translate(0 1)" points="{text}"/></g></svg>'
    )
    drawing = ezdxf.new(units=ezdxf.units.CM)
    drawing.modelspace().add_lwpolyline((QUARTER / 10).tolist())
    drawing.saveas(tmp_path / "curve.dxf")
    for file in (written(tmp_path, QUARTER), svg, tmp_path / "curve.dxf"):
        found = loaded(file, "fixed").curve
        assert found is not None
        np.testing.assert_allclose(np.stack([found.x_mm, found.z_mm], 1), QUARTER, atol=1e-9)
        assert found.ends == "fixed"


def test_a_circle_and_a_cubic_are_curves() -> None:
    """A quarter circle, and Bézier's curve of it, which is within 3e-4 of its radius."""
    radius = 90 / (np.pi / 2)
    circle = curve.given(Objective(match_circle=Circle(radius_mm=radius)), Path(), Config())[0]
    bend = 4 / 3 * (np.sqrt(2) - 1) * radius
    cubic = Cubic(x_mm=(0, 0, bend - radius, -radius), z_mm=(0, bend, radius, radius))
    other = curve.given(Objective(match_cubic=cubic), Path(), Config())[0]
    for found, off in ((circle.curve, 1e-12), (other.curve, 3e-4 * radius)):
        assert found is not None
        x, z = np.array(found.x_mm), np.array(found.z_mm)
        np.testing.assert_allclose(np.hypot(x + radius, z), radius, atol=off)
        assert (x[-1], z[-1]) == pytest.approx((-radius, radius))
    late = Objective(match_circle=Circle(radius_mm=20, straight_mm=30, angle_deg=90))
    found = curve.given(late, Path(), Config())[0].curve
    assert found is not None
    assert (found.x_mm[-1], found.z_mm[-1]) == pytest.approx((-20, 50))
    round_twice = Objective(match_circle=Circle(radius_mm=5))
    with pytest.raises(ConfigError, match=r"^objective.match_circle: crosses itself at x = "):
        curve.given(round_twice, Path(), Config())


LOOP = [(0, 0), (0, 40), (-20, 60), (-20, 20), (20, 20)]


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([(0, 0)], "1 point; allowed: two or more that differ"),
        ([(0, 0), (0, 0)], "1 point; allowed"),
        (QUARTER / 1000, "0.09 long; allowed: 30 to 270 mm for a finger of 90 mm; is it in mm?"),
        (QUARTER * 25.4, "2286 long; allowed: 30 to 270 mm"),
        (LOOP, "crosses itself at x = 0, z = 20 mm; allowed: a curve that does not"),
        (QUARTER + 30, "begins at x = 30, z = 30 mm; allowed: within 9 mm of the clamp's"),
        (QUARTER[::-1], "x = z = 0; its other end does"),
        ([(0, 0), (0, "nan")], "not finite"),
        ([(0, 0), (0, 40), (0, 20)], "crosses itself at x = 0, z = 40 mm"),
        ([(0, 0), (0, "far")], "line 3: allowed: two numbers, x_mm and z_mm"),
    ],
)
def test_what_is_no_curve_is_refused(tmp_path: Path, points: object, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        loaded(written(tmp_path, points))
    assert str(caught.value).startswith("objective.match = curve.csv: ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["curve.png", "absent.csv", "empty.csv", "text.svg", "text.dxf"])
def test_files_that_hold_none_are_refused(tmp_path: Path, name: str) -> None:
    if not name.startswith("absent"):
        (tmp_path / name).write_text("" if name.startswith("empty") else "a text")
    with pytest.raises(ConfigError):
        loaded(tmp_path / name)


def test_a_design_file_names_it(tmp_path: Path) -> None:
    written(tmp_path, QUARTER)
    file = tmp_path / "design.toml"
    file.write_text(
        '[objective]\nmatch = "curve.csv"\nat_pressure_kPa = [100.0, 150.0]\n'
        "[parameters]\nfinger.override.3.depth_mm = [12.0, 18.0]\n"
    )
    problem = read(file)
    assert str(problem.objective) == "curve_mean_square_mm2 at 100, 150 kPa"
    assert [each.start for each in problem.variables] == [16.0]
    assert len(problem.parts) == 2 * 16
    assert curve.backwards(problem) == ""
    written(tmp_path, QUARTER * [-1, 1])
    assert "turns backwards by 88° beyond 9 mm of it" in (told := curve.backwards(read(file)))
    assert "mm (root mean square)" in told


def test_the_nearest_that_bends_forwards_is_told(tmp_path: Path) -> None:
    """An arc to the wrong side: no line is nearer than a straight one, which stretches if it helps.

    Reference: distances of a straight line's places from the mirrored arc, counted by hand.
    """
    written(tmp_path, QUARTER * [-1, 1])
    file = tmp_path / "design.toml"
    file.write_text(
        '[objective]\nmatch = "curve.csv"\nat_pressure_kPa = 100.0\n'
        "[parameters]\nfinger.override.3.depth_mm = [12.0, 18.0]\n"
    )
    problem = read(file)
    base = problem.nominal.base
    line = Polyline(base.curve.lines[0])
    rms = []
    for stretch in np.linspace(1.0, 1.2, 21):
        z = np.linspace(0, 1, base.curve.places + 1) * base.geometry.length_mm * stretch
        straight = np.stack([0 * z, z], axis=1)
        off = line.nearest(straight)[0] - straight
        rms.append(np.sqrt((off**2).sum(axis=1).mean()))
    told = curve.backwards(problem)
    near = float(told.partition("as near as about ")[2].partition(" mm")[0])
    assert near == pytest.approx(min(rms), rel=0.05)


def bent(pieces: list[tuple[float, float]]) -> np.ndarray:
    """Points (n, 2) of pieces with a length (mm) and a turn (deg) towards −x each."""
    directions, start = [], 0.0
    for _, turn in pieces:
        directions += [start + turn * (i + 0.5) / 50 for i in range(50)]
        start += turn
    steps = np.repeat([length / 50 for length, _ in pieces], 50)[:, None]
    angle = np.radians(directions)[:, None]
    ways = steps * np.hstack([-np.sin(angle), np.cos(angle)])
    return np.concatenate([[[0.0, 0.0]], np.cumsum(ways, axis=0)])


EVERY = "".join(
    f"finger.override.{i}.{key} = {ends}\n"
    for i in range(1, 9)
    for key, ends in {"depth_mm": "[12.0, 22.0]", "wall_mm": "[1.2, 3.0]"}.items()
)


@pytest.mark.parametrize(
    ("pieces", "at_kPa", "low_mm", "high_mm", "why"),
    [
        ([(12, 0), (72, 90), (6, 0)], 150.0, 0.0, 0.1, ""),
        # the ordinates of an S whose end is straight again; a straight line of its chord is as near
        ([(45, 20), (45, -20)], 150.0, 0.5, 1.2, "it bends to one side alone"),
        ([(45, -40), (45, 60)], 150.0, 14.0, 18.0, "it bends to one side alone"),
        ([(12, 0), (78, 270)], 150.0, 4.0, 12.0, r"it turns by about 1[5-9]\d° at 150 kPa"),
        ([(12, 0), (72, 90), (6, 0)], 50.0, 3.0, 10.0, r"it turns by about [5-6]\d° at 50 kPa"),
    ],
    ids=["arc", "weak S", "backwards", "270", "little pressure"],
)
def test_what_a_finger_can_do_is_forecast(
    tmp_path: Path, pieces: list[tuple[float, float]], at_kPa: float, low_mm: float,
    high_mm: float, why: str
) -> None:  # fmt: skip
    """Reference for 270°: at the forecast turn a circle of the same length ends far from it.

    The design of ``backwards`` reaches 22.6 mm (benchmarks/curves.csv), no less than is forecast.
    """
    written(tmp_path, bent(pieces))
    file = tmp_path / "design.toml"
    file.write_text(
        f'[objective]\nmatch = "curve.csv"\nat_pressure_kPa = {at_kPa}\n[parameters]\n{EVERY}'
    )
    told = curve.forecast(read(file))
    said, _, reason = told.partition(" at best")
    print(told)
    near = float(said.removeprefix("a finger of this kind can follow this curve to about ")[:-7])
    assert low_mm <= near <= high_mm
    assert re.fullmatch(rf": {why}( \(an estimate\))?" if why else "", reason)


def test_the_turn_is_that_of_simulated_fingers() -> None:
    """Two bellows at 50 kPa, simulated on this mesh: no less, and at most a fourth more."""
    small = {"finger.length_mm": 36.0, "finger.bellows": 2, "mesh.size_mm": 8.0}
    for sizes in ({"finger.wall_mm": 1.2}, {"finger.wall_mm": 2.2}, {"finger.depth_mm": 22.0}):
        config = changed(Config(), {**small, "mesh.edge_size_mm": 4.0, **sizes})
        place = (Place("pressure_kPa", 50.0),)
        found = compute(Request.of("bending", config, columns=("angle_deg",), places=place))
        problem = SimpleNamespace(nominal=SimpleNamespace(base=config), variables=())
        foretold = np.degrees(50 * curve.most_turned(problem).sum())  # type: ignore[arg-type]
        assert 0.97 < foretold / found.columns["angle_deg"][0] < 1.25


LATE, EARLY = ({"straight_mm": 30.0, "radius_mm": radius} for radius in (40.0, 80.0))


def several(folder: Path, at: str) -> Path:
    """A design file with two curves, the one of the higher pressure first."""
    written(folder, QUARTER)
    file = folder / "design.toml"
    file.write_text(
        f'[objective]\nmatch = ["curve.csv", "early.csv"]\nat_pressure_kPa = {at}\n'
        "[parameters]\nfinger.wall_mm = [1.2, 2.0]"
    )
    written(folder, QUARTER * [0.5, 1], "early.csv")
    return file


def test_a_curve_for_each_pressure(tmp_path: Path) -> None:
    """Between pressures a place goes from one curve to the other along a straight line."""
    problem = read(several(tmp_path, "[150.0, 50.0]"))
    assert str(problem.objective) == "curve_mean_square_mm2 at 150, 50 kPa"
    assert len(problem.parts) == 2 * 16
    target = problem.nominal.base.curve
    assert target is not None
    assert not target.of_tip
    at = target.targets()
    for pressure, by in ((0.0, 0.5), (50.0, 0.5), (150.0, 1.0), (200.0, 1.0)):
        np.testing.assert_allclose(at(pressure).points, QUARTER * [by, 1], atol=1e-9)
    shares = np.linspace(0, 1, 7)
    middle = np.mean([Polyline(QUARTER * [by, 1]).at(shares) for by in (0.5, 1.0)], axis=0)
    np.testing.assert_allclose(at(100.0).nearest(middle)[0], middle, atol=0.02)
    assert curve.backwards(problem) == ""
    circles = Objective(match_circle=[LATE, EARLY], at_pressure_kPa=(50.0, 100.0))  # type: ignore[arg-type]
    found = curve.given(circles, tmp_path, Config())[0].curve
    assert found is not None
    assert [len(each) for each in found.lines] == [81, 81]


@pytest.mark.parametrize("at", ["150.0", "[150.0, 150.0]", "[50.0, 100.0, 150.0]"])
def test_as_many_pressures_as_curves(tmp_path: Path, at: str) -> None:
    with pytest.raises(ConfigError) as caught:
        read(several(tmp_path, at))
    assert str(caught.value).startswith("objective.at_pressure_kPa = ")
    assert str(caught.value).endswith("allowed: 2 that differ, one for each curve")


def test_distances_are_from_the_curve_of_each_pressure(tmp_path: Path) -> None:
    """Of three bellows at two pressures: as with each curve alone, and so are the slopes."""
    pressures = {10.0: 0.5, 20.0: 1.0}
    rows: dict[str, object] = {
        "x_mm": [x for by in pressures.values() for x in by * QUARTER[:, 0]],
        "z_mm": [*QUARTER[:, 1], *QUARTER[:, 1]],
        "pressure_kPa": [each for each in pressures for _ in QUARTER],
    }
    names = ("curve_mean_square_mm2", "curve_part_1_mm")
    key = "finger.override.2.wall_mm"

    def run(curve_of: dict[str, object], *at: float) -> Answer:
        config = changed(Config(), {**SMALL, **{f"curve.{k}": v for k, v in curve_of.items()}})
        places = tuple(Place("pressure_kPa", each) for each in at)
        return compute(Request.of("bending", config, [key], columns=names, places=places))

    both = run(rows, *pressures)
    for i, (pressure, by) in enumerate(pressures.items()):
        one = {"x_mm": (by * QUARTER[:, 0]).tolist(), "z_mm": QUARTER[:, 1].tolist()}
        alone = run(one, pressure)
        for name in names:
            assert both.columns[name][i] == pytest.approx(alone.columns[name][0], rel=1e-7)
            slopes = both.slopes[name, key][i], alone.slopes[name, key][0]
            assert slopes[0] == pytest.approx(slopes[1], rel=1e-5)


WAY = [(50, -20, 85), (100, -50, 60)]


@pytest.mark.parametrize(
    ("rows", "added", "said"),
    [
        (WAY[:1], "", "match_path = tip.csv: 1 row; allowed: two or more that differ"),
        (WAY[::-1], "", "pressure_kPa does not rise from row to row; allowed: rising"),
        (np.array(WAY) / [1, 1e3, 1e3], "", "is it in mm?"),
        (WAY, "at_pressure_kPa = 50.0", "objective.at_pressure_kPa = 50.0: allowed: without match"),
        (WAY, 'match = "tip.csv"', "2 quantities; allowed: one of maximise =, minimise =, match ="),
    ],
)
def test_a_way_of_the_tip_that_is_none(tmp_path: Path, rows: object, added: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        read(way(tmp_path, rows, added))
    assert said in str(caught.value)


def way(folder: Path, rows: object, added: str = "") -> Path:
    text = "".join(f"{p},{x},{z}\n" for p, x, z in rows)  # type: ignore[attr-defined]
    (folder / "tip.csv").write_text(f"pressure_kPa,x_mm,z_mm\n{text}")
    file = folder / "design.toml"
    file.write_text(
        f'[objective]\nmatch_path = "tip.csv"\n{added}\n[parameters]\nfinger.wall_mm = [1.2, 2.0]'
    )
    return file


def test_a_way_of_the_tip_is_the_mean_over_its_pressures(tmp_path: Path) -> None:
    """Of three bellows at 10 and 20 kPa: distances of its marker, and their parts' squares."""
    problem = read(way(tmp_path, [(10, 1, 43), (20, -15, 44)]))
    assert str(problem.objective) == "curve_mean_square_mm2 at 10, 20 kPa"
    assert [str(each) for each in problem.parts] == [
        f"curve_part_{i}_mm at {p} kPa" for i in (1, 2) for p in (10, 20)
    ]
    assert curve.backwards(problem) == ""
    names = ("curve_mean_square_mm2", "marker_1_x_mm", "marker_1_z_mm", "curve_part_1_mm")
    config = changed(problem.nominal.base, {**SMALL, "camera.markers": 1})
    places = tuple(Place("pressure_kPa", each) for each in (10.0, 15.0, 20.0))
    found = compute(Request.of("bending", config, columns=names, places=places)).columns
    x, z = found["marker_1_x_mm"], found["marker_1_z_mm"]
    away = np.stack([x - [1, -7, -15], z - [43, 43.5, 44]], axis=1)
    np.testing.assert_allclose(found["curve_mean_square_mm2"], (away**2).sum(axis=1), rtol=1e-9)
    np.testing.assert_allclose(found["curve_part_1_mm"], away[:, 0], rtol=1e-9)


def test_what_the_curve_does_not_determine_is_told(tmp_path: Path) -> None:
    """Three numbers of which 1 and 2 bend alike, and 3 is not felt; parts that are written down."""
    written(tmp_path, QUARTER)
    file = tmp_path / "design.toml"
    keys = [f"finger.override.{i}.depth_mm" for i in (1, 2, 3)]
    ranges = "".join(
        f"{key} = [12.0, {high}]\n" for key, high in zip(keys, (17, 22, 17), strict=True)
    )
    file.write_text(
        f'[objective]\nmatch = "curve.csv"\nat_pressure_kPa = 9\n[parameters]\n{ranges}'
    )
    problem = read(file)
    of_each = np.array([[3.0, 1.5, 0.0], [2.0, 1.0, 0.001]])  # mm, for a whole range
    trial = Trial(np.full(3, 0.5), np.full(3, 15.0), None, 1, objective=0.04)  # type: ignore[arg-type]
    trial.signed, trial.signed_slopes = np.array([0.04]), np.zeros((1, 3))
    trial.of_parts = 2 * of_each.T @ of_each
    told = curve.matched(problem, Descent([trial], trial, "", [], 1, 1.0))
    assert told is not None
    assert told.rms_mm == pytest.approx(0.2)
    assert set(told.tied) == {keys[1], keys[2]}
    assert told.tied[keys[2]] == {}
    # a whole range of 10 mm of the second is half a range of 5 mm of the first
    assert told.tied[keys[1]] == {keys[0]: pytest.approx(-0.25, rel=1e-3)}


@pytest.mark.parametrize(
    ("name", "variables", "objective"),
    [
        ("curve_design", 16, "curve_mean_square_mm2 at 150 kPa"),
        ("path_design", 3, "curve_mean_square_mm2 at 40, 80, 120 kPa"),
        ("wrap_design", 1 + 2 * 10, "obstacle_spread at 2 N"),
    ],
)
def test_the_examples_are_problems(name: str, variables: int, objective: str) -> None:
    problem = read(EXAMPLES / f"{name}.toml")
    assert len(problem.variables) == variables
    assert str(problem.objective) == objective
    assert curve.backwards(problem) == ""


@pytest.mark.parametrize("ends", ["free", "fixed"])
def test_distances_and_their_derivatives(ends: str) -> None:
    rng = np.random.default_rng(1)
    target = CurveTarget(x_mm=tuple(QUARTER[:, 0]), z_mm=tuple(QUARTER[:, 1]), ends=ends, places=24)  # type: ignore[arg-type]
    found = _Distances(target, SimpleNamespace(value=0.0))  # type: ignore[arg-type]
    on_it = Polyline(QUARTER).at(found.shares)
    assert found.mean_square(on_it)[0] == pytest.approx(0, abs=1e-3)  # of its chords
    points = on_it + rng.normal(0, 0.5, on_it.shape)
    way, step = rng.normal(size=points.shape), 1e-6
    for function in (found.mean_square, found.part(1), found.part(4)):
        _, slopes = function(points)
        ends_ = [function(points + by * way)[0] for by in (step, -step)]
        assert (slopes * way).sum() == pytest.approx((ends_[0] - ends_[1]) / 2 / step, rel=1e-5)


def test_curvature_of_a_circle() -> None:
    points = 50 * np.stack([np.cos([0.0, 0.1, 0.2]) - 1, np.sin([0.0, 0.1, 0.2])], axis=1)
    value, slopes = _curvature(points)
    assert value == pytest.approx(20 * 0.1 / 2 / np.sin(0.05))  # 1/m, of chords
    way = np.random.default_rng(2).normal(size=(3, 2))
    ends = [_curvature(points + by * way)[0] for by in (1e-5, -1e-5)]
    assert (slopes * way).sum() == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-6)


SMALL = {
    **{"finger.bellows": 3, "finger.length_mm": 45.0, "solver.rtol": 1e-11},
    **{"mesh.size_mm": 8.0, "mesh.edge_size_mm": 8.0},
}


@pytest.mark.parametrize("markers", [4, [[1.2, 9.0], [1.0, 22.5], [1.5, 33.0], [1.1, 44.0]]])
def test_readings_along_the_line_have_derivatives(markers: object) -> None:
    """Three bellows at 20 kPa, against differences on the moving mesh."""
    names = ("curve_mean_square_mm2", "curve_part_3_mm", "marker_3_x_mm", "curvature_2_per_m")
    start = changed(
        Config(),
        {
            **SMALL,
            "camera.markers": markers,
            "curve.x_mm": QUARTER[:, 0].tolist(),
            "curve.z_mm": QUARTER[:, 1].tolist(),
        },
    )
    keys, step = ["finger.override.2.wall_mm", "finger.length_mm"], 2e-3
    places = (Place("pressure_kPa", 20.0),)

    def run(found: Config, keys: list[str] | None = None) -> object:
        return compute(
            Request.of("bending", found, keys, columns=names, places=places, made_for=start)
        )

    slopes = run(start, keys).slopes  # type: ignore[attr-defined]
    for each in find(start, keys):
        up, down = (run(each.at(start, each.value(start) + by)).columns for by in (step, -step))  # type: ignore[attr-defined]
        for name in names:
            expected = (up[name][0] - down[name][0]) / 2 / step
            assert slopes[name, each.key][0] == pytest.approx(expected, rel=1e-5)


def test_points_of_the_side_stay_near_the_back() -> None:
    """At rest they are where they are told; under pressure the middle of the back bows out, too."""
    there = [[0.0, 15.0], [0.0, 30.0], [0.0, 45.0]]
    seen = {}
    for name, markers in (("back", 3), ("side", there)):
        asked = changed(Config(), {**SMALL, "camera.markers": markers})
        names = [f"marker_{i}_{axis}_mm" for i in (1, 2, 3) for axis in "xz"]
        places = (Place("pressure_kPa", 0.0), Place("pressure_kPa", 40.0))
        found = compute(Request.of("bending", asked, None, columns=names, places=places))
        seen[name] = np.array([found.columns[each] for each in names])
    np.testing.assert_allclose(seen["side"][:, 0], np.ravel(there), atol=1e-9)
    moved = np.abs(seen["back"] - seen["back"][:, :1]).max()
    assert moved > 3
    assert np.abs(seen["side"] - seen["back"]).max() < 0.2 * moved
    with pytest.raises(ConfigError, match=r"camera.markers: \[9, 50\] is not on the finger's side"):
        compute(Request.of("bending", changed(Config(), {**SMALL, "camera.markers": [[9, 50]]})))


def test_a_ball_off_the_side_turns_with_what_is_nearest() -> None:
    """At the back's edge and 1 mm off it; by a camera's noise every marker may seem to be off."""
    there = [[0.0, 20.0], [-1.0, 20.0], [0.0, 21.0]]
    asked = changed(Config(), {**SMALL, "camera.markers": there})
    names = [f"marker_{i}_{axis}_mm" for i in (1, 2, 3) for axis in "xz"]
    places = (Place("pressure_kPa", 0.0), Place("pressure_kPa", 40.0))
    found = compute(Request.of("bending", asked, None, columns=names, places=places))
    rest, bent = np.array([found.columns[each] for each in names]).T.reshape(2, 3, 2)
    np.testing.assert_allclose(rest, there, atol=1e-9)
    along, off = bent[2] - bent[0], bent[0] - bent[1]
    turn = np.arctan2(-along[0], along[1])
    assert turn > np.radians(1)
    np.testing.assert_allclose(off, [np.cos(turn), np.sin(turn)], atol=0.05)


@pytest.mark.parametrize("markers", [3, [[1, 5], [1, 9], [1, 20]]])
def test_markers_are_columns_on_request(markers: object) -> None:
    plain = columns(Bending(), (), Config())
    asked = columns(Bending(), (), changed(Config(), {"camera.markers": markers}))
    added = [name for name in asked if name not in plain]
    places = [f"marker_{i}_{axis}_mm" for i in (1, 2, 3) for axis in "xz"]
    assert added == [*places, "curvature_2_per_m"]
