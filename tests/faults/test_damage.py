"""Damage of stores and spools: none is accepted, and what it hit is computed anew.

The reference is the campaign before the damage.
"""

from __future__ import annotations

import json
import logging
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from support import damage
from support.command import run_command

from dolfingrip.config import ConfigError
from dolfingrip.design.campaign import campaign
from dolfingrip.jobs.job import JobResult
from dolfingrip.jobs.run import check
from dolfingrip.jobs.store import NAME, Store

TOLD = ("started_at", "wall_s", "worker", "number")
"""What differs between two computations."""


def content(folder: Path) -> dict[str, dict[str, Any]]:
    """All that a campaign says of its designs."""
    rows = campaign.read(folder).by_key()
    return {
        key: {name: value for name, value in rows[key] if name not in TOLD} for key in sorted(rows)
    }


@pytest.mark.parametrize("name", damage.OF_STORES)
def test_a_damaged_store(name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    file = damage.stored(tmp_path)
    before = content(tmp_path)
    with Store(tmp_path) as store:
        facts = store.facts()
    damage.OF_STORES[name](file)
    with pytest.raises(ConfigError, match=r"damaged.*; allowed: ") as refused:
        content(tmp_path)
    assert "\n" not in str(refused.value)
    standing = damage.computed(tmp_path)
    assert (standing.done, standing.failed) == (5, 1)
    assert standing.computed < standing.total  # what can be read of the others is kept
    assert content(tmp_path) == before
    with Store(tmp_path) as store:
        assert store.facts() == facts
    said = [entry for entry in caplog.records if entry.levelno == logging.WARNING]
    assert said
    assert all("damaged" in entry.getMessage() for entry in said)
    caplog.clear()
    assert damage.computed(tmp_path).computed == 0
    assert not caplog.records


@pytest.mark.parametrize("name", damage.LOST)
@pytest.mark.parametrize("read", [True, False])
def test_a_store_of_which_nothing_can_be_read(name: str, read: bool, tmp_path: Path) -> None:
    damage.LOST[name](damage.stored(tmp_path))
    before = (tmp_path / NAME).read_bytes()
    with pytest.raises(ConfigError, match=r"campaign\.sqlite: ") as refused:
        content(tmp_path) if read else damage.computed(tmp_path)
    assert "\n" not in str(refused.value)
    assert (tmp_path / NAME).read_bytes() == before


@pytest.mark.parametrize("name", damage.OF_SPOOLS)
def test_a_damaged_answer(name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    damage.stored(tmp_path / "reference")
    file = damage.spooled(tmp_path / "damaged")
    damage.OF_SPOOLS[name](file)
    content_of_file = file.read_bytes()
    standing = damage.computed(tmp_path / "damaged")
    assert (standing.computed, standing.done, standing.failed) == (6, 5, 1)
    assert content(tmp_path / "damaged") == content(tmp_path / "reference")
    (entry,) = caplog.records
    assert f"{file.name}: damaged: " in entry.getMessage()
    assert Path(f"{file}.damaged").read_bytes() == content_of_file


def test_settings_that_are_lost_keep_designs_of_others_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A design that the calling command does not know may be one of other settings."""
    file = damage.stored(tmp_path)
    damage.OF_STORES["without settings"](file)
    with Store(tmp_path, write=True) as store:
        store.add(damage.PLAN.jobs()[:2], damage.PLAN.shared)
        assert store.counts() == {"pending": 0, "done": 2, "failed": 0}
        assert len(store.aside()) == 4
    assert "4 rows are damaged; set aside" in caplog.text


def test_doe_looks_through_a_campaign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = damage.stored(tmp_path)
    assert run_command("doe", "--check", tmp_path) == 0
    assert "6 designs and answers are whole" in capsys.readouterr().out
    damage.OF_STORES["a result of another value"](file)
    key = damage.PLAN.jobs()[1].key
    assert run_command("doe", "--check", tmp_path) == 1
    said = capsys.readouterr().out
    assert "5 designs and answers are whole" in said
    assert key in said
    assert len(content(tmp_path)) == 5
    assert run_command("doe", "--check", tmp_path / "nothing") == 2
    assert not (tmp_path / "nothing").exists()


@pytest.mark.parametrize("result", ["NULL", "3", "'{'"])
def test_a_store_without_digests_gets_them(result: str, tmp_path: Path) -> None:
    """As version 2 of the tables has it: what can be read is kept."""
    file = damage.stored(tmp_path)
    before = content(tmp_path)
    with closing(sqlite3.connect(file)) as base, base:
        base.execute("PRAGMA ignore_check_constraints = ON")
        base.execute("ALTER TABLE jobs DROP COLUMN digest")
        base.execute("DELETE FROM facts WHERE name = 'digest'")
        base.execute(f"UPDATE jobs SET result = {result} WHERE number = 2")
        base.execute("PRAGMA user_version = 2")
    with pytest.raises(ConfigError, match="has version 2 of the tables"):
        content(tmp_path)
    assert check(tmp_path) == (5, [repr(damage.PLAN.jobs()[1].key)])
    assert damage.computed(tmp_path).computed == 1
    assert content(tmp_path) == before
    assert json.dumps(before)


@pytest.mark.parametrize(
    ("said", "version", "tables", "write"),
    [
        ("has version 99 of the tables", 99, False, True),
        ("has version 99 of the tables", 99, True, True),
        ("has version 99 of the tables", 99, True, False),
        ("has version 0 of the tables", 0, True, True),
        ("has version 0 of the tables", 0, False, False),
    ],
)
def test_a_file_of_another_program_or_version_stays_as_it_is(
    said: str, version: int, tables: bool, write: bool, tmp_path: Path
) -> None:
    with closing(sqlite3.connect(tmp_path / NAME, isolation_level=None)) as base:
        base.execute(f"PRAGMA user_version = {version}")
        base.execute("PRAGMA journal_mode = DELETE")
        if tables:
            base.execute("CREATE TABLE notes (text TEXT)")
        else:
            base.execute("VACUUM")  # which writes the head
    before = (tmp_path / NAME).read_bytes()
    with pytest.raises(ConfigError, match=said):
        Store(tmp_path, write=write)
    assert (tmp_path / NAME).read_bytes() == before


def test_an_interrupt_while_an_answer_is_entered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing of it stays, and the store goes on."""

    def interrupted(store: Store, key: str) -> None:
        raise KeyboardInterrupt

    jobs = damage.PLAN.jobs()
    answer = JobResult(jobs[0].key, "done", {"outputs": {"cog_offset_mm": 1.0}})
    with Store(tmp_path, write=True) as store:
        store.add(jobs, damage.PLAN.shared)
        with monkeypatch.context() as patch:
            patch.setattr(Store, "_seal", interrupted)
            with pytest.raises(KeyboardInterrupt):
                store.record(answer)
        assert {row["status"] for row in store.rows()} == {"pending"}
        assert store.record(answer)
        assert [row["status"] for row in store.rows()].count("done") == 1
