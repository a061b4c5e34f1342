"""The blind benchmark: the experiment that is proposed, made by the generator."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blind.made_up import case, made_up

from benchmarks.blind import cases, followup, full, generator, noise
from benchmarks.blind.cases import Case
from benchmarks.blind.protocols import PROTOCOLS
from benchmarks.blind.response import Hidden, Truth
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.selection import selected
from dolfingrip.diagnosis.simulation.job import JobResult


def proposed(kind: str, tmp_path: Path) -> tuple[Case, list[Proposal]]:
    """A case on P2, and what could be added to it of a kind."""
    catalogue = made_up("P2")
    hidden = case(catalogue, Hidden("prony", 0, 1.0))
    readings = cases.read(hidden, catalogue.vector(hidden.truth))
    config = generator.analysed(catalogue.protocol)
    measurement = read([cases.write(hidden, readings, tmp_path)], config)
    return hidden, [each for each in proposals(measurement, config) if each.kind == kind]


def test_a_plate_farther_away_is_set_anew(tmp_path: Path) -> None:
    hidden, (gap,) = proposed("gap", tmp_path)
    (added,) = followup.additions(hidden, gap)
    assert added.protocol.columns == {"blocked_force": ("force_N",)}
    (run,) = full.runs(added.protocol, added.truth, added.lab)
    off_mm = 0.3 * added.truth.sigma("plate_gap")
    assert run.job.config.plate.gap_mm == pytest.approx(3.0 + off_mm)
    assert added.truth.sigma("plate_gap") != hidden.truth.sigma("plate_gap")
    assert added.truth.sigma("wall") == hidden.truth.sigma("wall")
    assert run.job.config.extensions.model_dump()["prony"] is not None
    assert added.protocol.setup()["plate"] == {"gap_mm": 3.0}


def test_a_new_coupon_is_a_specimen_of_its_own(tmp_path: Path) -> None:
    hidden, coupons = proposed("coupon", tmp_path)
    added = [test for each in coupons for test in followup.additions(hidden, each)]
    assert {test.specimen for test in added} == {"B"}
    for test in added:
        assert test.truth.modulus / hidden.truth.modulus == pytest.approx(1.0, abs=0.06)
        assert test.truth.modulus != hidden.truth.modulus
        assert test.truth.causes == hidden.truth.causes


def test_the_finger_up_and_down_are_two_files(tmp_path: Path) -> None:
    hidden, (poses,) = proposed("orientation", tmp_path)
    up, down = followup.additions(hidden, poses)
    runs = [full.runs(each.protocol, each.truth, each.lab)[0] for each in (up, down)]
    assert [run.job.config.gravity.direction[2] for run in runs] == [1.0, -1.0]


def test_what_is_read_once_more_has_its_own_readings_alone(tmp_path: Path) -> None:
    hidden, (tip,) = proposed("tip", tmp_path)
    (added,) = followup.additions(hidden, tip)
    assert added.protocol.columns == {"bending": ("tip_x_mm", "tip_z_mm")}
    rows = added.protocol.courses[0].rows
    before = PROTOCOLS["P2"].course("bending").rows
    np.testing.assert_allclose(rows["pressure_kPa"], before["pressure_kPa"])


def told(
    answer: str, *classes: tuple[str, ...], next_: bool = True, gain: float = 5.0
) -> dict[str, Any]:
    named = [list(names) for names in classes]
    return {
        "verdict": {
            "answer": answer, "probability": 0.9, "class": named[0] if named else [],
            "second": named[1] if len(named) > 1 else [],
        },
        "classes": [{"effects": names} for names in named],
        "next_experiments": [{"name": "a hold", "gain": gain}] if next_ else [],
    }  # fmt: skip


def test_a_tie_is_split_where_the_hidden_cause_alone_is_left() -> None:
    hidden = case(made_up("P2"), Hidden("prony", 0, 1.0))
    before = told("cause", ("prony", "set", "gent"))
    assert followup.to_be_split(hidden, before)
    assert not followup.to_be_split(hidden, told("cause", ("prony",)))
    assert not followup.to_be_split(hidden, told("cause", ("gent", "set")))
    assert not followup.to_be_split(hidden, told("cause", ("prony", "set"), next_=False))
    assert not followup.to_be_split(hidden, told("cause", ("prony", "set"), gain=0.05))
    assert not followup.to_be_split(replace(hidden, kind="none", truth=Truth()), before)
    for after, splits, narrows in (
        (told("cause", ("prony",)), True, True),
        (told("cause", ("set",)), False, False),
        (told("cause", ("prony", "set")), False, True),
        (before, False, False),
        (told("cause", ("prony",), ("set",)), False, False),
        (told("unknown"), False, False),
    ):
        assert followup.splits(hidden, after) == splits
        assert followup.narrows(hidden, before, after) == narrows


def test_planned_rows_are_those_of_the_proposal(tmp_path: Path) -> None:
    hidden, (hold,) = proposed("hold", tmp_path)
    (added,) = followup.additions(hidden, hold)
    own: Measurement = hold.measurement
    assert len(added.protocol.courses[0].rows) == len(own.readings)
    assert (added.protocol.courses[0].rows["branch"] == "hold").any()


def test_a_coupon_that_is_pulled_farther_is_compared_so_far(tmp_path: Path) -> None:
    """It is read up to three times the strain, and its file says so."""
    protocol = PROTOCOLS["pull-up"]
    hidden = replace(case(made_up("P2"), Hidden("prony", 0, 1.0)), protocol="pull-up")
    travel_mm = protocol.courses[0].rows["displacement_mm"].to_numpy()
    config = generator.analysed(protocol)
    file = cases.write(hidden, cases.read(hidden, 0.5 * travel_mm), tmp_path)
    found = proposals(read([file], config), config)
    far = next(each for each in found if each.name == "a coupon to a strain of 1.5")
    (added,) = followup.additions(hidden, far)
    assert added.lab == {"coupon": {"max_strain": 1.5}}
    (run,) = full.runs(added.protocol, added.truth, added.lab)
    assert max(run.job.config.protocol.displacement_mm) == pytest.approx(1.5 * 33.0)
    rows = cases.rows(added.protocol, np.ones(len(added.protocol.courses[0].rows)), "B")
    cases.write_files(tmp_path / "added.csv", rows, {**added.protocol.setup(), **added.lab})
    again, notes = selected(read([tmp_path / "added.csv"], config), config)
    assert again.readings["displacement_mm"].max() == pytest.approx(1.5 * 33.0)
    assert again.readings["force_N"].iloc[-1] == 1.0
    assert not any("above" in note for note in notes)


def test_a_camera_sees_the_width_of_the_added_coupon(tmp_path: Path) -> None:
    """With noise of 0.002 of which a quarter of the variance drifts; read again as written."""
    protocol = PROTOCOLS["pull-up"]
    hidden = replace(case(made_up("P2"), Hidden("bulk_modulus", 0, 1.0)), protocol="pull-up")
    travel_mm = protocol.courses[0].rows["displacement_mm"].to_numpy()
    config = generator.analysed(protocol)
    file = cases.write(hidden, cases.read(hidden, 0.5 * travel_mm), tmp_path)
    found = proposals(read([file], config), config)
    (seen,) = (each for each in found if each.name.startswith("a coupon in uniaxial tension; a ca"))
    (added,) = followup.additions(hidden, seen)
    assert added.protocol.columns == {"coupon": ("force_N", "transverse_strain")}
    (run,) = full.runs(added.protocol, added.truth, added.lab)
    count = len(run.job.config.protocol.displacement_mm)
    narrowed = -0.01 * np.arange(count)
    result = JobResult({"force_N": np.arange(count) / 2, "transverse_strain": narrowed})
    true = full.readings(added.protocol, added.truth, [run], {run.job.key: result})
    assert true is not None
    told = {**added.protocol.setup()}
    told["noise"] = hidden.instruments.told(noise.channels(added.protocol))
    drift = told["noise"]["correlated"]["transverse_strain"]
    assert drift == pytest.approx(0.001)
    assert np.hypot(told["noise"]["transverse_strain"], drift) == pytest.approx(0.002, rel=1e-3)
    rows = cases.rows(added.protocol, true, "B")
    cases.write_files(tmp_path / "added.csv", rows, told)
    again = read([tmp_path / "added.csv"], config).readings
    np.testing.assert_allclose(again["transverse_strain"], narrowed[run.place])
    np.testing.assert_allclose(again["force_N"], run.place / 2)
