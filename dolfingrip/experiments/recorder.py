"""The files that a run writes into its folder, row by row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import tomlkit

from dolfingrip import channels
from dolfingrip.config import Config
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.results import record
from dolfingrip.experiments.results.fields import FieldFile
from dolfingrip.experiments.results.readings import Row
from dolfingrip.experiments.results.sensitivity_table import FILE, SensitivityTable
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.files import table, whole
from dolfingrip.files.run import RunFailure, RunFile
from dolfingrip.files.whole import GrowingFile
from dolfingrip.jobs.interrupts import Interrupted, interrupt_behind
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.sections.supply import AirLine

EFFORT = {
    "iterations": "Newton iterations since the reading before",
    "load_steps": "steps of the load since the reading before",
}
"""Columns that tell the solver's effort, and what they mean."""


def columns(
    experiment: Experiment,
    cavities: Sequence[str] = (),
    config: Config | None = None,
    banded: Sequence[str] = (),
) -> tuple[str, ...]:
    """Return the columns of an experiment's ``result.csv``.

    The columns of the format of measured data come first, then further readings of the parts, then
    the experiment's own columns, those of :data:`EFFORT`, and last the ends of bands.

    Args:
        experiment: whose columns they are.
        cavities: of the mesh; several have columns of their own.
        config: of the run, which may ask for places along the back, and have an obstacle; None:
            it has neither.
        banded: columns that have a band.
    """
    names = cavities if len(cavities) > 1 else ()
    several = [c.name for name in names for c in channels.of_cavity(name)]
    if config is not None and "finger" in experiment.parts:
        several += [channels.supply_of(name).name for name in config.cavity.own]
        line = channels.of_line(config.camera.markers, curve=config.curve is not None)
        pressed = () if config.obstacle is None else channels.OBSTACLE
        moving = channels.ENERGIES if config.experiment.dynamic else ()
        several += [c.name for c in (*line, *pressed, *moving)]
    instrumental = {c.name for c in (*channels.measured(), *channels.read_of(*experiment.parts))}
    shared = [name for name in channels.CHANNELS if name in instrumental]
    if config is not None and config.supply is not None and AirLine.felt_on(experiment.parts):
        of_air = (c.name for c in (channels.CAVITY_PRESSURE, *channels.AIR_SUPPLY))
        several += [name for name in of_air if name not in instrumental]
    ends = (end for name in banded for end in channels.of_band(name))
    return (*channels.WHO, *shared, *(c.name for c in experiment.columns), *several, *EFFORT, *ends)


def described(experiment: Experiment) -> list[tuple[str, str]]:
    """Return the columns of a ``result.csv`` that can have entries, each with its meaning.

    Args:
        experiment: whose columns they are.
    """
    of_parts = channels.read_of(*experiment.parts)
    columns_of = (experiment.control, channels.TIME, channels.PRESSURE, *of_parts)
    about = {
        channel.name: channel.about or channel.title
        for channel in (*columns_of, *experiment.columns)
    }
    meanings = {**channels.WORDS, **about, **EFFORT}
    return [(name, meanings[name]) for name in columns(experiment) if name in meanings]


def write_outcome(out: Path, facts: RunFile, sensitivities: SensitivityTable) -> None:
    """Write a run's ``run.json``, and its ``sensitivity.csv`` if there are derivatives.

    Args:
        out: folder of the run.
        facts: facts about the run.
        sensitivities: derivatives of its readings.
    """
    if sensitivities:
        rows = [{name: digits(value) for name, value in entry.items()} for entry in sensitivities]
        table.write(out / FILE, rows)
    facts.write(out)


class Recorder:
    """Writes ``result.csv`` and ``.toml``, ``run.json`` and ``fields.pvd`` as the run goes.

    A run that is interrupted, or ends by an error, keeps its rows and fields so far, and a
    ``run.json`` that says how it ended and how to repeat it.

    Args:
        out: folder for the files.
        experiment: that is run.
        config: of the run.
        rig: whose fields are written.
        profile: takes the time of the output.
        columns: of ``result.csv``.

    Raises:
        WriteError: on every rank, if a file cannot be written.
    """

    def __init__(
        self,
        out: Path,
        experiment: Experiment,
        config: Config,
        rig: Rig,
        profile: Profile,
        columns: Sequence[str],
    ) -> None:
        self._out = out
        self._config = config
        model = rig.newton.model
        self._comm = model.comm
        self._profile = profile
        self._experiment = experiment
        self._rows = 0
        self._last: Row = {}
        self._finished = False
        self._columns = columns
        self._file = on_root(self._comm, self._open)
        self._fields = FieldFile(model, out / "fields.pvd", rig.pressures)

    def _open(self) -> GrowingFile:
        self._write_incomplete(None)
        described = tomlkit.dumps(self._experiment.described(self._config))
        whole.write(self._out / "result.toml", described)
        return GrowingFile(self._out / "result.csv", ",".join(self._columns) + "\n")

    def _write_incomplete(self, failure: RunFailure | None) -> None:
        """Write the ``run.json`` of a run that has not come to its end.

        Args:
            failure: why it ended; None while it goes on.
        """
        record.run_file(self._config, self._experiment.name, failure=failure).write(self._out)

    def __enter__(self) -> Recorder:
        return self

    def append(self, row: Row) -> None:
        """Write one row and its fields."""
        with self._profile.phase("output"):
            self._fields.write(row["time_s"])
            on_root(self._comm, lambda: self._append(row))
        self._rows, self._last = self._rows + 1, row

    def _append(self, row: Row) -> None:
        assert self._file is not None
        shown = {
            k: digits(v) for k, v in row.items() if not (isinstance(v, float) and math.isnan(v))
        }
        self._file.append(table.lines([shown], self._columns))

    def finish(self, facts: RunFile, sensitivities: SensitivityTable) -> None:
        """Complete ``run.json``; write ``sensitivity.csv`` if there are derivatives."""
        on_root(self._comm, lambda: write_outcome(self._out, facts, sensitivities))
        self._finished = True

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: object
    ) -> None:
        """Close the files.

        Raises:
            Interrupted: in place of an interrupt, with what is kept.
        """
        if self._file is not None:
            self._file.close()
        if error is None or self._finished:
            return
        interrupted = interrupt_behind(error) is not None
        sentence = self._kept() if interrupted else f"{type(error).__name__}: {error}"
        if self._comm.rank == 0:
            controls = (self._experiment.control.name, channels.TIME.name)
            failure = RunFailure(
                kind="interrupted" if interrupted else "error",
                last_good={name: self._last[name] for name in controls if name in self._last},
                said=sentence,
            )
            with suppress(whole.WriteError):  # which may be the error that ends the run
                self._write_incomplete(failure)
        if interrupted:
            raise Interrupted(sentence) from error

    def _kept(self) -> str:
        """One line: what an interrupted run has kept, and how to go on."""
        control = self._experiment.control
        reached = f", up to {self._last[control.name]:g} {control.symbol}," if self._last else ""
        return (
            f"{self._rows} readings{reached} are kept in {self._out}; "
            "the same command starts from the beginning"
        )


def digits(value: Any) -> Any:
    """A float with ten significant digits, more than the solver's tolerance; zero has no sign."""
    return f"{value:z.10g}" if isinstance(value, float) else value
