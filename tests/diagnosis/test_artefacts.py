"""Artefacts of instruments: what and by how much is told, and causes are named beside it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import blind_coupons
from support.delivered import delivered
from support.hidden_coupon import Truth
from support.softening_coupons import TRAVEL_mm, diagnosed, force_N, measured

from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.diagnosis import diagnosed as of
from dolfingrip.diagnosis.screening import analyse, simulator_of
from dolfingrip.diagnosis.simulation.unknowns import unknowns

BEFORE, AFTER = 9, 10
"""Rows of each test between which something slips."""


@pytest.mark.parametrize("who", ["S2", "all specimens"])
def test_a_jump_is_told_and_a_cause_is_named_beside_it(tmp_path: Path, who: str) -> None:
    """A clamp slips by 0.5 N: of one specimen, or of all at the same travel."""

    def slipped(name: str, travel_mm: np.ndarray) -> np.ndarray:
        return -0.5 * (name in who or "all" in who) * (travel_mm > TRAVEL_mm[BEFORE] + 1e-6)

    found = diagnosed(measured(tmp_path, {}, jumped=slipped))
    (jump,) = found.artefacts
    result = delivered(found, tmp_path / "out").result
    (told,) = result.artefacts
    print(told, found.decision.probability)
    where = f"between {TRAVEL_mm[BEFORE]:.4g} and {TRAVEL_mm[AFTER]:.4g} mm"
    assert told.name.startswith("jump of ")
    assert where in told.name
    assert who in told.name
    assert not result.slips
    listed = found.analysis.measurement.listed
    value = found.analysis.nuisances(found.decision.best)[jump.nuisance.name]
    change = value * jump.nuisance.change[(listed["control"] > TRAVEL_mm[BEFORE] + 1e-6).to_numpy()]
    # 0.5 N of some 18 N; a slip of the travel changes a softer coupon's force by less
    assert change[change != 0] == pytest.approx(-0.5, abs=0.15)
    assert found.decision.first[0] == "mooney_rivlin"


def test_none_stands_for_a_cause_that_was_left_out(tmp_path: Path) -> None:
    """Where a finger keeps a set, a quick diagnosis has no cause for it, and jumps would do."""

    def slipped(name: str, travel_mm: np.ndarray) -> np.ndarray:
        return -0.5 * (travel_mm > TRAVEL_mm[BEFORE] + 1e-6)

    read, config = measured(tmp_path, {}, jumped=slipped), Config()
    causes = [cause for cause in unknowns(read, config) if cause.name in ("mooney_rivlin", "yeoh")]
    analysis = analyse(simulator_of(read, config, None), causes)
    assert of(analysis, config).artefacts
    assert not of(replace(analysis, not_tried=("permanent_set",)), config).artefacts


def test_none_where_readings_scatter(tmp_path: Path) -> None:
    assert not diagnosed(measured(tmp_path, {"S2": 0.1})).artefacts


def test_the_wave_of_an_uneven_screw_is_told(tmp_path: Path) -> None:
    """An error of 0.25 mm with a period of 5 mm, by the slope of the coupons' force."""

    def uneven(name: str, travel_mm: np.ndarray) -> np.ndarray:
        return np.gradient(force_N(), TRAVEL_mm) * 0.25 * np.sin(2 * np.pi * travel_mm / 5.0)

    found = diagnosed(measured(tmp_path, {}, jumped=uneven))
    waves = [each.nuisance.name for each in found.artefacts]
    sizes = found.analysis.nuisances(found.decision.best)
    own = [sizes[each.nuisance.name] * each.nuisance.std for each in found.artefacts]
    print(waves)
    assert sum(own) == pytest.approx(0.25, abs=0.08)
    assert all("of displacement_mm of all specimens (coupon)" in each for each in waves)
    periods = [float(each.split("period ")[1].split()[0]) for each in waves]
    assert periods[0] == pytest.approx(5.0, rel=0.1)
    assert found.decision.first[0] == "mooney_rivlin"


@pytest.mark.slow
def test_the_play_of_a_load_cell_is_told(tmp_path: Path) -> None:
    """A cell follows only what exceeds 0.25 N on either way (benchmarks/blind/coupons)."""
    law = {"extensions.mooney_rivlin.C01_MPa": 1.0}
    truth = Truth(causes=law, outsider=("cell_sticks", 1.0))
    found = blind_coupons.diagnosed("loops", truth, tmp_path)
    (play,) = found.artefacts
    size = found.analysis.nuisances(found.decision.best)[play.nuisance.name] * play.nuisance.std
    assert "play of force_N of all specimens (coupon)" in play.nuisance.name
    assert size == pytest.approx(-0.25, abs=0.03)
    assert "mooney_rivlin" in found.decision.first
