"""The store, the spool and the exported table."""

from __future__ import annotations

import csv
import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pyarrow.parquet
import pytest
from design.stored import failures

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import export
from dolfingrip.design.campaign.answer import Answer
from dolfingrip.design.campaign.evaluate import Task, evaluate, work
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.spool import Spool
from dolfingrip.design.campaign.store import Store


def plan(*xi1: float, **changes: object) -> Plan:
    points = tuple({"morph.xi1": value} for value in xi1)
    base = Config.model_validate(changes)
    return Plan(base, ("morph.xi1",), points, objective="design.analytic:objective")


def filled(folder: Path) -> list[str]:
    """A store of one design each way."""
    wanted = plan(0.1, 0.7, 0.3)
    designs = wanted.designs()
    with Store(folder, write=True) as store:
        store.add(wanted.facts(), designs)
        for design in designs[:2]:
            task = Task(design.key, design.config, wanted.quantities, wanted.objective, 1, "")
            assert store.record(evaluate(task))
    return [design.key for design in designs]


def test_every_status_is_kept(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    with Store(tmp_path) as store:
        assert [store.status(key) for key in keys] == ["done", "failed", "pending"]
        assert store.counts() == {"done": 1, "failed": 1, "pending": 1}
        assert failures(store) == {"limit point": 1}
        done, failed, pending = store.rows()
    assert done["inputs"] == {"morph.xi1": 0.1}
    assert done["config"] == plan(0.1).designs()[0].config
    assert done["outputs"] == pytest.approx({"cog_offset_mm": 2.9, "force_N": 4.1})
    assert done["curve"]["force_N"] == [0.0, done["outputs"]["force_N"]]
    assert done["iterations"] == 3
    assert done["wall_s"] >= 0
    assert failed["failure"] == "stopped at 12 kPa"
    assert failed["outputs"] is failed["gradients"] is pending["outputs"] is None


def test_a_result_is_never_changed_and_a_failure_only_where_reopened(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    with Store(tmp_path, write=True) as store:
        for key in keys[:2]:
            assert not store.record(Answer(key, "done", {"cog_offset_mm": 0.0, "force_N": 0.0}))
        assert not store.record(Answer("unknown", "done"))
        assert store.reopen(keys, spared=["limit point"]) == []
        assert store.reopen(keys) == [keys[1]]
        assert store.counts() == {"done": 1, "failed": 0, "pending": 2}
        assert store.record(Answer(keys[1], "done", {"cog_offset_mm": 1.0, "force_N": 1.0}))


def test_designs_that_are_there_are_entered_no_second_time(tmp_path: Path) -> None:
    """Neither their answers nor their numbers change, so the export keeps its order."""
    filled(tmp_path)
    with Store(tmp_path, write=True) as store:
        before = list(store.rows())
        again = plan(0.3, 0.1, 0.7, 0.2)
        store.add(again.facts(), again.designs())
        *kept, new = store.rows()
    assert kept == before
    assert (new["inputs"], new["status"]) == ({"morph.xi1": 0.2}, "pending")


def test_a_failed_design_has_no_numbers(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    with Store(tmp_path, write=True) as store:
        store.record(Answer(keys[2], "failed", {"force_N": 9.0}, failure_class="error"))
    with (
        closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as base,
        pytest.raises(sqlite3.IntegrityError),  # the file itself holds to it
    ):
        base.execute("UPDATE designs SET outputs = '{}' WHERE status = 'failed'")
    found = export.table(tmp_path).to_pylist()[2]
    assert (found["status"], found["force_N"]) == ("failed", None)


def test_one_writer(tmp_path: Path) -> None:
    refused = pytest.raises(ConfigError, match="another process runs this campaign")
    with Store(tmp_path, write=True), refused:
        Store(tmp_path, write=True)
    Store(tmp_path, write=True).close()


def test_what_is_no_campaign(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such campaign"):
        Store(tmp_path)
    (tmp_path / "campaign.sqlite").write_text("no database " * 100)
    for write in (False, True):
        with pytest.raises(ConfigError, match="not a campaign's store"):
            Store(tmp_path, write=write)


def test_other_settings_are_another_campaign(tmp_path: Path) -> None:
    filled(tmp_path)
    other = plan(0.2, material={"mu_MPa": 3.0})
    with Store(tmp_path, write=True) as store:
        with pytest.raises(ConfigError, match=r"material\.mu_MPa was 2\.93, now 3\.0; allowed"):
            store.add(other.facts(), other.designs())
        # a parameter more is no contradiction: its old value stands with each design
        points = ({"material.mu_MPa": 3.0, "morph.xi1": 0.2},)
        more = Plan(other.base, tuple(points[0]), points, objective=other.objective)
        store.add(more.facts(), more.designs())
    table = export.table(tmp_path)
    assert table["material.mu_MPa"].to_pylist() == [2.93, 2.93, 2.93, 3.0]


def test_the_time_allowed_is_no_part_of_a_design(tmp_path: Path) -> None:
    config = Config()
    patient = config.model_copy(
        update={"solver": config.solver.model_copy(update={"time_limit_s": 60.0})}
    )
    plans = [Plan(base, ("morph.xi1",), ({"morph.xi1": 0.1},)) for base in (config, patient)]
    assert plans[0].designs()[0].key == plans[1].designs()[0].key
    with Store(tmp_path, write=True) as store:
        for plan in plans:
            store.add(plan.facts(), plan.designs())
        assert store.counts()["pending"] == 1


def test_export_as_csv_and_parquet(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    paths = [tmp_path / "designs.csv", tmp_path / "tables" / "designs.parquet"]
    assert export.write(tmp_path, paths) == 3
    rows = list(csv.DictReader(paths[0].open(encoding="utf-8", newline="")))
    assert [row["key"] for row in rows] == keys
    assert [row["status"] for row in rows] == ["done", "failed", "pending"]
    assert [row["force_N"] for row in rows] == [repr(4 + 0.1), "", ""]
    assert json.loads(rows[1]["curve"]) == {"force_N": [0.0, 1.0]}
    table = pyarrow.parquet.read_table(paths[1])
    assert table["morph.xi1"].to_pylist() == [0.1, 0.7, 0.3]
    assert table["force_N"].null_count == 2
    assert table.equals(export.table(tmp_path / "campaign.sqlite"))


def test_spooled_answer_is_not_computed_again(tmp_path: Path) -> None:
    task = Task("k", plan(0.1).designs()[0].config, ("force_N",), "no:module", 1, str(tmp_path))
    Spool(tmp_path).write(Answer("k", "done", {"force_N": 5.0}))
    assert work(task).outputs == {"force_N": 5.0}
    assert [answer.key for answer in Spool(tmp_path).answers()] == ["k"]
    Spool(tmp_path).clear()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["", "{", "[]", '{"nothing": 1}', "null"])
def test_torn_spool_file_is_no_answer(text: str, tmp_path: Path) -> None:
    (tmp_path / "k.json").write_text(text)
    assert Spool(tmp_path).read("k") is None


def test_unforeseen_error_is_an_answer(tmp_path: Path) -> None:
    answer = work(Task("k", {}, (), "json:loads", 1, str(tmp_path)))
    assert (answer.status, answer.failure_class) == ("failed", "error")
    assert "TypeError" in str(answer.failure)


def test_no_number_is_a_failure() -> None:
    config = plan(0.1).designs()[0].config
    answer = evaluate(Task("k", config, ("angle_deg",), "design.analytic:objective", 1, ""))
    assert (answer.status, answer.failure_class) == ("failed", "no number")
