"""What a notebook and a console show: names loaded as they are used, completion, tables."""

from __future__ import annotations

import importlib
import subprocess
import sys
from html import escape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dolfingrip as dg
from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.result import Result
from dolfingrip.files.design import DesignConstraint, DesignFile, DesignParameter
from dolfingrip.files.text_table import TextTable

ROOT = Path(__file__).resolve().parents[1]
COLUMNS, ROWS = 100, 60
"""Characters and lines of a console."""

DESIGN = DesignFile(
    of="maximise force_N", objective=2.5, start=2.0, simulations=12,
    ending="no step <promises> more",
    parameters={"finger.wall_mm": DesignParameter(start=1.6, value=1.8, low=1, high=2)},
    constraints=(
        DesignConstraint(of="mass_g", sense="at most", limit=30, value=29.5, kept=True),
    ),
)  # fmt: skip
READINGS = [
    {"experiment": "bending", "pressure_kPa": p, "angle_deg": 0.4 * p, "branch": "loading"}
    for p in (0.0, 50.0, 100.0)
]


def _of_a_new_process(code: str) -> str:
    return subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout


def test_packages_are_loaded_as_they_are_used() -> None:
    said = _of_a_new_process(
        "import sys, dolfingrip as dg\n"
        "print('dolfingrip.config' in sys.modules)\n"
        "print(dg.config.load({'finger.wall_mm': 1.8}).finger.wall_mm)\n"
        "print(dg.experiments.run.__module__, dg.report.render.draw.__name__)\n"
    )
    assert said.split() == ["False", "1.8", "dolfingrip.experiments.loop", "draw"]
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = dg.nothing  # type: ignore[attr-defined]


def test_dir_shows_what_the_api_pages_describe(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each package that has a module on these pages, and no other name."""
    monkeypatch.syspath_prepend(ROOT / "docs/_ext")
    pages = importlib.import_module("api").PAGES
    described = {module.split(".")[0] for *_, modules in pages for module in modules.split()}
    assert dir(dg) == sorted({*described, "plugin"})


def test_values_by_key_are_a_configuration(tmp_path: Path) -> None:
    assert config.load({"finger.wall_mm": 1.8}) == config.load(None, {"finger.wall_mm": 1.8})
    assert config.load({"finger": {"wall_mm": 1.8}}).finger.wall_mm == 1.8
    # those that are called overrides count
    assert config.load({"finger.wall_mm": 1.8}, {"finger.wall_mm": 2.0}).finger.wall_mm == 2.0
    with pytest.raises(ConfigError, match=r"^finger\.wall: unknown key; did you mean finger\.wall"):
        config.load({"finger.wall": 1.8})


@pytest.mark.parametrize("section", ["", *Config().tables])
def test_jedi_completes_each_section_of_a_live_configuration(section: str) -> None:
    """IPython and Jupyter ask jedi."""
    jedi = pytest.importorskip("jedi")
    finger = config.load({"finger.kind": "pneunet"})
    place: Any = getattr(finger, section) if section else finger
    typed = f"finger.{section}." if section else "finger."
    offered = {each.name for each in jedi.Interpreter(typed, [{"finger": finger}]).complete()}
    assert set(type(place).model_fields) <= offered


def test_a_shell_completes_the_columns_of_a_result() -> None:
    pytest.importorskip("IPython")
    from IPython.core.completer import provisionalcompleter
    from IPython.core.interactiveshell import InteractiveShell

    shell = InteractiveShell()
    shell.user_ns["result"] = Result("bending", Config(), READINGS)
    typed = 'result["'
    with provisionalcompleter():
        offered = [each.text for each in shell.Completer.completions(typed, len(typed))]
    assert {"pressure_kPa", "angle_deg"} <= {text.strip('"') for text in offered}


def test_the_api_is_completed_before_it_is_loaded() -> None:
    pytest.importorskip("jedi")
    said = _of_a_new_process(
        "import jedi, dolfingrip as dg\n"
        "typed = 'dg.', 'dg.config.', 'dg.experiments.'\n"
        "for text in typed:\n"
        "    print(*[n.name for n in jedi.Interpreter(text, [{'dg': dg}]).complete()])\n"
    )
    packages, functions, experiments = (set(line.split()) for line in said.splitlines())
    assert {"config", "experiments", "report"} <= packages
    assert {"load", "changed"} <= functions
    assert {"run", "Result"} <= experiments


class _Cells(HTMLParser):
    """The texts of an HTML's cells, by row, and the names of its tags."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open: list[str] = []
        self.feed(text)
        assert self.open == []  # each tag is closed

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def _fits(text: str) -> bool:
    lines = text.splitlines()
    return len(lines) <= ROWS and all(len(line) <= COLUMNS for line in lines)


def test_a_configuration_shows_what_differs_from_the_reference_finger() -> None:
    finger = config.load({"finger.wall_mm": 1.8, "extensions.wall_offset.offset_mm": 0.1})
    first, _, *rows = repr(finger).splitlines()
    assert first == "Configuration: the reference finger but for"
    assert rows[0].split() == ["finger.wall_mm", "1.8", "1.6"]
    assert rows[1].startswith("extensions.wall_offset")
    assert repr(Config()) == str(Config()) == "Configuration: the reference finger"
    for kind in ("pneunet", "cast", "round_bellows"):
        assert _fits(repr(config.load({"finger.kind": kind})))
    assert repr(finger.material).startswith("NeoHookeMaterials(law='neo-hooke', mu_MPa=")
    assert "None" not in repr(finger.extensions)


def test_a_notebook_shows_each_key_of_a_configuration_with_its_meaning() -> None:
    finger = config.load({"finger.wall_mm": 1.8})
    shown = finger._repr_html_()
    assert ["finger.wall_mm", "1.8", "1.6"] in _Cells(shown).rows
    assert f"<pre>{escape(config.dumps(finger))}</pre>" in shown


def test_a_notebook_shows_the_readings_of_a_result() -> None:
    cells = _Cells(Result("bending", Config(), READINGS)._repr_html_()).rows
    assert cells[0][0].startswith("Pressure")
    assert [float(row[0]) for row in cells[1:]] == [0.0, 50.0, 100.0]
    assert [float(row[1]) for row in cells[1:]] == [0.0, 20.0, 40.0]


def test_a_notebook_shows_a_design() -> None:
    assert _fits(repr(DESIGN))
    assert "maximise force_N" in repr(DESIGN)
    rows = _Cells(DESIGN._repr_html_()).rows
    assert ["finger.wall_mm", "1.6", "1.8", "1 to 2"] in rows
    assert ["mass_g", "29.5", "at most 30", "kept"] in rows
    assert ["ending", "no step <promises> more", "why it ended"] in rows  # no tag of HTML


def test_a_long_table_keeps_its_beginning_and_end_in_a_console() -> None:
    table = TextTable(["place", "word"], [[str(i), "a word " * 5] for i in range(200)], "Title")
    lines = table.text(columns=30, rows=6).splitlines()
    assert lines[0] == "Title"
    assert max(map(len, lines)) <= 30
    shown = [int(line.split()[0]) for line in lines if line[:1].isdigit()]
    assert shown == [0, 1, 2, 197, 198, 199]
    assert "… 194 rows …" in lines


def test_columns_have_the_order_of_the_file() -> None:
    """Also where the first row lacks one; a column without a value is none, as in its file."""
    rows = [
        {"time_s": 0.0, "force_N": 1.0, "wall_gap_mm": np.nan},
        {"angle_deg": 2.0, "time_s": 1.0, "force_N": 3.0},
    ]
    result = Result("bending", Config(), rows, order=("angle_deg", "pressure_kPa", "time_s"))
    assert list(result) == list(result.to_pandas()) == ["angle_deg", "time_s", "force_N"]
    np.testing.assert_array_equal(result["angle_deg"], [np.nan, 2.0])
    np.testing.assert_array_equal(result["wall_gap_mm"], [np.nan, np.nan])
