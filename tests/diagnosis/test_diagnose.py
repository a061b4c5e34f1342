"""From files to a verdict, on coupons, whose simulation is cheap: every kind of answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.delivered import Delivered, delivered
from support.example import EXAMPLES
from support.here import Here
from support.invented_coupon import made

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.answer.settling import settled_by
from dolfingrip.diagnosis.core.blend import Tangents
from dolfingrip.diagnosis.core.unknown import Nuisance
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data.measurement import Measurement, read, selected
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.results import write
from dolfingrip.diagnosis.simulation.point import Point
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files.diagnosis_words import NUMBERS, lines
from dolfingrip.report import diagnosis as pictures

COUPONS = EXAMPLES / "coupons/ninjaflex_uniaxial.csv"
TRIED = ("mooney_rivlin", "prony", "yeoh", "gent", "force_gain", "force_offset")


def diagnosed(file: Path, store: Path, *, quick: bool = False) -> Diagnosis:
    measurement, _ = selected(read([file]), Config())
    settings = DiagnosisSettings(quick=quick, effects=TRIED)
    return diagnose_measurement(measurement, Config(), Here(store), settings)


@pytest.fixture(scope="module")
def ninjaflex(store: Path) -> Diagnosis:
    return diagnosed(COUPONS, store)


@pytest.fixture(scope="module")
def printed(ninjaflex: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> Delivered:
    return delivered(ninjaflex, tmp_path_factory.mktemp("printed"), [COUPONS])


@pytest.mark.slow
def test_printed_coupons_soften(ninjaflex: Diagnosis, printed: Delivered) -> None:
    """Against closed forms of uniaxial tension, fitted to 50 % strain outside this package:
    2 C01/mu = 0.93; g = 0.55 and tau = 5 s would do; refitted neo-Hooke leaves 4.7 times the
    error on specimens left out, where their scales are known.

    Each elastic law that is named follows the readings to a hundredth of the largest one."""
    verdict = printed.verdict
    assert verdict.answer == "cause"
    assert "mooney_rivlin" in verdict.effects
    assert {*verdict.effects} <= ninjaflex.analysis.problem.elastic
    softening = {"mooney_rivlin", "prony"}
    subsets = ninjaflex.decision.subsets
    assert sum(p for subset, p in subsets.items() if softening & set(subset)) > 0.98
    elastic = printed.numbers_of("mooney_rivlin")
    ratio = 2 * elastic["extensions.mooney_rivlin.C01_MPa"].value / elastic["material.mu_MPa"].value
    assert ratio == pytest.approx(0.93, abs=0.1)
    (row,) = (row for row in printed.result.gain if row.left_out == "specimens")
    assert row.folds == 8
    assert row.nuisances > 3 * row.cause
    assert printed.result.gain_claimed


@pytest.mark.slow
def test_viscosity_of_printed_coupons(printed: Delivered) -> None:
    """The reference of the test before."""
    viscous = printed.numbers_of("prony")
    assert 2 < viscous["extensions.prony.tau_s"].value < 8
    assert viscous["extensions.prony.g"].value == pytest.approx(0.55, abs=0.1)


@pytest.mark.slow
def test_a_silicone_is_a_far_softer_material(store: Path, tmp_path: Path) -> None:
    """Ecoflex 30 held against the printed finger's 2.93 MPa. Least squares of F = μ A (λ − λ⁻²), an
    incompressible neo-Hookean bar, give 0.0207 MPa: no effect of the catalogue."""
    found = diagnosed(COUPONS.with_name("ecoflex30_uniaxial.csv"), store)
    files = delivered(found, tmp_path)
    assert files.verdict.effects == ("modulus", "coupon_area")
    assert files.inclusion["modulus"] > 0.99
    assert all(p < 0.2 for name, p in files.inclusion.items() if name != "modulus")
    assert files.numbers["material.mu_MPa"].value == pytest.approx(0.021, rel=0.05)


@pytest.mark.slow
def test_other_rates_and_waits_would_tell_them_apart(printed: Delivered) -> None:
    """Not all: elastic laws stay together where another specimen's stiffness is what they miss."""
    chances = {each.name: each.chance for each in printed.result.next_experiments}
    assert chances["a coupon at a tenth of the rate"] > 0.65
    assert chances["a coupon with a hold of 60 s at the largest strain"] > 0.65
    assert chances["a coupon in uniaxial tension; a camera measures its width, too"] < 0.5


@pytest.mark.slow
def test_an_addition_where_a_law_has_no_equilibrium_is_not_judged(
    ninjaflex: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As polynomials at three times the strain that they were fitted to."""

    exact = CouponSimulation.additions
    farther = 1.4 * ninjaflex.analysis.measurement.readings["displacement_mm"].max()

    def additions(
        self: CouponSimulation,
        points: Sequence[Point],
        measurements: Sequence[Measurement],
        *,
        known_mesh: bool,
    ) -> list[tuple[list[Tangents | None], Sequence[Nuisance]]]:
        simulated = exact(self, points, measurements, known_mesh=known_mesh)
        return [
            ([None, *runs[1:]] if read["displacement_mm"].max() > farther else runs, rig)
            for read, (runs, rig) in zip([m.readings for m in measurements], simulated, strict=True)
        ]

    monkeypatch.setattr(CouponSimulation, "additions", additions)
    found, failed = settled_by(ninjaflex, print, simulating=True)
    left = [each.name for each in ninjaflex.next if "1.5" in each.name]
    assert left
    assert {each.name for each in found} == {each.name for each in ninjaflex.next} - {*left}
    assert len(failed) == len(left)
    assert all("does not reach" in each for each in failed)


@pytest.mark.slow
def test_an_extension_that_is_not_allowed_is_a_warning(
    ninjaflex: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Analysis, "overrides", lambda self, fit: {"material.mu_MPa": -1})
    found = replace(ninjaflex, warnings=[])
    write(found, [COUPONS], tmp_path)
    result = outcome.DiagnosisFile.read(tmp_path)
    assert result.extended == {}
    assert not result.quick
    assert any(
        each.startswith("extended.toml is not written: material.mu_MPa = -1")
        for each in result.warnings
    )
    assert not (tmp_path / "extended.toml").exists()


@pytest.mark.slow
def test_files(ninjaflex: Diagnosis, tmp_path: Path) -> None:
    written, readings = write(ninjaflex, [COUPONS], tmp_path)
    text = (tmp_path / "diagnosis.json").read_text(encoding="utf-8")
    result = outcome.DiagnosisFile.read(tmp_path)
    assert result.model_dump_json(indent=1, by_alias=True) + "\n" == text
    assert result.verdict.effects == ninjaflex.decision.first
    assert '"class"' in text
    assert (tmp_path / "summary.md").read_text("utf-8").splitlines()[:3] == [*lines(result)]
    assert result.headline.number.part in result.verdict.effects
    assert result.headline.option == f"--config {tmp_path / 'extended.toml'}"
    extended = configuration.load(tmp_path / "extended.toml")
    assert extended.material.mu_MPa > Config().material.mu_MPa
    assert extended.extensions.mooney_rivlin is not None  # type: ignore[attr-defined]
    assert {file.name for file in pictures.draw(written, readings, tmp_path)} == {
        "overlay.png", "probabilities.png", "gain.png"
    }  # fmt: skip


@pytest.mark.slow
def test_a_implausible_modulus_is_reported_with_a_cause_that_does_as_well(
    ninjaflex: Diagnosis, tmp_path: Path
) -> None:
    """Its names are no effects of the catalogue, nor is the cause one that was fitted."""
    own = replace(
        ninjaflex.decision, first=("modulus", "coupon_area", "polynomial"), second=(),
        best=ninjaflex.posterior.best(()), nuisance_only=True,
    )  # fmt: skip
    write(replace(ninjaflex, decision=own, next=[]), [COUPONS], tmp_path)
    result = outcome.DiagnosisFile.read(tmp_path)
    assert result.verdict.effects == own.first
    assert result.headline.number.key == "material.mu_MPa"
    words = {each.name: each.words for each in result.causes}
    assert words["coupon_area"] == NUMBERS["coupon_area"]
    assert words["polynomial"].startswith("a polynomial of the invariants")
    assert result.advice is not None
    assert result.advice.way == "area"


def test_a_loop_tells_the_cause(store: Path, tmp_path: Path) -> None:
    truth = {"extensions.prony.g": 0.25, "extensions.prony.tau_s": 8.0}
    found = diagnosed(made(tmp_path, *(f"{k}=[{v}]" for k, v in truth.items())), store)
    files = delivered(found, tmp_path / "out")
    assert files.verdict.answer == "cause"
    assert files.verdict.effects == ("prony",)
    assert files.verdict.probability > 0.9
    for each in files.numbers.values():
        print(each)
        wide = each.high - each.low
        if each.key in truth:
            assert each.low - wide < truth[each.key] < each.high + wide


def test_another_modulus_is_no_cause(store: Path, tmp_path: Path) -> None:
    found = diagnosed(made(tmp_path, "material.mu_MPa=3.6"), store)
    files = delivered(found, tmp_path / "out")
    assert files.verdict.answer == "none"
    assert files.extended.material.mu_MPa == pytest.approx(3.6, rel=0.01)
    assert files.extended.extensions == Config().extensions


def test_what_no_effect_does_is_unknown(store: Path, tmp_path: Path) -> None:
    found = diagnosed(made(tmp_path, wrong=lambda x: 1 + 0.1 * np.sin(9 * x)), store)
    result = delivered(found, tmp_path / "out").result
    print(result.verdict)
    assert result.verdict.answer == "unknown"
    assert result.unknown > 0.9
    assert lines(result)[0].startswith("No effect of the catalogue explains the readings")
    # a cause that could not be simulated may be the one
    failed = replace(found.analysis, failed={"gent": "its simulation does not reach all readings"})
    lacking = delivered(replace(found, analysis=failed), tmp_path / "lacking").result
    assert lines(lacking)[0].startswith("No cause can be claimed")
    assert "gent could not be tried" in lines(lacking)[1]


@pytest.mark.slow
def test_quick_measures_no_gain(store: Path, tmp_path: Path) -> None:
    found = diagnosed(COUPONS, store, quick=True)
    result = delivered(found, tmp_path).result
    assert (result.gain, result.gain_claimed, result.next_experiments) == ((), None, ())
    assert result.quick


@pytest.mark.slow
def test_a_strong_cause_is_no_unknown_one(store: Path, tmp_path: Path) -> None:
    """Of 200 standard deviations."""
    hidden = ("extensions.prony.g=[0.25]", "extensions.prony.tau_s=[8.0]")
    found = diagnosed(made(tmp_path, *hidden), store, quick=True)
    assert delivered(found, tmp_path / "out").verdict.effects == ("prony",)
    outsider = made(tmp_path, *hidden, wrong=lambda x: 1 + 0.2 * np.sin(9 * x))
    found = diagnosed(outsider, store, quick=True)
    assert delivered(found, tmp_path / "out").verdict.answer == "unknown"


def test_a_wrong_unit_is_suspected_in_the_first_line(store: Path, tmp_path: Path) -> None:
    file = made(tmp_path, wrong=lambda x: np.full_like(x, 101.97))
    found = diagnosed(file, store, quick=True)
    files = delivered(found, tmp_path / "out", [file])
    (slip,) = files.result.slips
    assert (slip.column, slip.meaning) == ("force_N", "a force in grams")
    assert "force in grams" in lines(files.result)[0]
    assert not found.artefacts
    assert not list((tmp_path / "out").glob("extended*"))
