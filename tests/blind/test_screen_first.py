"""Diagnoses that begin with the screen alone, and end there where it finds no cause."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.blind import cases, diagnoses
from benchmarks.blind.diagnoses import RESULT, How

(CASE,) = cases.plan("development", 1)


def kept(folder: Path, mode: str, answer: str) -> None:
    (folder / mode).mkdir(parents=True)
    content = {"verdict": {"answer": answer}, "quick": mode == "quick"}
    (folder / mode / RESULT).write_text(json.dumps(content), encoding="utf-8")


def how(folder: Path) -> How:
    return How(folder / "analyser", screen_first=True)


def test_it_ends_where_the_screen_finds_no_cause(tmp_path: Path) -> None:
    assert not diagnoses.is_known(tmp_path, how(tmp_path))
    kept(tmp_path, "quick", "none")
    assert diagnoses.is_known(tmp_path, how(tmp_path))
    assert diagnoses.diagnose(CASE, tmp_path, how(tmp_path))["quick"]


@pytest.mark.parametrize("answer", ["cause", "unknown"])
def test_else_the_whole_diagnosis_counts(answer: str, tmp_path: Path) -> None:
    kept(tmp_path, "quick", answer)
    assert not diagnoses.is_known(tmp_path, how(tmp_path))
    kept(tmp_path, "whole", "none")
    assert diagnoses.is_known(tmp_path, how(tmp_path))
    found: dict[str, Any] = diagnoses.diagnose(CASE, tmp_path, how(tmp_path))
    assert found == {"verdict": {"answer": "none"}, "quick": False}


def test_a_diagnosis_of_the_one_kind_is_none_of_the_other(tmp_path: Path) -> None:
    kept(tmp_path, "whole", "cause")
    assert not diagnoses.is_known(tmp_path, how(tmp_path).screen)
    assert not diagnoses.is_known(tmp_path, how(tmp_path))
    assert diagnoses.is_known(tmp_path, How(tmp_path))
