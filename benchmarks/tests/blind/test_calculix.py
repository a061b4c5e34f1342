"""Fingers that CalculiX simulated: committed readings and answers, how they are read and scored."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.blind.calculix import answers, truth
from dolfingrip import config, experiments
from dolfingrip.channels import ANGLE, FORCE, PRESSURE
from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.sections.tables import assignments


def test_ours_bends_and_presses_as_theirs() -> None:
    """The reference is CalculiX, whose tetrahedra are 5 % stiffer than our hexahedra."""
    finger = config.load(None, assignments(["experiment.max_pressure_kPa=50", "plate.gap_mm=1"]))
    theirs = truth.stored()["nothing"]
    place = truth.PRESSURES_kPa.index(50.0)
    for name, column in truth.COLUMNS.items():
        ours = experiments.run(name, finger).column(column)[-1]
        assert ours == pytest.approx(theirs[column][place], rel=0.07)


def test_every_case_has_readings_and_an_answer() -> None:
    assert list(truth.stored()) == list(truth.CASES)
    assert [each.case for each in answers.answers()] == list(truth.CASES)
    plain = truth.stored()["nothing"]
    for name, own in truth.stored().items():
        if name != "nothing":  # what is hidden changes them
            changes = [np.abs(np.array(own[each]) / plain[each] - 1).max() for each in plain]
            assert max(changes) > 0.01


def test_readings_are_of_holds_and_noisy(tmp_path: Path) -> None:
    file = answers.measured("nothing", tmp_path)
    assert set(pd.read_csv(file)["branch"]) == {"hold"}
    rows = read([file], Config()).readings
    assert len(rows) == 2 * (1 + len(truth.PRESSURES_kPa))
    away = rows[PRESSURE.name].to_numpy() - np.tile([0.0, *truth.PRESSURES_kPa], 2)
    assert 0.1 < away.std() < 0.6
    free = rows[ANGLE.name].dropna().to_numpy() - [0.0, *truth.stored()["nothing"][ANGLE.name]]
    assert 0.05 < free[1:].std() < 0.4
    assert rows[FORCE.name].notna().sum() == 1 + len(truth.PRESSURES_kPa)


def test_answers_are_scored() -> None:
    """By hand."""
    right = answers.Answered(
        "a", "yeoh|gent + plate_gap", "cause", "0.95", "gent mullins", "plate_gap", "", "2 of 2",
        "", "c0ffee1",
    )  # fmt: skip
    wrong = replace(right, first="prony")
    missed = replace(right, answer="none", first="", second="", held="0 of 2")
    hinted = replace(missed, answer="unknown", may_act="yeoh prony")
    vague = replace(missed, probability="0.40", may_act="prony")
    false = [right, wrong, missed, hinted, vague]
    assert [each.false_and_sure for each in false] == [False, True, True, False, False]
    assert [each.told for each in false] == [True, True, False, True, False]
    nothing = replace(missed, hidden="")
    assert not nothing.false_and_sure
    assert nothing.told
    alarm = replace(wrong, hidden="")
    assert alarm.false_and_sure
    assert not alarm.told
    assert {*answers.strengths()} == {*truth.CASES} - {"nothing", "modulus", "walls"}
    figures = answers.score([right, missed])
    assert "false and sure | 0 | 1 of 2" in figures
    assert "0.50 of 4" in figures


def test_what_is_hidden_is_in_the_deck(tmp_path: Path) -> None:
    patched = truth.decks(truth.CASES["stiff_patch"], tmp_path)
    for file in patched.values():
        text = file.read_text(encoding="utf-8")
        assert "*SOLID SECTION, ELSET=stiff, MATERIAL=stiff" in text
        assert "ELSET=solid, MATERIAL=solid" not in text
    hung = truth.decks(truth.CASES["weight"], tmp_path)
    for file in hung.values():
        assert file.read_text(encoding="utf-8").count("GRAV, 9810") == 1
    assert truth.body(truth.CASES["regulator"]).protocol.pressure_kPa[-1] == pytest.approx(106.0)
