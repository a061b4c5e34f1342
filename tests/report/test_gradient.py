"""A design by gradients on a page: its steps, what was not kept, and its gain."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dolfingrip.channels import CURVE
from dolfingrip.files.design import CURVE_SQUARE, DesignFile
from dolfingrip.report.page import sources

CONTENT = {
    "of": "maximise force_N at 250 kPa", "objective": 3.0, "start": 2.5, "gain": 0.2,
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
        ("Design: mass_g", "fail"), ("Design: cog_offset_mm", "pass"),
    ]  # fmt: skip
    gained = "+20.0 % by 3 simulations; +19.0 % on a finer mesh"
    assert ("3 N", gained) in [(number.value, number.said) for number in page.numbers]


def test_a_curve_has_root_mean_squares_in_mm(tmp_path: Path) -> None:
    """Mean squares of 4, 1 and 0.25 mm² are distances of 2, 1 and 0.5 mm, half as far each time."""
    content = {
        **CONTENT, "of": "minimise curve_mean_square_mm2 at 150 kPa", "start": 4.0,
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
    assert page.charts[0].y.label == "Root mean square distance from the curve (mm)"
    (number,) = [each for each in page.numbers if "of the design" in each.name]
    assert number.value == "1 mm"
    assert "mean_square" not in page.charts[0].alt
