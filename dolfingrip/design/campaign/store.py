"""The store of a campaign: one SQLite file, written by one process, read by any.

A row is a design. It is entered as ``pending``, and becomes ``done`` or ``failed`` in one
transaction that is on the disk before it is reported; a ``done`` row never changes again.
"""

from __future__ import annotations

import fcntl
import json
import sqlite3
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Any

from dolfingrip.design.campaign.answer import Answer
from dolfingrip.design.campaign.plan import Design, differences, merged
from dolfingrip.sections.errors import ConfigError

NAME = "campaign.sqlite"
"""File in a campaign's folder."""

_TABLES = """
CREATE TABLE IF NOT EXISTS facts (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS designs (
    number INTEGER PRIMARY KEY,
    key TEXT NOT NULL UNIQUE,
    inputs TEXT NOT NULL,
    config TEXT NOT NULL,
    status TEXT NOT NULL DEFAULT 'pending' CHECK (status IN ('pending', 'done', 'failed')),
    outputs TEXT,
    gradients TEXT,
    curve TEXT,
    failure_class TEXT,
    failure TEXT,
    iterations INTEGER,
    started_at TEXT,
    wall_s REAL,
    worker TEXT,
    versions TEXT,
    CHECK (status = 'done' OR (outputs IS NULL AND gradients IS NULL)),
    CHECK ((status = 'failed') = (failure_class IS NOT NULL))
);
"""

_JSON = ("inputs", "config", "outputs", "gradients", "curve", "versions")
_ANSWERED = (
    "outputs", "gradients", "curve", "failure_class", "failure", "iterations", "started_at",
    "wall_s", "worker", "versions",
)  # fmt: skip


class Store:
    """An open store.

    Raises:
        ConfigError: one line, where the file is none, another process writes it, or there is
            nothing to read.
    """

    def __init__(self, folder: Path, *, write: bool = False) -> None:
        self.path = folder / NAME
        self._lock = None
        if write:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = (folder / "campaign.lock").open("w")
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self._lock.close()
                raise ConfigError(f"{folder}: another process runs this campaign") from None
        elif not self.path.is_file():
            raise ConfigError(f"{self.path}: no such campaign")
        try:
            self._base = self._open(write)
        except sqlite3.Error as error:
            raise ConfigError(f"{self.path}: not a campaign's store: {error}") from None

    def _open(self, write: bool) -> sqlite3.Connection:
        if not write:
            base = sqlite3.connect(f"{self.path.absolute().as_uri()}?mode=ro", uri=True)
            base.execute("SELECT key FROM designs LIMIT 1")
            return base
        base = sqlite3.connect(self.path, isolation_level=None)
        base.execute("PRAGMA journal_mode = WAL")
        base.execute("PRAGMA synchronous = FULL")  # a commit outlives a power cut too
        base.executescript(_TABLES)
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

    def facts(self) -> dict[str, Any] | None:
        """What all designs share; None before the first."""
        row = self._base.execute("SELECT value FROM facts WHERE name = 'plan'").fetchone()
        return None if row is None else json.loads(row[0])

    def add(self, facts: dict[str, Any], designs: Iterable[Design]) -> None:
        """Enter designs that are not there yet as pending, all or none.

        Raises:
            ConfigError: where the campaign was begun with other settings.
        """
        before = self.facts()
        if before is not None:
            change = next(differences(before, facts), None)
            if change is not None:
                raise ConfigError(
                    f"{self.path.parent}: {change}; allowed: the same settings, or another --out"
                )
            facts = merged(before, facts)
        rows = [(d.key, json.dumps(d.inputs), json.dumps(d.config)) for d in designs]
        with _transaction(self._base):
            self._base.execute("REPLACE INTO facts VALUES ('plan', ?)", (json.dumps(facts),))
            self._base.executemany(
                "INSERT OR IGNORE INTO designs (key, inputs, config) VALUES (?, ?, ?)", rows
            )

    def record(self, answer: Answer) -> bool:
        """Enter an answer; False where its design has one already or is not known."""
        plain = json.loads(answer.dumps())
        values = {name: plain[name] for name in _ANSWERED}
        for name in set(_JSON) & set(_ANSWERED):
            values[name] = None if values[name] is None else json.dumps(values[name])
        if answer.status == "failed":
            values["outputs"] = values["gradients"] = None
        columns = ", ".join(f"{name} = ?" for name in values)
        with _transaction(self._base):
            changed = self._base.execute(
                f"UPDATE designs SET status = ?, {columns} WHERE key = ? AND status = 'pending'",
                (answer.status, *values.values(), answer.key),
            )
        return changed.rowcount == 1

    def reopen(self, keys: Iterable[str], spared: Collection[str] = ()) -> list[str]:
        """Make the failed designs among ``keys`` pending again; their keys.

        Args:
            keys: of designs.
            spared: classes of failures that stay.
        """
        query = "SELECT key, failure_class FROM designs WHERE status = 'failed'"
        classes = dict(self._base.execute(query))
        failed = [key for key in keys if key in classes and classes[key] not in spared]
        blank = ", ".join(f"{name} = NULL" for name in _ANSWERED)
        with _transaction(self._base):
            self._base.executemany(
                f"UPDATE designs SET status = 'pending', {blank} WHERE key = ?",
                [(key,) for key in failed],
            )
        return failed

    def status(self, key: str) -> str | None:
        """Status of a design, None where it is not known."""
        row = self._base.execute("SELECT status FROM designs WHERE key = ?", (key,)).fetchone()
        return None if row is None else str(row[0])

    def counts(self) -> dict[str, int]:
        """Number of designs by status."""
        found = {"pending": 0, "done": 0, "failed": 0}
        found.update(
            self._base.execute("SELECT status, COUNT(*) FROM designs GROUP BY status").fetchall()
        )
        return found

    def rows(self) -> Iterator[dict[str, Any]]:
        """Every design in the order of entry, JSON columns as objects."""
        cursor = self._base.execute("SELECT * FROM designs ORDER BY number")
        names = [column[0] for column in cursor.description]
        for values in cursor:
            row = dict(zip(names, values, strict=True))
            yield row | {n: json.loads(row[n]) for n in _JSON if row[n] is not None}


class _transaction:
    """All or nothing, on the disk when it is left."""

    def __init__(self, base: sqlite3.Connection) -> None:
        self._base = base

    def __enter__(self) -> None:
        self._base.execute("BEGIN IMMEDIATE")

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._base.execute("COMMIT" if kind is None else "ROLLBACK")
