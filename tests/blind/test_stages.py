"""The blind benchmark: its stages, from the simulation of coupons to the table of figures."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.blind import __main__ as stages
from benchmarks.blind import library


@pytest.mark.xfail(
    reason="the closed form finds 4 of these 6 cases, of which it is to find 5", strict=True
)
def test_from_the_simulation_of_coupons_to_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All stages, twice: the second time nothing is computed."""
    every = ["library", "full", "cases", "diagnose", "score"]
    told = ["--only", "coupon", "--number", "6", "--quick", "--out", str(tmp_path)]
    assert stages.main([*every, *told]) == 0
    assert "6 cases" in capsys.readouterr().out
    folder = tmp_path / "score" / "coupon-development-quick"
    figures = pd.read_csv(folder / "figures.csv")
    rows = pd.read_csv(folder / "cases.csv")
    assert len(rows) == 6
    # all but the case whose two laws undo one another: 12 and 14 σ alone, 4.7 σ together
    detected = figures.set_index("name").loc["detection from 6 σ", "value"]
    assert detected == pytest.approx(5 / 6)
    assert list(rows.loc[rows["answer"] == "none", "kind"]) == ["two"]
    wanted = library.entries("coupon")
    assert {entry.job.key for entry in wanted} == set(library.known(wanted, tmp_path / "library"))
    # measurements without a cause: a call goes on where the one before it was stopped
    for count in ("2", "3"):
        assert stages.main(["alarms", *told, "--draws", count, "--seed", "7"]) == 0
    draws = pd.read_csv(tmp_path / "alarms" / "7" / "coupon.csv")
    assert list(draws["draw"]) == [0, 1, 2]
    assert draws["none"].nunique() == 3
    alarms = pd.read_csv(tmp_path / "alarms" / "alarms.csv").iloc[0]
    assert alarms["seed"] == 7
    assert alarms["alarms"] == pytest.approx((draws["answer"] != "none").mean(), abs=1e-4)
    first = (folder / "figures.csv").read_bytes()
    assert stages.main([*every, *told]) == 0
    assert (folder / "figures.csv").read_bytes() == first


def test_what_is_asked_for_in_vain(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for told, complaint in (
        (["--only", "P9"], "--only P9: allowed: P1"),
        (["libary"], "libary: allowed: library"),
        (["--workers", "0"], "--workers 0: allowed: 1 or more"),
    ):
        with pytest.raises(SystemExit) as left:
            stages.parsed(told)
        assert left.value.code == 2
        assert complaint in capsys.readouterr().err
    assert stages.main(["cases", "--only", "P1", "--out", str(tmp_path)]) == 2
    assert "run the stage library first" in capsys.readouterr().out
