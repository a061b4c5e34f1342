"""The demo's design loop, on a short finger: real simulations, nothing computed twice."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import pytest
import typer
from support.small import short

from dolfingrip.cli import loop_commands as small_loop
from dolfingrip.config import load
from dolfingrip.design.campaign.campaign import read
from dolfingrip.files.optimum import OptimumFile
from dolfingrip.sections.tables import assignments

DESIGNS = ("morph.xi1=0:0.6:4", "morph.xi2=-0.4:0:3")
SETTINGS = short("experiment.max_pressure_kPa=25")


def test_settings_are_coarser_never_finer() -> None:
    coarse = small_loop.coarsened(
        load(None, assignments(["mesh.edge_size_mm=2", "finger.wall_mm=1.8"]))
    )
    assert (coarse.mesh.size_mm, coarse.mesh.edge_size_mm) == (
        small_loop.POLICY.size_mm,
        small_loop.POLICY.size_mm,
    )
    assert coarse.finger.wall_mm == 1.8
    assert coarse.experiment.step_kPa == coarse.experiment.max_pressure_kPa == 250
    assert small_loop.coarsened(load(None, assignments(["mesh.size_mm=14"]))).mesh.size_mm == 14


@pytest.mark.slow
@pytest.mark.usefixtures("threads")
def test_from_designs_to_a_choice_that_is_computed_again(tmp_path: Path) -> None:
    small_loop.run_small_loop(SETTINGS, tmp_path, DESIGNS)
    rows = read(tmp_path / "doe").by_key()
    assert len(rows) == 12
    assert {row.status for row in rows.values()} == {"done"}
    designs = OptimumFile.read(tmp_path / "optimum").designs
    by_role = {one.role: one for one in designs}
    assert set(by_role) == {"chosen", "original", "polished"}
    chosen, original = by_role["chosen"], by_role["original"]
    assert chosen.surrogate["cog_offset_mm"] <= small_loop.POLICY.largest_offset_mm
    # the original is a design of the campaign, too
    computed = next(row for row in rows.values() if not any(row.inputs.values()))
    assert computed.outputs is not None
    assert original.fem is not None
    assert chosen.fem is not None
    assert original.fem["force_N"] == pytest.approx(computed.outputs["force_N"], rel=1e-9)
    assert chosen.gain == pytest.approx(chosen.fem["force_N"] / original.fem["force_N"] - 1)
    assert matplotlib.image.imread(tmp_path / "optimum" / "pareto.png")[..., :3].std() > 0.01
    small_loop.run_small_loop(SETTINGS, tmp_path, DESIGNS)
    assert read(tmp_path / "doe").by_key() == rows

    # a choice that cannot be made is no success
    policy = small_loop.LoopPolicy(largest_offset_mm=-50.0)
    with pytest.raises(typer.Exit) as ended:
        small_loop.run_small_loop(SETTINGS, tmp_path, DESIGNS, policy)
    assert ended.value.exit_code == 1
