"""The SQLite file that holds a hyperparameter study's trials, whole ones only."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from dolfingrip.sections.errors import ConfigError

BUSY_S = 60.0
"""How long to wait for another process that writes."""


class Key(NamedTuple):
    """The settings that identify a run of NSGA-II."""

    population: int
    crossover: float
    mutation: float
    seed: int


class Choice(NamedTuple):
    """The design chosen after some generations of a run; None throughout where there was none."""

    population: int
    generations: int
    crossover: float
    mutation: float
    seed: int
    front_points: int
    design: tuple[float, ...] | None
    cog_offset_mm: float | None
    force_N: float | None


class Trials:
    """Trials by key. One transaction writes all of a trial: a killed study has no half ones."""

    def __init__(self, file: Path, identity: dict[str, Any]) -> None:
        """Open or make the file.

        Args:
            file: of the study.
            identity: what all its trials have in common, JSON-serialisable.

        Raises:
            ConfigError: the file belongs to a study of something else, or is no such file.
        """
        self.file = file
        self._connection = sqlite3.connect(file, timeout=BUSY_S)
        try:
            self._make(json.dumps(identity, sort_keys=True))
        except sqlite3.DatabaseError as error:
            self.close()
            raise ConfigError(f"{file}: {error}; allowed: the store of a study") from None
        except ConfigError:
            self.close()
            raise

    def _make(self, identity: str) -> None:
        with self._connection as connection:
            connection.execute("CREATE TABLE IF NOT EXISTS study (identity TEXT NOT NULL)")
            connection.execute(
                "CREATE TABLE IF NOT EXISTS choice ("
                "population INTEGER, generations INTEGER, crossover REAL, mutation REAL, "
                "seed INTEGER, front_points INTEGER, design TEXT, cog_offset_mm REAL, "
                "force_N REAL, cpu_s REAL, "
                "PRIMARY KEY (population, generations, crossover, mutation, seed))"
            )
            found = connection.execute("SELECT identity FROM study").fetchone()
            if found is None:
                connection.execute("INSERT INTO study VALUES (?)", (identity,))
            elif found[0] != identity:
                raise ConfigError(
                    f"{self.file}: the study of another surrogate or limit; allowed: another --out"
                )

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def done(self, generations: Sequence[int]) -> set[Key]:
        """Runs whose choices after all these generations are there."""
        with closing(self._connection.cursor()) as cursor:
            rows = cursor.execute(
                "SELECT population, crossover, mutation, seed FROM choice WHERE generations IN "
                f"({','.join('?' * len(generations))}) "
                "GROUP BY population, crossover, mutation, seed HAVING count(*) = ?",
                (*generations, len(generations)),
            )
            return {Key(*row) for row in rows}

    def add(self, key: Key, result: dict[str, Any]) -> None:
        """Write the result of :func:`dolfingrip.design.optimum.trial.run`."""
        with self._connection as connection:
            connection.executemany(
                "INSERT OR REPLACE INTO choice VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                [
                    (
                        key.population,
                        choice["generations"],
                        key.crossover,
                        key.mutation,
                        key.seed,
                        choice["front_points"],
                        None if choice["design"] is None else json.dumps(choice["design"]),
                        choice["cog_offset_mm"],
                        choice["force_N"],
                        result["cpu_s"],
                    )
                    for choice in result["choices"]
                ],
            )

    def choices(self) -> list[Choice]:
        """All that there are, in the order of their keys."""
        names = ", ".join(Choice._fields)
        with closing(self._connection.cursor()) as cursor:
            rows = cursor.execute(
                f"SELECT {names} FROM choice "
                "ORDER BY population, generations, crossover, mutation, seed"
            ).fetchall()
        place = Choice._fields.index("design")
        return [
            Choice(*row)._replace(
                design=None if row[place] is None else tuple(json.loads(row[place]))
            )
            for row in rows
        ]

    def seconds(self) -> float:
        """Processor time of all runs together."""
        with closing(self._connection.cursor()) as cursor:
            total = cursor.execute(
                "SELECT sum(cpu) FROM (SELECT max(cpu_s) AS cpu FROM choice "
                "GROUP BY population, crossover, mutation, seed)"
            ).fetchone()[0]
        return float(total or 0.0)
