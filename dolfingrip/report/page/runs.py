"""The result of an experiment, read from its folder."""

from __future__ import annotations

import csv
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dolfingrip import config as configuration
from dolfingrip.channels import CHANNELS, PRESSURE
from dolfingrip.config import Config
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.report.columns import branches, numbers
from dolfingrip.report.page.content import Source
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.sources import read_json
from dolfingrip.sections.errors import ConfigError

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """An experiment's result.

    Attributes:
        folder: where its files are.
        experiment: whose result it is.
        facts: content of ``run.json``.
        table: columns of ``result.csv``, as text.
        title: of the result on the page; titles of a page differ.
    """

    folder: Path
    experiment: Experiment
    facts: Mapping[str, Any]
    table: Mapping[str, Sequence[str]]
    title: str

    @cached_property
    def config(self) -> Config:
        """The configuration of the run."""
        return configuration.from_dict(dict(self.facts.get("config", {})))

    def column(self, name: str) -> Floats | None:
        """A column as numbers, shape (rows,); None if it is missing or empty."""
        return numbers(self.table, name)

    @property
    def rows(self) -> int:
        """Number of readings."""
        return len(next(iter(self.table.values()), ()))

    @property
    def branch(self) -> list[str]:
        """Branch of each row."""
        return [str(each) for each in branches(self.table)]

    @property
    def fields(self) -> Path:
        """The collection of its fields, which may be missing."""
        return self.folder / "fields.pvd"

    @property
    def elements(self) -> int | None:
        """Number of the mesh's elements."""
        found = self.facts.get("mesh", {}).get("elements")
        return int(found) if found else None


def read(folder: Path) -> Run:
    """Read a run.

    Raises:
        ConfigError: one line, if its files are missing or of something else.
    """
    facts = read_json(folder / "run.json")
    name = str(facts.get("experiment"))
    if name not in EXPERIMENTS:
        allowed = ", ".join(EXPERIMENTS)
        raise ConfigError(f"{folder / 'run.json'}: experiment {name}; allowed: {allowed}")
    file = folder / "result.csv"
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            lines = [row for row in csv.reader(stream) if row]
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None
    if len(lines) < 2:
        raise ConfigError(f"{file}: no readings; allowed: a run that has some")
    table = {name: [row[i] for row in lines[1:]] for i, name in enumerate(lines[0])}
    experiment = EXPERIMENTS[name]
    return Run(folder, experiment, facts, table, experiment.title)


def titled(runs: Sequence[Run]) -> list[Run]:
    """The runs with titles that differ: those of one experiment also have their folder's name."""
    found = []
    for run in runs:
        alike = [each for each in runs if each.experiment.name == run.experiment.name]
        title = run.experiment.title
        if len(alike) > 1:
            names = [each.folder.resolve().name for each in alike]
            own = run.folder.resolve()
            same = names.count(own.name) > 1
            title = f"{title}, {own.parent.name}/{own.name}" if same else f"{title}, {own.name}"
        found.append(Run(run.folder, run.experiment, run.facts, run.table, title))
    return found


def conditions(run: Run) -> str:
    """What was simulated, in one line: specimen, material, mesh, loads."""
    config, control = run.config, run.experiment.control
    parts = []
    if "finger" in run.experiment.parts or run.experiment.name == "grasp":
        parts.append(f"{config.finger.kind} finger")
    material = config.material
    name = material.law
    parts.append(f"{name}, μ = {said(material.shear_MPa, 'MPa')}")
    effects = sorted(config.extensions.model_fields_set)
    parts += [f"effect {name.replace('_', ' ')}" for name in effects]
    values = run.column(control.name)
    if values is not None:
        parts.append(f"{said(np.nanmin(values))} to {said(np.nanmax(values), control.symbol)}")
    if run.elements:
        half = " of half the finger" if run.facts["mesh"].get("half") else ""
        parts.append(f"{run.elements:,} elements{half}".replace(",", " "))
    return " · ".join(parts)


def source(run: Run) -> Source:
    """Where the run comes from, and how it is computed again."""
    facts = run.facts
    command = " ".join(shlex.quote(str(each)) for each in facts.get("command", ()))
    again = (
        f"dolfingrip {run.experiment.command} --config {shlex.quote(str(run.folder / 'run.json'))}"
    )
    machine = facts.get("machine", {})
    lines = [
        ("command", f"dolfingrip {command}" if command else "from Python"),
        ("time", said(facts.get("wall_s"), "s")),
        ("processes", str(facts.get("ranks", "–"))),
        ("system", str(machine.get("system", "–"))),
        *((name, str(version)) for name, version in facts.get("versions", {}).items()),
    ]
    return Source(
        run.title, str(run.folder), again, lines,
        [("Resolved configuration", configuration.dumps(run.config))],
    )  # fmt: skip


def over(run: Run) -> str:
    """Column of the horizontal axis: that of the experiment's plot."""
    name = run.experiment.plot.over.name
    return name if run.column(name) is not None else PRESSURE.name


def known(name: str) -> str:
    """A column in words with its unit."""
    return CHANNELS[name].label if name in CHANNELS else name
