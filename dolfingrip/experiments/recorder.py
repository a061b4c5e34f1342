"""The files that a run writes into its folder, row by row."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomlkit

from dolfingrip.channels import CHANNELS, WHO, measured, read_of
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.results import record
from dolfingrip.experiments.results.fields import FieldFile
from dolfingrip.experiments.results.result import Row
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.profile import Profile

EFFORT = ("iterations", "load_steps")
"""The solver's effort."""


def columns(experiment: Experiment) -> tuple[str, ...]:
    """Columns of an experiment's ``result.csv``.

    First those of the measured-data format and what else is read of its parts, then its own, last
    those of :data:`EFFORT`.
    """
    own = {each.name for each in (*measured(), *read_of(*experiment.parts))}
    shared = [name for name in CHANNELS if name in own]
    return (*WHO, *shared, *experiment.columns, *EFFORT)


def write_outcome(
    out: Path, config: Config, facts: dict[str, Any], sensitivities: Sequence[Row]
) -> None:
    """Write a run's ``run.json``, and its ``sensitivity.csv`` if there are derivatives.

    Args:
        out: folder of the run.
        config: configuration of the run.
        facts: facts about the run, for ``run.json``.
        sensitivities: one row for each reading and parameter.
    """
    if sensitivities:
        with (out / "sensitivity.csv").open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, list(sensitivities[0]), lineterminator="\n")
            table.writeheader()
            for row in sensitivities:
                table.writerow({name: _digits(value) for name, value in row.items()})
    record.write(out / "run.json", config, facts)


class Recorder:
    """Writes ``result.csv`` and ``.toml``, ``run.json`` and ``fields.pvd`` as the run goes.

    An interrupted run keeps the rows and fields that it has written, and a ``run.json`` that says
    how to repeat it.

    Raises:
        ConfigError: on every rank, where the folder cannot be written.
    """

    def __init__(
        self, out: Path, experiment: Experiment, config: Config, model: Model, profile: Profile
    ) -> None:
        self._out = out
        self._config = config
        self._comm = model.comm
        self._profile = profile
        self._file = on_root(self._comm, lambda: self._open(experiment))
        self._fields = FieldFile(model, out / "fields.pvd")

    def _open(self, experiment: Experiment) -> Any:
        try:
            self._out.mkdir(parents=True, exist_ok=True)
            known = {"experiment": experiment.name, "complete": False}
            record.write(self._out / "run.json", self._config, known)
            described = tomlkit.dumps(experiment.described(self._config))
            (self._out / "result.toml").write_text(described, encoding="utf-8")
            file = (self._out / "result.csv").open("w", encoding="utf-8", newline="")
        except OSError as error:
            raise ConfigError(f"--out {self._out}: {error.strerror}") from None
        self._table = csv.DictWriter(file, columns(experiment), lineterminator="\n")
        self._table.writeheader()
        return file

    def __enter__(self) -> Recorder:
        return self

    def append(self, row: Row) -> None:
        """Write one row and its fields."""
        with self._profile.phase("output"):
            self._fields.write(row["time_s"])
            if self._file is not None:
                self._table.writerow({k: _digits(v) for k, v in row.items() if not _empty(v)})
                self._file.flush()

    def finish(self, facts: dict[str, Any], sensitivities: Sequence[Row] = ()) -> None:
        """Complete ``run.json``; write ``sensitivity.csv`` if there are derivatives."""
        if self._comm.rank == 0:
            write_outcome(self._out, self._config, facts, sensitivities)

    def __exit__(self, *_: object) -> None:
        self._fields.close()
        if self._file is not None:
            self._file.close()


def _empty(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _digits(value: Any) -> Any:
    """A float with ten significant digits; further digits are below the solver's tolerance."""
    return f"{value:.10g}" if isinstance(value, float) else value
