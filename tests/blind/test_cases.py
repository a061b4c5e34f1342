"""The blind benchmark: what is hidden, how it is read, and the files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from blind.made_up import case, made_up

from benchmarks.blind import cases, generator, noise
from benchmarks.blind.protocols import FINGERS, PROTOCOLS
from benchmarks.blind.response import Hidden
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.data.noise import noise as instrument_noise
from dolfingrip.diagnosis.inference.noise import noise_matrix


def test_the_plan_is_that_of_the_seed() -> None:
    sets = {name: cases.plan(name) for name in cases.SETS}
    again = cases.plan("development")
    pd.testing.assert_frame_equal(cases.table_of(sets["development"]), cases.table_of(again))
    every = [each for own in sets.values() for each in own]
    assert len(every) >= 200
    assert sum(each.full for each in every) >= 40
    assert all(each.full for each in every if "plate_tilt" in each.hidden)
    assert any("plate_tilt" in each.hidden for each in every)
    assert len({each.seed for each in every}) == len(every)
    for own in sets.values():
        counts = pd.Series([each.kind for each in own]).value_counts(normalize=True)
        assert counts.to_dict() == pytest.approx(dict(cases.SHARES))
        used = {each.protocol for each in own}
        assert used == set(FINGERS)
    kinds = {each.hidden[0] for each in every if each.kind == "outsider"}
    assert len(kinds) >= 4
    assert not kinds & set(generator.causes())


def test_a_longer_plan_begins_with_other_kinds_only() -> None:
    """What a case hides depends on its own number and kind, not on how many there are."""
    short, long = cases.plan("final", 20), cases.plan("final", 40)
    same = [(a, b) for a, b in zip(short, long, strict=False) if a.kind == b.kind]
    assert same
    for a, b in same:
        assert a == b


def test_strengths_are_within_what_is_simulated() -> None:
    rng = np.random.default_rng(1)
    for cause in generator.causes().values():
        for _ in range(20):
            form, strength = cause.draw(rng)
            low, high = cause.range()
            assert low <= strength <= high
            if cause.simulated:
                assert strength <= 1.2 * max(cause.forms[form].parts)
            # within the bounds of the effect's parameters
            cause.effect(**cause.values(form, strength))


def test_noise_is_that_of_the_seed_and_has_the_covariance() -> None:
    protocol = PROTOCOLS["P2"]
    index = noise.index(protocol)
    matrix = noise_matrix(index, noise.by_channel(protocol, noise.Instruments()))
    seed = 11
    print("seed", seed)
    rng = np.random.default_rng(seed)
    draws = np.array([noise.draw(index, matrix, rng) for _ in range(4000)])
    # standard error of a covariance of 4000 draws: 1.4/√4000 of the variance; five of them
    std = np.sqrt(np.diag(matrix))
    got = np.cov(draws.T) / np.outer(std, std)
    np.testing.assert_allclose(got, matrix / np.outer(std, std), atol=0.11)
    angles = (index["channel"] == "angle_deg").to_numpy()
    np.testing.assert_allclose(std[angles], 0.3)
    one, two = (noise.draw(index, matrix, np.random.default_rng(seed)) for _ in range(2))
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("protocol", ["P1", "P2", "P4"])
def test_files_are_valid_measured_data(protocol: str, tmp_path: Path) -> None:
    catalogue = made_up(protocol)
    hidden = case(catalogue, Hidden("prony", 1, 0.8))
    readings = cases.read(hidden, catalogue.vector(hidden.truth))
    measurement = read(
        [cases.write(hidden, readings, tmp_path)], generator.analysed(catalogue.protocol)
    )
    assert not measurement.warnings
    assert len(measurement.readings) == sum(len(c.rows) for c in catalogue.protocol.courses)
    value = measurement.listed()["value"].to_numpy()
    np.testing.assert_allclose(value, readings.value[readings.kept], rtol=1e-5)
    assert 0 < (~readings.kept).sum() < 0.3 * len(readings.kept)
    told = instrument_noise(measurement)
    angles = (measurement.listed()["column"] == "angle_deg").to_numpy()
    total = np.hypot(told.independent, told.correlated)[angles]
    np.testing.assert_allclose(total, 0.3, rtol=1e-4)
    assert measurement.tests[1].setup.sections["plate"] == {"gap_mm": 1.0}


def test_what_a_laboratory_knows_better_is_told_and_drawn() -> None:
    protocol = PROTOCOLS["short"]
    assert protocol.setup()["nuisance"] == {"pressure_offset_kPa": 0.2, "plate_gap_mm": 0.03}
    usual, known = (
        [cases.drawn_nuisances(np.random.default_rng(i), PROTOCOLS[name]) for i in range(5)]
        for name in ("P1", "short")
    )
    for name, part in (("pressure_offset", 0.1), ("plate_gap", 0.1), ("modulus", 1.0)):
        assert [k[name] for k in known] == pytest.approx([part * u[name] for u in usual])
