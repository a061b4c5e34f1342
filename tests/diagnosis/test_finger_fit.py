"""A short finger: causes are simulated on the ungraded mesh, the claim on the graded one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import hidden_bending
from support.delivered import Delivered, delivered
from support.here import Here

from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.finger import coarser

PRESSURES_kPa = (0, 25, 50, 75, 100)
HIDDEN_MPa = 1.8
SEED = 5


@pytest.fixture(scope="module")
def softened(tmp_path_factory: pytest.TempPathFactory, store: Path) -> Delivered:
    config = hidden_bending.config()
    hidden = {"mooney_rivlin": {"C01_MPa": HIDDEN_MPa}}
    folder = tmp_path_factory.mktemp("lab")
    file = hidden_bending.measured(folder, hidden, PRESSURES_kPa, SEED)
    settings = DiagnosisSettings(effects=("mooney_rivlin", "angle_gain"))
    found = diagnose_measurement(read([file], config), config, Here(store), settings)
    return delivered(found, tmp_path_factory.mktemp("out"), [file])


@pytest.mark.slow
def test_hidden_softening_is_found_at_its_strength(softened: Delivered) -> None:
    """The truth was simulated on the graded mesh; the ungraded one alone would be off by more."""
    assert coarser(hidden_bending.config())[0]
    assert softened.result.mesh_known
    verdict = softened.verdict
    print(verdict, softened.result.warnings)
    assert (verdict.answer, verdict.effects) == ("cause", ("mooney_rivlin",))
    assert verdict.probability > 0.9
    assert verdict.unexplained < 0.05
    strength = softened.numbers["extensions.mooney_rivlin.C01_MPa"]
    print("C01", strength)
    wide = strength.high - strength.low
    assert strength.low - 0.5 * wide < HIDDEN_MPa < strength.high + 0.5 * wide
    assert wide < HIDDEN_MPa
    assert np.abs(softened.left).max() == pytest.approx(0, abs=3.5)


@pytest.mark.slow
def test_what_is_written_is_what_was_fitted(softened: Delivered) -> None:
    """The modulus and the softening; the first line has the softening."""
    assert softened.verdict.effects == ("mooney_rivlin",)
    extended, numbers = softened.extended, softened.numbers
    assert extended.material.mu_MPa == pytest.approx(numbers["material.mu_MPa"].value)
    told = extended.extensions.mooney_rivlin.C01_MPa  # type: ignore[attr-defined]
    assert told == pytest.approx(numbers["extensions.mooney_rivlin.C01_MPa"].value)
    headline = softened.result.headline
    assert headline.number == numbers["extensions.mooney_rivlin.C01_MPa"]
    assert headline.option == f"--config {softened.folder / 'extended.toml'}"
    # a softening finger bends farther
    assert headline.common is not None
    assert headline.common.way == "softer"
