"""A short finger: causes are simulated on the ungraded mesh, the claim on the graded one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import hidden_bending
from support.here import Here

from dolfingrip import config as configuration
from dolfingrip.diagnosis.answer.found import fitted
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import Settings, judged
from dolfingrip.diagnosis.finger.found import MESH_UNKNOWN
from dolfingrip.diagnosis.outcome import DiagnosisFile
from dolfingrip.diagnosis.results import write
from dolfingrip.diagnosis.simulation import meshes

PRESSURES_kPa = (0, 25, 50, 75, 100)
HIDDEN_MPa = 1.8
SEED = 5


@pytest.fixture(scope="module")
def softened(tmp_path_factory: pytest.TempPathFactory, store: Path) -> CouponDiagnosis:
    config = hidden_bending.config()
    hidden = {"mooney_rivlin": {"C01_MPa": HIDDEN_MPa}}
    folder = tmp_path_factory.mktemp("lab")
    file = hidden_bending.measured(folder, hidden, PRESSURES_kPa, SEED)
    settings = Settings(effects=("mooney_rivlin", "angle_gain"))
    return judged(read([file], config), config, Here(store), settings)


def test_hidden_softening_is_found_at_its_strength(softened: CouponDiagnosis) -> None:
    """The truth was simulated on the graded mesh; the ungraded one alone would be off by more."""
    assert meshes.coarser(hidden_bending.config())[0]
    assert MESH_UNKNOWN not in softened.warnings
    decision = softened.decision
    print(decision.answer, decision.first, decision.probability, softened.warnings)
    assert (decision.answer, decision.first) == ("cause", ("mooney_rivlin",))
    assert decision.probability > 0.9
    assert decision.unexplained < 0.05
    fit = decision.best
    (strength,) = [e for e in softened.numbers(fit) if e.key.endswith("C01_MPa")]
    print("C01", strength)
    wide = strength.high - strength.low
    assert strength.low - 0.5 * wide < HIDDEN_MPa < strength.high + 0.5 * wide
    assert wide < HIDDEN_MPa
    left = softened.analysed.case.value - fitted(softened.analysed, fit)
    assert np.abs(left / softened.analysed.errors.noise).max() == pytest.approx(0, abs=3.5)


def test_what_is_written_is_what_was_fitted(softened: CouponDiagnosis, tmp_path: Path) -> None:
    """The modulus and the softening; the page begins with ten lines."""
    write(softened, [Path("hidden.csv")], tmp_path)
    result = DiagnosisFile.read(tmp_path / "diagnosis.json")
    assert result.verdict.effects == ("mooney_rivlin",)
    extended = configuration.load(tmp_path / "extended.toml")
    numbers = {e.key: e.value for e in softened.numbers(softened.decision.best)}
    assert extended.material.mu_MPa == pytest.approx(numbers["material.mu_MPa"])
    told = extended.extensions.mooney_rivlin.C01_MPa  # type: ignore[attr-defined]
    assert told == pytest.approx(numbers["extensions.mooney_rivlin.C01_MPa"])
    page = (tmp_path / "summary.md").read_text(encoding="utf-8")
    assert page.startswith("RESULT")
    assert "mooney_rivlin" in page.splitlines()[0]
