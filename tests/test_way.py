"""The way from the command to the first load step, as docs/layout.md lists it."""

from __future__ import annotations

import itertools
import traceback
from pathlib import Path
from typing import Any

import pytest
from support.checkout import needs_checkout
from support.small import SHORT
from typer.testing import CliRunner

import dolfingrip
from dolfingrip.cli.commands import app
from dolfingrip.config import Config
from dolfingrip.experiments.bending import Bending
from dolfingrip.mechanics.path.path import LoadPath

PACKAGE = Path(dolfingrip.__file__).parent
LAYOUT = PACKAGE.parent / "docs" / "layout.md"
DOWN = (
    "cli/experiment_commands.py",
    "experiments/loop.py",
    "mechanics/path/path.py",
)


class Arrived(Exception):
    """The first load step."""


def test_it_goes_down_and_settings_are_applied_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    stack: list[str] = []
    applied: list[Config] = []

    def advance(path: LoadPath, *_: Any) -> None:
        stack.extend(frame.filename for frame in traceback.extract_stack())
        raise Arrived

    def settings(experiment: Bending, config: Config) -> Config:
        applied.append(config)
        return config

    monkeypatch.setattr(LoadPath, "advance", advance)
    monkeypatch.setattr(Bending, "settings", settings)
    sets = [f"--set={each}" for each in SHORT]
    done = CliRunner().invoke(app, ["bend", "--out", str(tmp_path / "run"), *sets])
    assert isinstance(done.exception, Arrived), done.output
    own = [Path(each).relative_to(PACKAGE) for each in stack if Path(each).is_relative_to(PACKAGE)]
    files = [str(name) for name, _ in itertools.groupby(own)]
    assert files[files.index(DOWN[0]) :] == list(DOWN[:-1])  # advance itself is this file's
    assert len(applied) == 1


@needs_checkout
def test_it_is_listed() -> None:
    text = LAYOUT.read_text(encoding="utf-8")
    assert [text.index(name) for name in DOWN] == sorted(text.index(name) for name in DOWN)
