"""``dolfingrip pickup`` and ``friction`` around invented grasps; nothing is solved."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from support import invented_grasp
from support.command import run_command

from dolfingrip.experiments import simulate
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.jobs.job import Job, JobResult
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import Store


@pytest.fixture
def grasps(threads: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Invented ones in place of the solver's."""

    def invented(request: Request, comm: object = None) -> Answer:
        return invented_grasp.grasp(request.config)

    monkeypatch.setattr(simulate, "compute", invented)


@pytest.mark.usefixtures("grasps")
def test_pickup(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    asked = ("pickup", "--out", str(tmp_path), "--friction", "0.38", "--preset", "coarse")
    assert run_command(*asked) == 0
    exact = invented_grasp.least_kPa(0.38)
    wanted = 5 * (exact // 5 + 1)
    said = capfd.readouterr().out
    assert f"picked up from {wanted:g} kPa on, not at {wanted - 5:g} kPa (μ = 0.38)" in said
    assert "(known)" not in said
    with (tmp_path / "pickup.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["outcome"] for row in rows} == {"picked up", "slipped"}
    assert run_command(*asked) == 0
    assert capfd.readouterr().out.count("(known)") == len(rows)
    assert run_command(*asked[:4], "0.01", "--highest", "150") == 1
    assert "not picked up at any pressure up to 150 kPa" in capfd.readouterr().out


@pytest.mark.usefixtures("threads")
@pytest.mark.parametrize(("kind", "count", "said"), [
    ("contact", 4, "not known whether any pressure up to 200 kPa picks it up: the grasp at "),
    ("error", 1, "no such thing; this is a fault of dolfingrip"),
])  # fmt: skip
def test_failures_are_no_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str],
    kind: str, count: int, said: str,
) -> None:  # fmt: skip
    """A search of grasps that all ended early, and one that ends with the program's own fault."""

    def failed(request: Request, comm: object = None) -> Answer:
        return Answer(failure_class=kind, failure="no such thing")

    monkeypatch.setattr(simulate, "compute", failed)
    asked = ("pickup", "--out", tmp_path, "--resolution", "50", "--start", "50")
    assert run_command(*asked, "--highest", "200") == 1
    text = capfd.readouterr().out
    assert said in text
    assert "not picked up" not in text
    with Store(tmp_path / "simulations") as store:
        assert store.counts() == {"pending": 0, "done": 0, "failed": count}


@pytest.mark.usefixtures("grasps")
def test_friction(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    asked = ("friction", "--pickup-pressure", "155", "--out", str(tmp_path), "--resolution", "5")
    assert run_command(*asked) == 0
    said = capfd.readouterr().out
    assert "μ = 0.38" in said
    assert "least pressure 155 kPa, found in steps of 5 kPa" in said
    assert (tmp_path / "friction.csv").exists()


def test_an_interrupted_search_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """And the grasp that was interrupted is made anew, not kept as a failure."""

    def interrupted(self: Pool, jobs: Sequence[Job], spool: Spool) -> Iterator[JobResult]:
        yield from ()
        raise KeyboardInterrupt

    monkeypatch.setattr(Pool, "answers", interrupted)
    assert run_command("pickup", "--out", str(tmp_path), "--preset", "coarse") == 130
    assert capfd.readouterr().err == (
        f"dolfingrip: interrupted: what was computed is kept in {tmp_path}; "
        "the same command goes on from there\n"
    )
    with Store(tmp_path / "simulations") as store:
        assert store.counts() == {"pending": 1, "done": 0, "failed": 0}


@pytest.mark.parametrize(("arguments", "said"), [
    (["pickup", "--resolution", "0"], "--resolution 0: allowed: above 0 kPa"),
    (["pickup", "--highest", "2000"], "--highest 2000: allowed: above 0 and up to 1000 kPa"),
    (["pickup", "--food", "pear"], 'food.kind = "pear"'),
    (["friction", "--pickup-pressure", "4"], "--resolution 5: allowed: above 0 and below 4 kPa"),
    (["friction", "--pickup-pressure", "9", "--tolerance", "1"],
     "--tolerance 1: allowed: at least 0.0001 and up to 0.5"),
])  # fmt: skip
def test_bad_input(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """One line, exit code 2, and nothing written."""
    monkeypatch.chdir(tmp_path)
    assert run_command(*arguments) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())
