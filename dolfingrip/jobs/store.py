"""The store: one SQLite file, written by one process, read by any.

A row is a job. It is entered as ``pending``, and becomes ``done`` or ``failed`` in one transaction
that is on the disk before it is reported; a ``done`` row never changes again.

Each row has a digest, by which damage is found. Who writes a store sets damaged rows aside when he
opens it, so that their jobs are computed anew; who reads one refuses them.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import logging
import os
import sqlite3
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from dolfingrip.files.whole import failed, replacing
from dolfingrip.jobs.job import Data, Job, JobResult, content_key
from dolfingrip.sections.errors import ConfigError

NAME = "campaign.sqlite"
"""File in a folder of jobs."""

FORMAT = 3
"""Version of the tables. Those of version 2 have no digests; who writes them adds these."""

_LOG = logging.getLogger(__name__)

_CHECK = "allowed: dolfingrip doe --check FOLDER, which sets it aside to be computed anew"

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
    digest TEXT,
    CHECK (status = 'done' OR result IS NULL),
    CHECK ((status = 'failed') = (failure_class IS NOT NULL))
);
CREATE TABLE IF NOT EXISTS aside (found_at TEXT, key TEXT, entries TEXT);
COMMIT;
"""

_JSON = ("arguments", "inputs", "result", "partial")
_ANSWERED = (
    "result", "partial", "failure_class", "failure", "started_at", "wall_s", "worker",
)  # fmt: skip
_SEALED = ("key", "function", "arguments", "inputs", "status", *_ANSWERED)
"""Columns that a digest is of."""

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
        self._settled = True
        try:
            self._base = self._open(write)
            version = self._sound_version(write)
            if write:
                if version == 2:
                    self._base.execute("ALTER TABLE jobs ADD COLUMN digest TEXT")
                if version != FORMAT:
                    self._base.executescript(_TABLES)
                self._examine(of_before=version == 2)
        except sqlite3.Error as error:
            self.close()
            _tell(self.path, error)
            raise ConfigError(f"{self.path}: not a campaign's store: {error}") from None
        except BaseException:
            self.close()
            raise

    def _open(self, write: bool) -> sqlite3.Connection:
        if write:
            base = sqlite3.connect(self.path, isolation_level=None)
        else:
            base = sqlite3.connect(f"{self.path.absolute().as_uri()}?mode=ro", uri=True)
        # what is not UTF-8 is found by its digest
        base.text_factory = lambda raw: raw.decode(errors="surrogateescape")
        return base

    def _sound_version(self, write: bool) -> int:
        """The version of the tables.

        A file that is damaged as a file is set aside by a writer, who keeps what can be read.

        Raises:
            ConfigError: where the version is not known, or a reader meets a damaged file.
        """
        try:
            (version,) = self._base.execute("PRAGMA user_version").fetchone()
            query = "SELECT COUNT(*) FROM sqlite_master"
            begun = version in ((2, FORMAT) if write else (FORMAT,))
            if not begun and (version or not write or self._base.execute(query).fetchone()[0]):
                raise ConfigError(
                    f"{self.path}: has version {version} of the tables; allowed: {FORMAT}, or "
                    "another folder"
                )
            verdict = self._base.execute("PRAGMA integrity_check(1)").fetchone()[0]
        except sqlite3.DatabaseError as error:
            if _code(error) != sqlite3.SQLITE_CORRUPT:
                raise
            version, verdict = FORMAT, str(error)
        verdict = verdict.splitlines()[-1]
        if verdict != "ok" and not write:
            raise ConfigError(f"{self.path}: damaged: {verdict}; {_CHECK}")
        if verdict != "ok":
            self._salvage(verdict)
            version = FORMAT
        if write:
            self._base.execute("PRAGMA journal_mode = WAL")
            self._base.execute("PRAGMA synchronous = FULL")  # a commit outlives a power cut too
        return int(version)

    def _salvage(self, why: str) -> None:
        """Set the file aside, and begin another with the rows that are whole."""
        self._base.close()
        head = self.path.read_bytes()[:32]
        size = int.from_bytes(head[16:18]) * int.from_bytes(head[28:32])
        if self.path.stat().st_size < size:  # SQLite reads nothing of a file that is too short
            os.truncate(self.path, size)
        self._base = self._open(write=True)
        facts, rows = [], {}
        columns = ", ".join(("number", *_SEALED, "digest"))
        for order in ("ASC", "DESC"):  # up to the damage from either side
            with suppress(sqlite3.DatabaseError):
                facts = self._base.execute("SELECT * FROM facts").fetchall()
            with suppress(sqlite3.DatabaseError):
                for row in self._base.execute(
                    f"SELECT {columns} FROM jobs ORDER BY number {order}"
                ):
                    rows[row[0]] = row
        self._base.close()
        aside = self.path.with_name(f"{NAME}.damaged-{datetime.now(UTC):%Y%m%dT%H%M%S.%f}")
        for end in ("-wal", "-shm", ""):
            with suppress(FileNotFoundError):
                self.path.with_name(NAME + end).rename(aside.with_name(aside.name + end))
        _LOG.warning("%s: damaged: %s; set aside as %s", self.path, why, aside.name)
        self._base = self._open(write=True)
        self._base.executescript(_TABLES)
        marks = ", ".join("?" * (len(_SEALED) + 2))
        sound = [row for row in rows.values() if row[-1] == _digest(row[1:-1])]
        with self._transaction():
            with suppress(UnicodeEncodeError):
                self._base.executemany("INSERT OR IGNORE INTO facts VALUES (?, ?)", facts)
            self._base.executemany(
                f"INSERT OR IGNORE INTO jobs ({columns}) VALUES ({marks})", sound
            )

    def _examine(self, *, of_before: bool) -> None:
        """Set aside what is damaged.

        Args:
            of_before: rows have no digests yet, and only their contents tell.
        """
        if of_before:
            with self._transaction(), suppress(ValueError, TypeError):
                (facts,) = self._base.execute("SELECT value FROM facts").fetchone()
                self._write_facts(json.loads(facts))
            for row in self._base.execute(f"SELECT {', '.join(_SEALED)} FROM jobs").fetchall():
                if _readable(row):
                    self._seal(row[0])
        query = self._base.execute(f"SELECT digest, {', '.join(_SEALED)} FROM jobs")
        damaged = [row[0] for digest, *row in query if digest != _digest(row)]
        if damaged:
            self._set_aside(damaged)
        try:
            self.facts()
        except ConfigError:
            self._settled = False

    def _set_aside(self, keys: Sequence[str]) -> None:
        """Put rows where they are no jobs any more."""
        now = datetime.now(UTC).isoformat(timespec="seconds")
        with self._transaction():
            for key in keys:
                raw = key.encode(errors="surrogateescape")
                where = "WHERE CAST(key AS BLOB) = ?"
                row = self._base.execute(f"SELECT * FROM jobs {where}", (raw,)).fetchone()
                entries = now, ascii(key), json.dumps(row, default=repr)
                self._base.execute("INSERT INTO aside VALUES (?, ?, ?)", entries)
                self._base.execute(f"DELETE FROM jobs {where}", (raw,))
        _LOG.warning(
            "%s: %d rows are damaged; set aside, to be computed anew: %s",
            self.path, len(keys), ", ".join(ascii(key[:16]) for key in keys),
        )  # fmt: skip

    def _seal(self, key: str) -> None:
        """Give a row the digest of what it holds now."""
        row = self._base.execute(f"SELECT {', '.join(_SEALED)} FROM jobs WHERE key = ?", (key,))
        digest = _digest(row.fetchone())
        self._base.execute("UPDATE jobs SET digest = ? WHERE key = ?", (digest, key))

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
            _tell(self.path, error)
            raise

    def facts(self) -> Data | None:
        """Facts that all jobs share; None before the first.

        Raises:
            ConfigError: one line, where it is damaged or lost.
        """
        by_name = dict(self._base.execute("SELECT name, value FROM facts"))
        if not by_name and not sum(self.counts().values()):
            return None
        with suppress(ValueError, RecursionError):
            facts: Data = json.loads(by_name.get("plan", ""))
            if content_key(facts) == by_name.get("digest"):
                return facts
        raise ConfigError(
            f"{self.path}: what its designs share is damaged; allowed: the command that made it, "
            "which sets aside the designs that are not its own"
        )

    def _write_facts(self, facts: Data) -> None:
        entries = {"plan": json.dumps(facts), "digest": content_key(facts)}
        self._base.executemany("REPLACE INTO facts VALUES (?, ?)", entries.items())

    def agreed(self, shared: Shared) -> Data:
        """Facts that jobs share, once others are added to them.

        Raises:
            ConfigError: where these do not belong to those that are there.
        """
        try:
            return shared(self.facts() if self._settled else None)
        except ValueError as error:
            raise ConfigError(
                f"{self.path.parent}: {error}; allowed: the same settings, or another --out"
            ) from None

    def add(self, jobs: Iterable[Job], shared: Shared) -> None:
        """Enter jobs that are not there yet as pending, all or none.

        Raises:
            ConfigError: where they do not belong to those that are there.
        """
        jobs, facts = list(jobs), self.agreed(shared)
        rows = [
            (job.key, job.function, json.dumps(job.arguments), json.dumps(job.inputs))
            for job in jobs
        ]
        if not self._settled:  # the keys tell which rows belong to these settings
            _LOG.warning("%s: what its jobs share is damaged; entered anew", self.path)
            keys = {job.key for job in jobs}
            stored = [key for (key,) in self._base.execute("SELECT key FROM jobs")]
            if others := [key for key in stored if key not in keys]:
                self._set_aside(others)
        with self._transaction():
            self._write_facts(json.loads(json.dumps(facts)))
            self._base.executemany(
                "INSERT OR IGNORE INTO jobs (key, function, arguments, inputs) VALUES (?, ?, ?, ?)",
                rows,
            )
            for (key,) in self._base.execute(
                "SELECT key FROM jobs WHERE digest IS NULL"
            ).fetchall():
                self._seal(key)
        self._settled = True

    def record(self, answer: JobResult) -> bool:
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
            if changed.rowcount:
                self._seal(answer.key)
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
            for key in failed:
                self._seal(key)
        return failed

    def status(self, key: str) -> str | None:
        """Status of a job, None where it is not known."""
        row = self._base.execute("SELECT status FROM jobs WHERE key = ?", (key,)).fetchone()
        return None if row is None else str(row[0])

    def counts(self) -> dict[str, int]:
        """Number of jobs by status."""
        by_status = {"pending": 0, "done": 0, "failed": 0}
        by_status.update(
            self._base.execute("SELECT status, COUNT(*) FROM jobs GROUP BY status").fetchall()
        )
        return by_status

    def aside(self) -> list[str]:
        """Keys of all rows that were set aside since the store was made."""
        return [key for (key,) in self._base.execute("SELECT key FROM aside")]

    def rows(self) -> Iterator[dict[str, Any]]:
        """Every job in the order of entry, JSON columns as objects.

        Raises:
            ConfigError: one line, where a row is damaged.
        """
        columns = ("number", *_SEALED)
        try:
            query = f"SELECT digest, {', '.join(columns)} FROM jobs ORDER BY number"
            for digest, number, *values in self._base.execute(query):
                if digest != _digest(values):
                    raise ConfigError(f"{self.path}: row {number} is damaged; {_CHECK}")
                row = dict(zip(columns, (number, *values), strict=True))
                yield row | {n: json.loads(row[n]) for n in _JSON if row[n] is not None}
        except sqlite3.Error as error:
            _tell(self.path, error)
            raise ConfigError(f"{self.path}: not a campaign's store: {error}") from None


def _digest(row: Sequence[Any]) -> str:
    return hashlib.sha256(ascii(tuple(row)).encode()).hexdigest()


def _readable(row: Sequence[Any]) -> bool:
    """Tell whether a row without a digest has what it must have."""
    named = dict(zip(_SEALED, row, strict=True))
    try:
        parsed = {name: json.loads(named[name]) for name in _JSON if named[name] is not None}
    except (ValueError, TypeError, RecursionError):
        return False
    all_tables = all(isinstance(value, dict) for value in parsed.values())
    return all_tables and ((named["status"] == "done") == ("result" in parsed))


def _code(error: sqlite3.Error) -> int:
    """SQLite's kind of an error."""
    return (getattr(error, "sqlite_errorcode", None) or 0) & 0xFF


def _tell(path: Path, error: sqlite3.Error) -> None:
    """Raise one line if the disk, or damage of the file, is what SQLite complains about."""
    code = _code(error)
    if code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB):
        raise ConfigError(f"{path}: not a campaign's store: {error}; {_CHECK}") from None
    if code in _OF_DISK:
        with replacing(path):  # which replaces nothing, and tells a full disk from other reasons
            raise OSError(str(error))
