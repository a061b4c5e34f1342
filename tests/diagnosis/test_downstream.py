"""A campaign's best designs, by the extended model."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.invented_force import PATH

from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.diagnosis.downstream import compare, read_campaign
from dolfingrip.files.diagnosis_words import fate
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.sections.tables import assignments

TESTS = Path(__file__).parents[1]
POINTS = [(0.1, 0.0), (-0.2, 0.0), (0.2, 0.1), (0.15, 0.5), (0.9, 0.0)]
"""xi1 and xi2; the last one's COG offset is beyond the limit."""


def designs(*points: tuple[float, float]) -> tuple[Inputs, ...]:
    return tuple({"morph.xi1": a, "morph.xi2": b} for a, b in points)


def test_the_optimum_moves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By hand: force 2.93 (1 + 0.3 xi1 + 0.1 xi2) before, with -0.2 xi1 after."""
    monkeypatch.setenv("PYTHONPATH", str(TESTS))
    base = Config().changed(experiment={"max_pressure_kPa": 300.0})
    keys = ("morph.xi1", "morph.xi2")
    where = Where(workers=1)
    campaign.run(Plan(base, keys, designs(*POINTS), objective=PATH), tmp_path / "doe", where)
    softening = changed(Config(), assignments(("extensions.mooney_rivlin.C01_MPa=1.0",)))
    with Pool(where) as pool:
        found = compare(tmp_path / "doe", Config(), softening, tmp_path / "after", pool)
    assert [each.inputs["morph.xi1"] for each in found.designs] == [0.15, 0.2, 0.1, -0.2]
    first, second, *_ = found.designs
    assert first.phi_before == pytest.approx(0.3 * 0.15 + 0.1 * 0.5)
    assert first.phi_after is None  # the extended model fails there
    assert second.phi_after == pytest.approx(-0.2 * 0.2 + 0.1 * 0.1)
    assert found.original_after_N == found.original_before_N == pytest.approx(2.93)
    assert found.designs[0].inputs == first.inputs
    best = max(found.designs, key=lambda each: each.force_after_N or 0.0)
    assert best.inputs["morph.xi1"] == -0.2
    assert best.phi_after == pytest.approx(0.04)
    assert "could not be computed" in fate(found)


def test_no_campaign(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such campaign"):
        read_campaign(tmp_path)
