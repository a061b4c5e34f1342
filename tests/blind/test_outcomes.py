"""The blind benchmark: a table of judged cases has all that figures are made of."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.blind import outcomes, report, score
from benchmarks.blind.opinions import Interval, Judged, Opinion


def test_a_table_gives_the_figures_again(tmp_path: Path) -> None:
    tie = Opinion("cause", 0.95, ("gent", "ogden"), (("gent", "ogden"),))
    two = Opinion("cause", 0.99, ("gent",), (("gent",), ("prony", "set")))
    none = Opinion("none", 0.8, (), ())
    every = [
        Judged("a", "P1", "one", True, ("gent",), (6.25,), 0.5, tie, tie,
               (Interval("extensions.gent.J", 1.5, 2.5, 2.0),), (), 0.5, 0.625, True),
        Judged("b", "P2", "two", False, ("gent", "prony"), (3.0, 12.5), 4.0, two, tie,
               (), (Interval("x: y", -1.0, 0.0, 0.25),), None, 0.0, None, 7.5),
        Judged("c", "P1", "none", False, (), (), 0.0, none, none),
    ]  # fmt: skip
    outcomes.table(every).to_csv(tmp_path / "cases.csv", index=False)
    again = outcomes.read(tmp_path / "cases.csv")
    assert again == every
    for one, other in zip(score.figures(every), score.figures(again), strict=True):
        assert (one.name, one.count, one.met) == (other.name, other.count, other.met)
        assert one.value == pytest.approx(other.value, nan_ok=True)


def test_sets_of_cases_beside_one_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    none, wrong = Opinion("none", 0.8, (), ()), Opinion("cause", 0.95, ("gent",), (("gent",),))
    for name, said in (("P7+", none), ("P1", wrong)):
        case = Judged(name, name, "none", False, (), (), 0.0, said, none)
        outcomes.table([case]).to_csv(tmp_path / f"{name}.csv", index=False)
    one, other = (str(tmp_path / f"{name}.csv") for name in ("P7+", "P1"))
    report.main(["--compare", f"one={one}", f"both={one}+{other}"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "| figure | target | one | both |"
    alarms = next(line for line in lines if "false alarms" in line)
    assert alarms.endswith("| 0.00 (0.00–0.95) / 0.00, 1 | 0.50 (0.03–0.97) / 0.00, 2 **no** |")
    for wrongly in ([], [one], ["--compare", f"one={one}", "--out", str(tmp_path), one]):
        with pytest.raises(SystemExit):
            report.main(wrongly)
