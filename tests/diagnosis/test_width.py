"""A coupon's width: what it tells that the force does not, and that it is asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.delivered import delivered
from support.here import Here, simulated
from support.invented_coupon import WIDTH_NOISE, made, white

from dolfingrip.config import Config
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement, read, selected
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.screening import analyse
from dolfingrip.diagnosis.simulation.unknowns import unknowns

WIDTH = "transverse_strain"
ONCE = ("experiment.unload=false",)
EXACT = f"""experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.02
displacement_mm = 0.0
{WIDTH} = {WIDTH_NOISE}
[nuisance]
material_law = 0.0
coupon_slack_mm = 0.0
"""
HIDDEN = "extensions.bulk_modulus.more_MPa=100.0"


def coupon(folder: Path, *overrides: str, told: str = EXACT, **others: object) -> Measurement:
    """One that is pulled once, as far as it is compared."""
    noise = lambda rng, count: white(rng, count, 0.02)  # noqa: E731
    file = made(folder, *ONCE, *overrides, noise=noise, told=told, **others)
    return selected(read([file]), Config())[0]


def diagnosed(measurement: Measurement, store: Path, *effects: str) -> Diagnosis:
    return diagnose_measurement(
        measurement, Config(), Here(store), DiagnosisSettings(effects=effects)
    )


@pytest.fixture(scope="module")
def tied(store: Path, tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    """Its force alone, of a material that is less compressible."""
    measurement = coupon(tmp_path_factory.mktemp("force"), HIDDEN)
    return diagnosed(measurement, store, "bulk_modulus", "ogden_terms")


@pytest.mark.slow
def test_the_width_tells_how_far_the_volume_changes(
    tied: Diagnosis, store: Path, tmp_path: Path
) -> None:
    """A bulk modulus that is 4.5 times as large changes the force as another law does, and the
    width at 50 % by 0.013, 6.5 standard deviations of a camera."""
    without = delivered(tied, tmp_path / "force").verdict
    print(without)
    assert set(without.effects) == {"bulk_modulus", "ogden_terms"}
    measurement = coupon(tmp_path, HIDDEN, width=True)
    found = diagnosed(measurement, store, "bulk_modulus", "ogden_terms")
    both = delivered(found, tmp_path / "width")
    print(both.verdict)
    assert both.verdict.effects == ("bulk_modulus",)
    assert both.verdict.probability > 0.95
    more = both.numbers[HIDDEN.partition("=")[0]]
    assert more.low < 100 < more.high


@pytest.mark.slow
def test_a_camera_is_asked_for_where_the_force_ties(tied: Diagnosis) -> None:
    for each in tied.next:
        print(each.name, each.gain, each.chance)
    assert tied.next[0].chance > 0.75
    assert tied.next[0].excludes == ("ogden_terms",)
    assert tied.next[0].name == "a coupon in uniaxial tension; a camera measures its width, too"


def by_name(measurement: Measurement) -> dict[str, Proposal]:
    return {each.name: each for each in proposals(measurement, Config())}


def columns(proposal: Proposal) -> set[str]:
    return set(proposal.measurement.listed["column"])


@pytest.mark.slow
def test_additions_with_a_camera(tied: Diagnosis, tmp_path: Path) -> None:
    """Where there is none yet it takes its minutes; where there is one it goes on seeing."""
    found = by_name(tied.analysis.simulation.measurement)
    seen = {name: each for name, each in found.items() if each.kind == "coupon_width"}
    assert len(seen) == 3
    for name, each in seen.items():
        assert columns(each) == {"force_N", WIDTH}
        plain = name.removesuffix("; a camera measures its width, too")
        if plain in found:
            assert columns(found[plain]) == {"force_N"}
            with_camera = found[plain].minutes + Policy().set_up_min["camera"]
            assert each.minutes == pytest.approx(with_camera)
    again = by_name(coupon(tmp_path, width=True))
    assert {each.kind for each in again.values()} == {"coupon"}
    assert all(columns(each) == {"force_N", WIDTH} for each in again.values())
    of_a_finger = by_name(rig.read(None, Config())[0])
    (one,) = (each for each in of_a_finger.values() if each.kind == "coupon_width")
    assert one.minutes > Policy().set_up_min["coupon"] + Policy().set_up_min["camera"]


def test_a_width_knows_neither_modulus_nor_cross_section(store: Path, tmp_path: Path) -> None:
    told = EXACT.replace("material_law = 0.0", "coupon_area = 0.1")
    told = told.replace("coupon_slack_mm = 0.0", "coupon_slack_mm = 0.1")
    measurement = coupon(tmp_path, told=told, width=True)
    simulation = simulated(measurement, Config(), Here(store))
    base = simulation.base
    across = (measurement.listed["column"] == WIDTH).to_numpy()
    changes = {each.name: each.change for each in simulation.rig}
    assert set(changes) == {"modulus", "coupon_area"}
    for change in changes.values():
        np.testing.assert_allclose(change[across], 0.0, atol=1e-6)
        assert (np.abs(change[~across]) > 0.05).all()
    case = analyse(
        CouponSimulation(measurement, Config()),
        unknowns(measurement, Config(), ["force_gain", "mooney_rivlin"]),
    ).problem
    change = {
        name: case.predicted((name,), np.r_[np.zeros(case.nuisance_count), 1.0])
        - case.predicted((), np.zeros(case.nuisance_count))
        for name in ("force_gain", "mooney_rivlin")
    }
    np.testing.assert_allclose(change["force_gain"][across], 0.0, atol=1e-6)
    assert np.abs(change["mooney_rivlin"]).max() > 0.01
    # it begins to narrow where the force begins: the travel's error is both readings'
    slope = np.gradient(base.readings[across], measurement.listed["control"][across])
    np.testing.assert_allclose(base.by_control[across][1:-1], slope[1:-1], rtol=0.01)
