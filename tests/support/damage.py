"""Damages of a store and of a spool, each by a name: what a disk, a crash or a hand can do."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path

from support import analytic
from support.this_process import ThisProcess

from dolfingrip.config import Config
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.jobs.run import Standing, run
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import NAME
from dolfingrip.jobs.work import work

PLAN = Plan(
    Config(),
    ("morph.xi1",),
    tuple({"morph.xi1": value} for value in (0.0, 0.1, 0.2, 0.3, 0.4, 0.9)),
    objective=analytic.PATH,
)
"""Six designs, the last of which fails."""

Damage = Callable[[Path], None]
"""Damages a store, or an answer in a spool; it is given the file."""


def _sql(*statements: str) -> Damage:
    def damage(file: Path) -> None:
        with closing(sqlite3.connect(file)) as base, base:
            base.execute("PRAGMA ignore_check_constraints = ON")
            for statement in statements:
                base.execute(statement)

    return damage


def _row(change: str) -> Damage:
    return _sql(f"UPDATE jobs SET {change} WHERE number = 2")


def _bytes(change: Callable[[bytes], bytes]) -> Damage:
    def damage(file: Path) -> None:
        file.write_bytes(change(file.read_bytes()))

    return damage


def _page(data: bytes, number: int, content: bytes) -> bytes:
    size = int.from_bytes(data[16:18], "big")
    begin = size * number
    return data[:begin] + (content * size)[:size] + data[begin + size :]


def _json(change: Callable[[dict[str, object]], object]) -> Damage:
    def damage(file: Path) -> None:
        file.write_text(json.dumps(change(json.loads(file.read_text()))))

    return damage


OF_STORES: Mapping[str, Damage] = {
    "a result that is cut": _row("result = substr(result, 1, 40)"),
    "a result of another value": _row("result = replace(result, '2.9', '7.9')"),
    "done without a result": _row("result = NULL"),
    "done, though it was not": _sql("UPDATE jobs SET status = 'done' WHERE status = 'failed'"),
    "inputs that are no JSON": _row("inputs = '{'"),
    "arguments without a configuration": _row("arguments = '{}'"),
    "text that is no UTF-8": _row("result = CAST(x'7bff7d' AS TEXT)"),
    "nested too deeply": _row(f"result = '{20_000 * '['}'"),
    "a number in place of a text": _row("result = 3"),
    "the key of another job": _row("key = 'k'"),
    "no digest": _row("digest = NULL"),
    "without settings": _sql("DELETE FROM facts"),
    "settings that are cut": _sql("UPDATE facts SET value = substr(value, 1, 9)"),
    "other settings": _sql("UPDATE facts SET value = '{}'"),
    "a page of zeros": _bytes(lambda data: _page(data, 6, b"\0")),
    "a page of noise": _bytes(lambda data: _page(data, 6, b"noise")),
    "the file's end is gone": _bytes(lambda data: data[: len(data) * 9 // 10]),
}
"""After each the same command has to end with all designs."""

LOST: Mapping[str, Damage] = {
    "no database": _bytes(lambda data: _page(data, 0, b"\0")),
    "no column": _sql("ALTER TABLE jobs DROP COLUMN wall_s"),
    "another version": _sql("PRAGMA user_version = 9"),
}
"""After each a command has to refuse the store."""

OF_SPOOLS: Mapping[str, Damage] = {
    "empty": _bytes(lambda data: b""),
    "cut": _bytes(lambda data: data[:60]),
    "no UTF-8": _bytes(lambda data: b"\xff" + data[1:]),
    "nested too deeply": _bytes(lambda data: 20_000 * b"["),
    "another value": _bytes(lambda data: data.replace(b"2.9", b"7.9")),
    "a list": _json(lambda answer: [answer]),
    "without a key": _json(lambda answer: {**answer, "key": None}),
    "of another job": _json(lambda answer: {**answer, "key": "k"}),
    "an unknown status": _json(lambda answer: {**answer, "status": "nonsense"}),
    "done without a result": _json(lambda answer: {**answer, "result": None}),
}
"""Each of the spooled answer of the design that the store's second row has."""


def computed(folder: Path) -> Standing:
    """Compute the plan in this process."""
    return run(PLAN.jobs(), folder, ThisProcess(), PLAN.shared)


def stored(folder: Path) -> Path:
    """A campaign's store as it is at rest; its file."""
    computed(folder)
    file = folder / NAME
    with closing(sqlite3.connect(file)) as base:
        base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    return file


def spooled(folder: Path) -> Path:
    """The answer of the plan's second design in its spool; its file."""
    spool = Spool((folder / "spool").absolute())
    spool.folder.mkdir(parents=True)
    (job,) = PLAN.jobs()[1:2]
    work(job, spool.folder)
    return spool.folder / f"{job.key}.json"
