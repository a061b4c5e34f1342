"""From files to a verdict, on coupons, whose simulation is cheap: every kind of answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.here import Here
from support.invented_coupon import made

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.diagnosis import outcome
from dolfingrip.diagnosis.additions.next_experiment import Then, next_experiments
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.coupon.compare import _without
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import Settings, judged
from dolfingrip.diagnosis.results import write
from dolfingrip.diagnosis.selection import selected
from dolfingrip.report import diagnosis as pictures

COUPONS = Path(__file__).parents[2] / "examples/coupons/ninjaflex_uniaxial.csv"
TRIED = ("mooney_rivlin", "prony", "yeoh", "gent", "force_gain", "force_offset")


def diagnosed(file: Path, store: Path, *, quick: bool = False) -> CouponDiagnosis:
    measurement, _ = selected(read([file]), Config())
    settings = Settings(quick=quick, effects=TRIED)
    return judged(measurement, Config(), Here(store), settings)


def numbers(found: CouponDiagnosis, *subset: str) -> dict[str, float]:
    fit = found.posterior.best(subset)
    return {each.key: each.value for each in found.numbers(fit)}


@pytest.fixture(scope="module")
def ninjaflex(store: Path) -> CouponDiagnosis:
    return diagnosed(COUPONS, store)


def test_printed_coupons_soften(ninjaflex: CouponDiagnosis) -> None:
    """Against closed forms of uniaxial tension, fitted to 50 % strain outside this package:
    2 C01/mu = 0.93; g = 0.55 and tau = 5 s would do; refitted neo-Hooke leaves 4.7 times the
    error on specimens left out, where their scales are known."""
    decision = ninjaflex.decision
    assert decision.answer == "cause"
    assert "mooney_rivlin" in decision.first
    assert set(decision.first) <= {"mooney_rivlin", "prony"}
    softening = {"mooney_rivlin", "prony"}
    assert sum(p for subset, p in decision.subsets.items() if softening & set(subset)) > 0.98
    elastic = numbers(ninjaflex, "mooney_rivlin")
    ratio = 2 * elastic["extensions.mooney_rivlin.C01_MPa"] / elastic["material.mu_MPa"]
    assert ratio == pytest.approx(0.93, abs=0.1)
    held = ninjaflex.held_out
    assert held is not None
    (row,) = (row for row in held.errors if row.left_out == "specimens")
    assert row.folds == 8
    assert row.nuisances > 3 * row.cause
    assert held.claimed


@pytest.mark.xfail(reason="the closed form fits g = 0.66 beside the rig's slack", strict=True)
def test_viscosity_of_printed_coupons(ninjaflex: CouponDiagnosis) -> None:
    """The reference of the test before."""
    viscous = numbers(ninjaflex, "prony")
    assert 2 < viscous["extensions.prony.tau_s"] < 8
    assert viscous["extensions.prony.g"] == pytest.approx(0.55, abs=0.1)


def test_a_silicone_is_a_far_softer_material(store: Path) -> None:
    """Ecoflex 30 held against the printed finger's 2.93 MPa. Least squares of F = μ A (λ − λ⁻²), an
    incompressible neo-Hookean bar, give 0.0207 MPa: no effect of the catalogue."""
    found = diagnosed(COUPONS.with_name("ecoflex30_uniaxial.csv"), store)
    assert found.decision.first == ("modulus", "coupon_area")
    assert found.decision.inclusion["modulus"] > 0.99
    (modulus,) = (e for e in found.numbers(found.decision.best) if e.key == "material.mu_MPa")
    assert modulus.value == pytest.approx(0.021, rel=0.05)
    assert np.isfinite(found.left_by_emulator)


def test_causes_without_equilibrium_are_left_out(ninjaflex: CouponDiagnosis) -> None:
    before = ninjaflex.posterior
    after = _without(before, ("mooney_rivlin",))
    effects = before.case.effects
    assert sum(after.probability) == pytest.approx(1.0)
    for p, fit in zip(after.probability, after.fits, strict=True):
        assert (p == 0.0) == (effects(fit.subset) == ("mooney_rivlin",))


def test_other_rates_and_waits_would_tell_them_apart(ninjaflex: CouponDiagnosis) -> None:
    splitting = {each.name for each in ninjaflex.next if each.splits}
    assert "a coupon at a tenth of the rate" in splitting
    assert "a coupon with a hold of 60 s at the largest strain" in splitting


def test_an_addition_where_a_law_has_no_equilibrium_is_not_judged(
    ninjaflex: CouponDiagnosis,
) -> None:
    """As polynomials at three times the strain that they were fitted to."""

    def then(proposal: Proposal, fits: Sequence[Fit]) -> Then:
        (first, *others), *rest = ninjaflex.then(proposal, fits)
        if "1.5" in proposal.name:
            first = replace(first, slopes=np.full_like(first.slopes, np.nan))
        return ([first, *others], *rest)  # type: ignore[return-value]

    found, failed = next_experiments(
        ninjaflex.posterior, ninjaflex.decision, ninjaflex.analysed.measurement, Config(),
        ninjaflex.analysed.errors.noise, then, print,
    )  # fmt: skip
    left = [each.name for each in ninjaflex.next if "1.5" in each.name]
    assert left
    assert {each.name for each in found} == {each.name for each in ninjaflex.next} - {*left}
    assert len(failed) == len(left)
    assert all("no equilibrium" in each for each in failed)


def test_an_extension_that_is_not_allowed_is_a_warning(
    ninjaflex: CouponDiagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(CouponDiagnosis, "overrides", lambda self, fit: ("material.mu_MPa=-1",))
    found = replace(ninjaflex, warnings=[])
    write(found, [COUPONS], tmp_path)
    result = outcome.DiagnosisFile.read(tmp_path / "diagnosis.json")
    assert result.extended == {}
    assert not result.quick
    assert any(
        each.startswith("extended.toml is not written: material.mu_MPa = -1")
        for each in result.warnings
    )
    assert not (tmp_path / "extended.toml").exists()


def test_files(ninjaflex: CouponDiagnosis, tmp_path: Path) -> None:
    found = write(ninjaflex, [COUPONS], tmp_path)
    text = (tmp_path / "diagnosis.json").read_text(encoding="utf-8")
    result = outcome.DiagnosisFile.read(tmp_path / "diagnosis.json")
    assert result.model_dump_json(indent=1, by_alias=True) + "\n" == text
    assert result.verdict.effects == ninjaflex.decision.first
    assert '"class"' in text
    assert "mooney_rivlin" in (tmp_path / "summary.md").read_text(encoding="utf-8").splitlines()[0]
    extended = configuration.load(tmp_path / "extended.toml")
    assert extended.material.mu_MPa > Config().material.mu_MPa
    assert extended.extensions.mooney_rivlin is not None  # type: ignore[attr-defined]
    assert {file.name for file in pictures.draw(found.pictures, tmp_path)} == {
        "overlay.png", "residuals.png", "probabilities.png", "gain.png"
    }  # fmt: skip


def test_a_far_modulus_is_told_with_a_cause_that_does_as_well(
    ninjaflex: CouponDiagnosis, tmp_path: Path
) -> None:
    """Its names are no effects of the catalogue, nor is the cause one that was fitted."""
    own = replace(
        ninjaflex.decision, first=("modulus", "coupon_area", "polynomial"), second=(),
        best=ninjaflex.posterior.best(()), own=True,
    )  # fmt: skip
    write(replace(ninjaflex, decision=own, next=[]), [COUPONS], tmp_path)
    page = (tmp_path / "summary.md").read_text(encoding="utf-8")
    assert "(modulus) or another" in page
    assert "(coupon_area) or a polynomial" in page
    assert "measure the coupons' cross-section" in page
    verdict = outcome.DiagnosisFile.read(tmp_path / "diagnosis.json").verdict
    assert verdict.effects == own.first


def test_a_loop_tells_the_cause(store: Path, tmp_path: Path) -> None:
    truth = {"extensions.prony.g": 0.25, "extensions.prony.tau_s": 8.0}
    found = diagnosed(made(tmp_path, *(f"{k}=[{v}]" for k, v in truth.items())), store)
    assert found.decision.answer == "cause"
    assert found.decision.first == ("prony",)
    assert found.decision.probability > 0.9
    for each in found.numbers(found.decision.best):
        print(each)
        wide = each.high - each.low
        if each.key in truth:
            assert each.low - wide < truth[each.key] < each.high + wide


def test_another_modulus_is_no_cause(store: Path, tmp_path: Path) -> None:
    found = diagnosed(made(tmp_path, "material.mu_MPa=3.6"), store)
    assert found.decision.answer == "none"
    write(found, [COUPONS], tmp_path)
    extended = configuration.load(tmp_path / "extended.toml")
    assert extended.material.mu_MPa == pytest.approx(3.6, rel=0.01)
    assert extended.extensions == Config().extensions


def test_what_no_effect_does_is_unknown(store: Path, tmp_path: Path) -> None:
    found = diagnosed(made(tmp_path, wrong=lambda x: 1 + 0.1 * np.sin(9 * x)), store)
    decision = found.decision
    print(decision)
    assert decision.answer == "unknown"
    assert decision.unknown > 0.9


def test_quick_measures_no_gain(store: Path, tmp_path: Path) -> None:
    found = diagnosed(COUPONS, store, quick=True)
    assert (found.held_out, found.next) == (None, [])
    write(found, [COUPONS], tmp_path)
    assert outcome.DiagnosisFile.read(tmp_path / "diagnosis.json").quick


def test_a_strong_cause_is_no_unknown_one(store: Path, tmp_path: Path) -> None:
    """Of 200 standard deviations."""
    hidden = ("extensions.prony.g=[0.25]", "extensions.prony.tau_s=[8.0]")
    found = diagnosed(made(tmp_path, *hidden), store, quick=True)
    assert found.decision.first == ("prony",)
    outsider = made(tmp_path, *hidden, wrong=lambda x: 1 + 0.2 * np.sin(9 * x))
    assert diagnosed(outsider, store, quick=True).decision.answer == "unknown"


def test_a_wrong_unit_is_suspected_in_the_first_line(store: Path, tmp_path: Path) -> None:
    file = made(tmp_path, wrong=lambda x: np.full_like(x, 101.97))
    found = diagnosed(file, store, quick=True)
    text = write(found, [file], tmp_path).text
    assert "force in grams" in text.splitlines()[0]
