"""The store: one SQLite file, written by one process, read by any.

A row is a job. It is entered as ``pending``, and becomes ``done`` or ``failed`` in one transaction
that is on the disk before it is reported; a ``done`` row never changes again.
"""

from __future__ import annotations

import fcntl
import json
import sqlite3
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from dolfingrip.files.whole import failed, replacing
from dolfingrip.jobs.job import Answer, Data, Job
from dolfingrip.sections.errors import ConfigError

NAME = "campaign.sqlite"
"""File in a folder of jobs."""

FORMAT = 2
"""Version of the tables."""

Shared = Callable[[Data | None], Data]
"""From what the jobs of a store have shared so far, None before the first, to what they share with
further ones. It raises ValueError with one phrase where these do not belong to them."""

_TABLES = f"""
BEGIN IMMEDIATE;
PRAGMA user_version = {FORMAT};
CREATE TABLE IF NOT EXISTS facts (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS jobs (
    number INTEGER PRIMARY KEY,
    key TEXT NOT NULL UNIQUE,
    function TEXT NOT NULL,
    arguments TEXT NOT NULL,
    inputs TEXT NOT NULL,
    status TEXT NOT NULL DEFAULT 'pending' CHECK (status IN ('pending', 'done', 'failed')),
    result TEXT,
    partial TEXT,
    failure_class TEXT,
    failure TEXT,
    started_at TEXT,
    wall_s REAL,
    worker TEXT,
    CHECK (status = 'done' OR result IS NULL),
    CHECK ((status = 'failed') = (failure_class IS NOT NULL))
);
COMMIT;
"""

_JSON = ("arguments", "inputs", "result", "partial")
_ANSWERED = (
    "result", "partial", "failure_class", "failure", "started_at", "wall_s", "worker",
)  # fmt: skip


_OF_DISK = frozenset({sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_READONLY})
"""SQLite's errors that tell of the disk."""


def same(**facts: Any) -> Shared:
    """Facts that all jobs of a store share, refused where they differ from those before."""

    def shared(before: Data | None) -> Data:
        for name, value in (before or {}).items():
            if facts.get(name) != value:
                raise ValueError(f"{name} was {value}, now {facts.get(name)}")
        return facts

    return shared


class Store:
    """An open store.

    Raises:
        ConfigError: one line, where the file is none, another process writes it, or there is
            nothing to read.
        WriteError: one line, where it cannot be written; every method that writes raises it, too.
    """

    def __init__(self, folder: Path, *, write: bool = False) -> None:
        self.path = folder / NAME
        self._lock = None
        if write:
            try:
                folder.mkdir(parents=True, exist_ok=True)
                self._lock = (folder / "campaign.lock").open("w")
            except OSError as error:
                raise failed(self.path, error) from None
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self._lock.close()
                raise ConfigError(f"{folder}: another process runs this campaign") from None
        elif not self.path.is_file():
            raise ConfigError(f"{self.path}: no such campaign")
        try:
            self._base = self._open(write)
            (version,) = self._base.execute("PRAGMA user_version").fetchone()
            (entries,) = self._base.execute("SELECT COUNT(*) FROM sqlite_master").fetchone()
            if version != FORMAT and (entries or not write):
                self.close()
                raise ConfigError(
                    f"{self.path}: has version {version} of the tables; allowed: {FORMAT}, or "
                    "another folder"
                )
            if write:
                self._base.executescript(_TABLES)
        except sqlite3.Error as error:
            if self._lock is not None:
                self._lock.close()
            _require_space(self.path, error)
            raise ConfigError(f"{self.path}: not a campaign's store: {error}") from None

    def _open(self, write: bool) -> sqlite3.Connection:
        if not write:
            return sqlite3.connect(f"{self.path.absolute().as_uri()}?mode=ro", uri=True)
        base = sqlite3.connect(self.path, isolation_level=None)
        base.execute("PRAGMA journal_mode = WAL")
        base.execute("PRAGMA synchronous = FULL")  # a commit outlives a power cut too
        return base

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, and let others write it."""
        self._base.close()
        if self._lock is not None:
            self._lock.close()

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All or nothing, on the disk when it is left."""
        try:
            self._base.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                if self._base.in_transaction:  # SQLite itself ends it where the disk is full
                    self._base.execute("ROLLBACK")
                raise
            self._base.execute("COMMIT")
        except sqlite3.Error as error:
            _require_space(self.path, error)
            raise

    def facts(self) -> Data | None:
        """Facts that all jobs share; None before the first."""
        row = self._base.execute("SELECT value FROM facts WHERE name = 'plan'").fetchone()
        return None if row is None else json.loads(row[0])

    def add(self, jobs: Iterable[Job], shared: Shared) -> None:
        """Enter jobs that are not there yet as pending, all or none.

        Raises:
            ConfigError: where they do not belong to those that are there.
        """
        try:
            facts = shared(self.facts())
        except ValueError as error:
            raise ConfigError(
                f"{self.path.parent}: {error}; allowed: the same settings, or another --out"
            ) from None
        rows = [
            (job.key, job.function, json.dumps(job.arguments), json.dumps(job.inputs))
            for job in jobs
        ]
        with self._transaction():
            self._base.execute("REPLACE INTO facts VALUES ('plan', ?)", (json.dumps(facts),))
            self._base.executemany(
                "INSERT OR IGNORE INTO jobs (key, function, arguments, inputs) VALUES (?, ?, ?, ?)",
                rows,
            )

    def record(self, answer: Answer) -> bool:
        """Enter an answer; False where its job has one already or is not known."""
        plain = json.loads(answer.dumps())
        values = {name: plain[name] for name in _ANSWERED}
        for name in set(_JSON) & set(_ANSWERED):
            values[name] = None if values[name] is None else json.dumps(values[name])
        if answer.status == "failed":
            values["result"] = None
        columns = ", ".join(f"{name} = ?" for name in values)
        with self._transaction():
            changed = self._base.execute(
                f"UPDATE jobs SET status = ?, {columns} WHERE key = ? AND status = 'pending'",
                (answer.status, *values.values(), answer.key),
            )
        return changed.rowcount == 1

    def reopen(self, keys: Iterable[str], spared: Collection[str] = ()) -> list[str]:
        """Make the failed jobs among ``keys`` pending again; their keys.

        Args:
            keys: of jobs.
            spared: classes of failures that stay.
        """
        query = "SELECT key, failure_class FROM jobs WHERE status = 'failed'"
        classes = dict(self._base.execute(query))
        failed = [key for key in keys if key in classes and classes[key] not in spared]
        blank = ", ".join(f"{name} = NULL" for name in _ANSWERED)
        with self._transaction():
            self._base.executemany(
                f"UPDATE jobs SET status = 'pending', {blank} WHERE key = ?",
                [(key,) for key in failed],
            )
        return failed

    def status(self, key: str) -> str | None:
        """Status of a job, None where it is not known."""
        row = self._base.execute("SELECT status FROM jobs WHERE key = ?", (key,)).fetchone()
        return None if row is None else str(row[0])

    def counts(self) -> dict[str, int]:
        """Number of jobs by status."""
        found = {"pending": 0, "done": 0, "failed": 0}
        found.update(
            self._base.execute("SELECT status, COUNT(*) FROM jobs GROUP BY status").fetchall()
        )
        return found

    def rows(self) -> Iterator[dict[str, Any]]:
        """Every job in the order of entry, JSON columns as objects."""
        cursor = self._base.execute("SELECT * FROM jobs ORDER BY number")
        names = [column[0] for column in cursor.description]
        for values in cursor:
            row = dict(zip(names, values, strict=True))
            yield row | {n: json.loads(row[n]) for n in _JSON if row[n] is not None}


def _require_space(path: Path, error: sqlite3.Error) -> None:
    """Raise if the disk, not the file's content, is what SQLite complains about."""
    if (getattr(error, "sqlite_errorcode", None) or 0) & 0xFF in _OF_DISK:
        with replacing(path):  # which replaces nothing, and tells a full disk from other reasons
            raise OSError(str(error))
