"""An effect owns what is known of it: a diagnosis knows none by name, and takes any registered."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.checkout import needs_checkout

from dolfingrip.extensions.index import NAMES

ROOT = Path(__file__).resolve().parents[2]
DIAGNOSIS = ROOT / "dolfingrip" / "diagnosis"
OUTSIDE = ROOT / "tests" / "additions" / "load_curve.py"


def said(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """Identifiers and words of texts, but those of docstrings, with their lines."""
    for node in ast.walk(tree):
        match node:
            case ast.Expr(value=ast.Constant(value=str() as text)) as docstring:
                docstring.value.value = ""
            case ast.Name(id=name) | ast.arg(arg=name) | ast.Attribute(attr=name):
                yield name, node.lineno
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.alias(name=name):
                yield name, node.lineno
            case ast.keyword(arg=str() as name):
                yield name, node.value.lineno
            case ast.Constant(value=str() as text):
                yield from ((word, node.lineno) for word in re.findall(r"\w+", text))


@needs_checkout
def test_a_diagnosis_knows_no_effect_by_name() -> None:
    names = {*NAMES}
    assert "yeoh" in names
    for file in sorted(DIAGNOSIS.rglob("*.py")):
        words = said(ast.parse(file.read_text(encoding="utf-8")))
        named = [(name, line) for name, line in words if name in names]
        assert not named, f"{file.relative_to(ROOT)}: {named}"


def test_a_name_is_noticed_wherever_it_stands() -> None:
    """Reference: by hand."""
    for line in ('x = "extensions.yeoh.c2"', "yeoh = 1", "config.extensions.yeoh", "f(yeoh=1)"):
        assert "yeoh" in {name for name, _ in said(ast.parse(line))}
    assert "yeoh" not in {name for name, _ in said(ast.parse('"""As yeoh does."""'))}


SCRIPT = """
import json, sys
from pathlib import Path
import dolfingrip
dolfingrip.plugin(sys.argv[1])
import numpy as np
from dolfingrip.config import Config, from_dict
from dolfingrip.diagnosis.answer.diagnosis import diagnosed
from dolfingrip.diagnosis.answer.settling import settled_by
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.screening import analyse
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.results import write
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.files.diagnosis_words import page
from dataclasses import replace

folder = Path(sys.argv[2])
on = from_dict({"extensions": {"load_curve": {"bend_per_N": float(sys.argv[3])}}})
measurement = read([folder / "coupon.csv"], Config())
causes = unknowns(measurement, Config(), sys.argv[4:])
pulled = analyse(CouponSimulation(measurement, Config()), causes)
hidden = CouponSimulation(measurement, on).configured
noise = pulled.errors.noise * np.random.default_rng(3).standard_normal(len(hidden))
own = replace(pulled, problem=replace(pulled.problem, value=hidden + noise))
found = diagnosed(own, Config(), quick=True)
found.next, _ = settled_by(found, print, simulating=False)
print(json.dumps({
    "answer": found.decision.answer, "first": found.decision.first,
    "numbers": {each.key: each.value for each in found.numbers(found.decision.best)},
    "next": [each.name for each in found.next],
    "page": page(write(found, [folder / "coupon.csv"], folder)[0]),
}))
"""
TOLD = """experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.02
[nuisance]
coupon_slack_mm = 0.0
material_law = 0.0
"""


def diagnosed(folder: Path, bend_per_N: float, *effects: str) -> dict[str, object]:
    """The answer to a coupon's readings through a load cell with that curve, in a process."""
    rows = "\n".join(f"{t},{t / 2},0" for t in range(0, 34, 2))
    (folder / "coupon.csv").write_text(f"time_s,displacement_mm,force_N\n{rows}\n")
    (folder / "coupon.toml").write_text(TOLD)
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *map(str, (OUTSIDE, folder, bend_per_N)), *effects],
        capture_output=True, text=True, check=False, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    print("seed 3", done.stdout)
    answer: dict[str, object] = json.loads(done.stdout.splitlines()[-1])
    return answer


@needs_checkout
def test_an_effect_from_outside_is_named(tmp_path: Path) -> None:
    """Its number, words, and place in the configuration are those of its class."""
    found = diagnosed(tmp_path, 0.02, "load_curve", "force_gain", "force_offset")
    assert (found["answer"], found["first"]) == ("cause", ["load_curve"])
    numbers = found["numbers"]
    assert isinstance(numbers, dict)
    assert numbers["extensions.load_curve.bend_per_N"] == pytest.approx(0.02, rel=0.1)
    assert "a load cell that reads ever more as the load grows" in str(found["page"])


@needs_checkout
def test_it_is_checked_and_advised_where_laws_do_the_same(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, 0.002, "load_curve", "ogden_terms", "yeoh")
    assert "load_curve" in str(found["page"])
    assert "several weights on the load cell" in str(found["next"])
    third = str(found["page"]).splitlines()[2]
    assert "several weights on the load cell" in third
    assert "10 minutes" in third
