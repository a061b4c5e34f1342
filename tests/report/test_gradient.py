"""A design by gradients on a page: start beside design, its steps, its limits, and its gain."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support import synthetic_run

from dolfingrip.channels import CURVE, marker
from dolfingrip.files.design import CURVE_SQUARE, MARKERS, DesignFile
from dolfingrip.report.design import followed
from dolfingrip.report.page import sources
from dolfingrip.sections.curve import CurveTarget

CONTENT = {
    "of": "maximise force_N at 250 kPa", "quantity": "force_N", "objective": 3.0, "start": 2.5,
    "gain": 0.2,
    "constraints": [
        {"of": "cog_offset_mm", "sense": "at most", "limit": 3.0, "value": 2.9, "kept": True},
        {"of": "mass_g", "sense": "at most", "limit": 20.0, "value": 20.6, "kept": False},
    ],
    "simulations": 3, "ending": "no step promises more", "refined": {"gain": 0.19},
    "parameters": {"morph.xi1": {"start": 0.0, "value": 0.51, "low": -0.2, "high": 1.0}},
}  # fmt: skip
STEPS = "simulations,accepted,objective\n1,True,2.5\n2,False,2.4\n3,True,3.0\n"


def test_what_the_page_has(tmp_path: Path) -> None:
    (tmp_path / "design.json").write_text(json.dumps(CONTENT), encoding="utf-8")
    (tmp_path / "steps.csv").write_text(STEPS, encoding="utf-8")
    page = sources.build(sources.find([tmp_path]))
    accepted, refused = page.charts[0].series
    assert list(accepted.y) == [2.5, 3.0]
    assert list(refused.y) == [2.4]
    assert page.charts[0].y.label == "Blocked force (N)"
    assert page.tables[0].rows == [["morph.xi1", "0", "0.51", "-0.2 to 1"]]
    assert [(check.name, check.verdict) for check in page.checks] == [
        ("Design: mass_g", "fail"), ("Design: mesh", "open"), ("Design: cog_offset_mm", "pass"),
    ]  # fmt: skip
    gained = "+20.0 % by 3 simulations; +19.0 % on a finer mesh"
    assert ("3 N", gained) in [(number.value, number.said) for number in page.numbers]


def test_start_and_design_are_shown_beside_each_other(tmp_path: Path) -> None:
    """Their runs give scenes, curves and sections; the design's numbers are those of its file."""
    refined = {"start": 2.5, "objective": 3.05, "gain": 0.22}  # 1.6 % more than 3
    content = {**CONTENT, "refined": refined}
    (tmp_path / "design.json").write_text(json.dumps(content), encoding="utf-8")
    for name in ("start", "design", "another"):  # which is no part of it
        synthetic_run.write_result(tmp_path / name)
    found = sources.find([tmp_path])
    assert [(each.kind, each.folder.name, each.inside) for each in found] == [
        ("design", tmp_path.name, False), ("run", "start", True), ("run", "design", True),
    ]  # fmt: skip
    page = sources.build(found)
    assert page.title == "Design by gradients"
    titles = ["Free bending, start", "Free bending, design"]
    assert [scene["title"] for scene in page.scenes] == titles
    assert {scene["kind"] for scene in page.scenes} == {"bending"}  # so they are shown at once
    curves, section = page.charts
    assert [each.name for each in curves.series] == ["start: tip face", "design: tip face"]
    assert section.equal
    for each in section.series:  # in mm
        sizes = (synthetic_run.LENGTH_MM, synthetic_run.DEPTH_MM)
        for values, size in zip((each.x, each.y), sizes, strict=True):
            assert (np.nanmin(values), np.nanmax(values)) == pytest.approx((0.0, size), abs=1e-9)
    names = {number.name: number.value for number in page.numbers}
    assert names["Blocked force of the start"] == "2.5 N"
    assert names["Blocked force of the design"] == "3 N"
    assert not any("angle" in name for name in names)
    meshes = [check for check in page.checks if "mesh" in check.name]
    assert [(each.name, each.value, each.verdict) for each in meshes] == [
        ("Design: mesh", "1.6 %", "pass"),
    ]  # fmt: skip


def test_lines_stand_beside_the_curve_that_they_follow() -> None:
    """At the curve's pressure, between readings; a way of the tip has that of the last marker."""
    p, along = np.array([0.0, 40.0, 80.0]), np.arange(1, MARKERS + 1) / MARKERS
    table = {"pressure_kPa": p}
    for i, share in enumerate(along, 1):
        table |= {marker(i, "x").name: -0.1 * p * share, marker(i, "z").name: 50.0 * share + 0 * p}
    tables = {"start": table, "design": {**table, marker(MARKERS, "x").name: -0.2 * p}}
    line = {"x_mm": (0.0, -3.0), "z_mm": (0.0, 50.0)}
    (last,) = followed(CurveTarget(**line), tables)
    assert last.title == "Back of the finger at 80 kPa"
    wanted, start, design = last.series
    assert (list(wanted.x), list(wanted.y)) == ([0.0, 50.0], [0.0, -3.0])
    np.testing.assert_allclose(start.x, [0.0, *(50.0 * along)])
    np.testing.assert_allclose(start.y, [0.0, *(-8.0 * along)])
    assert design.y[-1] == -16.0
    doubled = {key: (*values, *values) for key, values in line.items()}
    two = followed(CurveTarget(**doubled, pressure_kPa=(20.0, 20.0, 60.0, 60.0)), tables)
    assert [each.series[1].y[-1] for each in two] == pytest.approx([-2.0, -6.0])
    (way,) = followed(CurveTarget(**line, pressure_kPa=(0.0, 80.0)), tables)
    assert way.title == "Way of the tip"
    np.testing.assert_allclose(way.series[2].y, -0.2 * p)
    np.testing.assert_allclose(way.series[2].x, 50.0)


def test_a_curve_has_root_mean_squares_in_mm(tmp_path: Path) -> None:
    """Mean squares of 4, 1 and 0.25 mm² are distances of 2, 1 and 0.5 mm, half as far each time."""
    content = {
        **CONTENT, "of": "minimise curve_mean_square_mm2 at 150 kPa", "quantity": CURVE_SQUARE,
        "start": 4.0,
        "objective": 1.0, "gain": -0.75, "constraints": [],
        "refined": {"start": 1.0, "objective": 0.25, "gain": -0.75},
        "starts": [{"ending": "a", "start": 4.0, "objective": 1.0}, {"ending": "failed"}],
    }  # fmt: skip
    (tmp_path / "design.json").write_text(json.dumps(content), encoding="utf-8")
    steps = "simulations,accepted,objective\n1,True,4.0\n2,True,1.0\n"
    (tmp_path / "steps.csv").write_text(steps, encoding="utf-8")
    assert CURVE.name == CURVE_SQUARE
    shown = DesignFile.read(tmp_path).shown
    assert (shown.of, shown.start, shown.objective) == ("minimise curve_rms_mm at 150 kPa", 2, 1)
    assert shown.gain == pytest.approx(-0.5)
    assert shown.refined is not None
    assert (shown.refined.start, shown.refined.objective) == (1.0, 0.5)
    assert [each.objective for each in shown.starts] == [1.0, None]
    page = sources.build(sources.find([tmp_path]))
    assert list(page.charts[0].series[0].y) == [2.0, 1.0]
    assert page.charts[0].y.label == "RMS distance from curve (mm)"
    assert [each.value for each in page.numbers[:2]] == ["2 mm", "1 mm"]
    assert "mean_square" not in page.charts[0].alt
