"""The fit of the reconstructed geometry: its closed forms, and what it makes of a campaign."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[1]))

from benchmarks import geometry_fit
from dolfingrip.config import Config, Finger
from dolfingrip.design.campaign.answer import Answer
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.store import Store
from dolfingrip.experiments.derivatives.gradients import cog_offset_mm
from dolfingrip.meshes.morph import Morph

CANDIDATE = {"finger.channel_width_mm": 9.0, "finger.gap_mm": 1.5}


@pytest.mark.parametrize("xi", [(0.0, 0.0), *geometry_fit.OPTIMA.values()])
@pytest.mark.parametrize("dimensions", [{}, {"channel_width_mm": 7.0, "base_block_mm": 15.0}])
def test_closed_form_is_the_mesh_s_centroid(
    dimensions: dict[str, float], xi: tuple[float, float]
) -> None:
    """The boxes' faces stay planes under the morph, so any mesh has the exact centroid."""
    data = Config().model_dump()
    data["finger"] |= dimensions
    data["mesh"]["size_mm"] = 10.0
    data["morph"] |= {"xi1": xi[0], "xi2": xi[1], "d_mm": 9.5}
    config = Config.model_validate(data)
    found = geometry_fit.centroid_mm(config.finger, Morph(*xi, 9.5)) - config.cog.x_ref_mm
    # the plane x = d cuts elements, whose middle edges it bends: 1e-3 mm on so coarse a mesh
    assert found == pytest.approx(cog_offset_mm(config)[0], abs=2e-3)


def test_the_reference_finger_meets_the_offsets() -> None:
    found = geometry_fit.offsets(Finger(), 9.5)
    assert found.x_ref_mm == pytest.approx(Config().cog.x_ref_mm, abs=0.005)
    assert found.residual_mm < 0.01
    assert 2.5 < found.original_mm < 3.0


def test_what_cannot_meet_them_is_dropped() -> None:
    assert geometry_fit.complete(Config(), {"finger.depth_mm": 24.0}) is None
    assert geometry_fit.complete(Config(), {"finger.wall_mm": 9.0}) is None  # no finger at all
    candidate = geometry_fit.complete(Config(), CANDIDATE)
    assert candidate is not None
    assert candidate.items() > CANDIDATE.items()


def test_candidates_are_judged_by_the_paper(tmp_path: Path) -> None:
    """Invented forces: the figures of the table follow from them by hand."""
    candidate = geometry_fit.complete(Config(), CANDIDATE)
    assert candidate is not None
    fingers = geometry_fit.fingers(candidate)
    plan = Plan(Config(), tuple(fingers[0]), tuple(fingers))
    pressures = [0.0, 50.0, 100.0, 150.0, 200.0, 250.0]
    width = Config().contact.barrier_mm
    with Store(tmp_path, write=True) as store:
        store.add(plan.facts(), plan.designs())
        for design, force in zip(plan.designs(), (4.0, 3.8, 4.4, 5.0), strict=True):
            # twice as steep from 150 kPa on, where the gap is as narrow as the barrier
            curve = [force * (p + max(p - 150, 0)) / 350 for p in pressures]
            store.record(
                Answer(
                    design.key,
                    "done",
                    outputs={"force_N": force, "cog_offset_mm": 3.0},
                    gradients={
                        "force_N": {"morph.xi1": 5.0, "morph.xi2": 2.0},
                        "cog_offset_mm": {"morph.xi1": 4.0, "morph.xi2": 2.0},
                    },
                    curve={
                        "blocked_pressure_kPa": pressures,
                        "force_N": curve,
                        "blocked_contact_gap_mm": [
                            None,
                            1.5,
                            (1.5 + width) / 2,
                            width,
                            width,
                            width,
                        ],
                    },
                )
            )
    (row,) = geometry_fit.judged(Config(), tmp_path)
    assert [row[f"gain_OD{limit}_percent"] for limit in ("2.5", "3", "3.5")] == [-5.0, 10.0, 25.0]
    assert row["worst_miss_percent"] == pytest.approx(2.7)
    assert row["turning_kPa"] == pytest.approx(150.0, abs=2.0)
    assert row["touch_kPa"] == pytest.approx(150.0)
    # (5 − 2 · 4 / 2) N for each ξ1, of 4.4 N
    assert row["slope_at_OD3_percent"] == pytest.approx(10 / 4.4, abs=0.01)
    assert json.dumps(row)
