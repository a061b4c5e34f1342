"""The store, the spool and the exported table."""

from __future__ import annotations

import csv
import fcntl
import json
import sqlite3
from contextlib import closing
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet
import pytest
from support.campaign_store import failures

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.jobs.job import Job, JobResult
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import Store, same
from dolfingrip.jobs.work import compute, work


def plan(*xi1: float, **changes: object) -> Plan:
    points = tuple({"morph.xi1": value} for value in xi1)
    base = Config.model_validate(changes)
    return Plan(base, ("morph.xi1",), points, objective="support.analytic:objective")


def filled(folder: Path) -> list[str]:
    """A store of one design each way."""
    wanted = plan(0.1, 0.7, 0.3)
    jobs = wanted.jobs()
    with Store(folder, write=True) as store:
        store.add(jobs, wanted.shared)
        for job in jobs[:2]:
            assert store.record(compute(job))
    return [job.key for job in jobs]


def test_a_job_is_claimed_by_one_worker_at_a_time(tmp_path: Path) -> None:
    """Workers of two commands on one folder may have the same job."""
    claimed = Spool(tmp_path).claimed("job")
    with claimed, (tmp_path / "job.lock").open() as other, pytest.raises(BlockingIOError):
        fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_every_status_is_kept(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    with Store(tmp_path) as store:
        assert [store.status(key) for key in keys] == ["done", "failed", "pending"]
        assert store.counts() == {"done": 1, "failed": 1, "pending": 1}
        assert failures(store) == {"limit point": 1}
    done, failed, pending = campaign.read(tmp_path).designs
    assert done.inputs == {"morph.xi1": 0.1}
    with Store(tmp_path) as store:
        first = next(store.rows())
    assert first["arguments"]["config"] == plan(0.1).designs()[0].config
    assert done.outputs == pytest.approx({"cog_offset_mm": 2.9, "force_N": 4.1})
    assert done.curve["force_N"] == [0.0, done.outputs["force_N"]]
    assert done.iterations == 3
    assert done.wall_s >= 0
    assert failed.failure == "stopped at 12 kPa"
    assert failed.outputs is failed.gradients is pending.outputs is None


def result(value: float) -> dict[str, object]:
    return {"outputs": {"cog_offset_mm": value, "force_N": value}}


def test_a_result_is_never_changed_and_a_failure_only_where_reopened(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    with Store(tmp_path, write=True) as store:
        for key in keys[:2]:
            assert not store.record(JobResult(key, "done", result(0.0)))
        assert not store.record(JobResult("unknown", "done"))
        assert store.reopen(keys, spared=["limit point"]) == []
        assert store.reopen(keys) == [keys[1]]
        assert store.counts() == {"done": 1, "failed": 0, "pending": 2}
        assert store.record(JobResult(keys[1], "done", result(1.0)))


def test_designs_that_are_there_are_entered_no_second_time(tmp_path: Path) -> None:
    """Neither their answers nor their numbers change, so the export keeps its order."""
    filled(tmp_path)
    with Store(tmp_path, write=True) as store:
        before = list(store.rows())
        again = plan(0.3, 0.1, 0.7, 0.2)
        store.add(again.jobs(), again.shared)
        *kept, new = store.rows()
    assert kept == before
    assert (new["inputs"], new["status"]) == ({"morph.xi1": 0.2}, "pending")


def test_a_failed_design_has_no_numbers(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    with Store(tmp_path, write=True) as store:
        store.record(JobResult(keys[2], "failed", result(9.0), failure_class="error"))
    with (
        closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as base,
        pytest.raises(sqlite3.IntegrityError),  # the file itself holds to it
    ):
        base.execute("UPDATE jobs SET result = '{}' WHERE status = 'failed'")
    found = campaign.table(tmp_path).to_pylist()[2]
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


def test_tables_of_another_version_are_refused(tmp_path: Path) -> None:
    """So that no store of before is filled anew without a word."""
    with sqlite3.connect(tmp_path / "campaign.sqlite") as base:
        base.execute("CREATE TABLE designs (key TEXT)")
    base.close()
    for write in (False, True):
        with pytest.raises(ConfigError, match=r"has version 0 of the tables; allowed: \d"):
            Store(tmp_path, write=write)


def test_other_jobs_are_refused(tmp_path: Path) -> None:
    """A folder holds what belongs together, in whichever order it comes."""
    designs = plan(0.1)
    other = ([Job("k", "json:loads", {})], same(surrogate="a", cog_max_mm=3.0))
    with Store(tmp_path / "designs", write=True) as store:
        store.add(designs.jobs(), designs.shared)
        with pytest.raises(ConfigError, match="allowed: the same settings, or another --out"):
            store.add(*other)
    with Store(tmp_path / "others", write=True) as store:
        store.add(*other)
        with pytest.raises(ConfigError, match="schema was None, now 2"):
            store.add(designs.jobs(), designs.shared)
        with pytest.raises(ConfigError, match=r"cog_max_mm was 3\.0, now 3\.5"):
            store.add(other[0], same(surrogate="a", cog_max_mm=3.5))
        assert [row["key"] for row in store.rows()] == ["k"]


def test_an_interrupted_job_has_no_answer(tmp_path: Path) -> None:
    """PETSc passes Ctrl-C on as an error of its own, which is no failure of the job."""
    with pytest.raises(KeyboardInterrupt):
        work(Job("k", f"{__name__}:interrupted", {}), tmp_path)
    assert list(Spool(tmp_path).answers()) == []


def interrupted() -> None:
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt as error:
        raise RuntimeError("error code 98") from error


def test_keys_that_are_not_used_do_not_make_another_campaign() -> None:
    """One version more has a key more, or a law more; its default changes no result."""
    wanted = plan(0.1)
    before = deepcopy(wanted.facts())
    before["base"]["material"]["gent_limit"] = 50.0  # of another law
    del before["base"]["experiment"]["snaps"]
    before["base"]["solver"]["time_limit_s"] = 7.0
    assert wanted.shared(before)["parameters"] == ["morph.xi1"]
    before["base"]["material"]["gent_limit"] = 40.0
    with pytest.raises(ValueError, match=r"material\.gent_limit was 40\.0, now None"):
        wanted.shared(before)


def test_other_settings_are_another_campaign(tmp_path: Path) -> None:
    filled(tmp_path)
    other = plan(0.2, material={"mu_MPa": 3.0})
    with Store(tmp_path, write=True) as store:
        with pytest.raises(ConfigError, match=r"material\.mu_MPa was 2\.93, now 3\.0; allowed"):
            store.add(other.jobs(), other.shared)
        # a parameter more is no contradiction: its old value stands with each design
        points = ({"material.mu_MPa": 3.0, "morph.xi1": 0.2},)
        more = Plan(other.base, tuple(points[0]), points, objective=other.objective)
        store.add(more.jobs(), more.shared)
    table = campaign.table(tmp_path)
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
            store.add(plan.jobs(), plan.shared)
        assert store.counts()["pending"] == 1


def test_export_as_csv_and_parquet(tmp_path: Path) -> None:
    keys = filled(tmp_path)
    paths = [tmp_path / "designs.csv", tmp_path / "tables" / "designs.parquet"]
    assert campaign.write(tmp_path, paths) == 3
    rows = list(csv.DictReader(paths[0].open(encoding="utf-8", newline="")))
    assert [row["key"] for row in rows] == keys
    assert [row["status"] for row in rows] == ["done", "failed", "pending"]
    assert [row["force_N"] for row in rows] == [repr(4 + 0.1), "", ""]
    assert json.loads(rows[1]["curve"]) == {"force_N": [0.0, 1.0]}
    table = pyarrow.parquet.read_table(paths[1])
    assert table["morph.xi1"].to_pylist() == [0.1, 0.7, 0.3]
    assert table["force_N"].null_count == 2
    assert table.equals(campaign.table(tmp_path / "campaign.sqlite"))


def test_spooled_answer_is_not_computed_again(tmp_path: Path) -> None:
    Spool(tmp_path).write(JobResult("k", "done", {"force_N": 5.0}))
    assert work(Job("k", "no:module", {}), tmp_path).result == {"force_N": 5.0}
    assert [answer.key for answer in Spool(tmp_path).answers()] == ["k"]
    Spool(tmp_path).clear()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["", "{", "[]", '{"nothing": 1}', "null"])
def test_torn_spool_file_is_no_answer(text: str, tmp_path: Path) -> None:
    (tmp_path / "k.json").write_text(text)
    assert Spool(tmp_path).read("k") is None


def test_unforeseen_error_is_an_answer(tmp_path: Path) -> None:
    answer = work(Job("k", "json:loads", {}), tmp_path)
    assert (answer.status, answer.failure_class) == ("failed", "error")
    assert "TypeError" in str(answer.failure)


def test_no_number_is_a_failure() -> None:
    (job,) = replace(plan(0.1), quantities=("angle_deg",)).jobs()
    answer = compute(job)
    assert (answer.status, answer.failure_class) == ("failed", "no number")
