"""The result of an experiment, read from its folder."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dolfingrip import config as configuration
from dolfingrip.channels import Channel
from dolfingrip.experiments import chart
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.result import TABLE, Result
from dolfingrip.files.result_file import ResultFileError
from dolfingrip.files.table import branches, numbers
from dolfingrip.report.page.content import Source
from dolfingrip.report.page.numbers import said

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """An experiment's result on a page.

    Attributes:
        result: read from its folder.
        experiment: whose result it is.
        title: of the result on the page; titles of a page differ.
    """

    result: Result
    experiment: Experiment
    title: str

    def column(self, name: str) -> Floats | None:
        """A column as numbers, shape (rows,); None if it is missing or empty."""
        return numbers(self.result, name)

    @property
    def folder(self) -> Path:
        """Where its files are."""
        assert self.result.folder is not None
        return self.result.folder

    @property
    def branch(self) -> list[str]:
        """Branch of each row."""
        return [str(name) for name in branches(self.result)]

    @property
    def fields(self) -> Path:
        """The collection of its fields, which may be missing."""
        return self.folder / "fields.pvd"

    @property
    def elements(self) -> int | None:
        """Number of the mesh's elements."""
        return self.result.facts.mesh.elements or None


def read(folder: Path) -> Run:
    """Read a run.

    Args:
        folder: of the run.

    Returns:
        The run, with its experiment's title.

    Raises:
        ResultFileError: one line, if its files are missing or of something else.
        ConfigError: one line, if this version has no such experiment or configuration.
    """
    result = Result.read(folder)
    if not result.rows:
        raise ResultFileError(f"{folder / TABLE}: no readings; allowed: a run that has some")
    experiment = EXPERIMENTS[result.kind]
    return Run(result, experiment, experiment.title)


def titled(runs: Sequence[Run]) -> list[Run]:
    """The runs with titles that differ: those of one experiment also have their folder's name."""
    named = []
    for run in runs:
        alike = [other for other in runs if other.experiment.name == run.experiment.name]
        title = run.experiment.title
        if len(alike) > 1:
            names = [other.folder.resolve().name for other in alike]
            path = run.folder.resolve()
            same = names.count(path.name) > 1
            title = f"{title}, {path.parent.name}/{path.name}" if same else f"{title}, {path.name}"
        named.append(Run(run.result, run.experiment, title))
    return named


def conditions(run: Run) -> str:
    """One line on what was simulated: specimen, material, mesh, loads."""
    config, control = run.result.config, run.experiment.control
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
        half = " of half the finger" if run.result.facts.mesh.half else ""
        parts.append(f"{run.elements:,} elements{half}".replace(",", " "))
    return " · ".join(parts)


def source(run: Run) -> Source:
    """Where the run comes from, and how it is computed again."""
    facts = run.result.facts
    command = " ".join(map(shlex.quote, facts.command))
    again = (
        f"dolfingrip {run.experiment.command} --config {shlex.quote(str(run.folder / 'run.json'))}"
    )
    lines = [
        ("command", f"dolfingrip {command}" if command else "from Python"),
        ("time", said(facts.wall_s, "s")),
        ("processes", str(facts.ranks or "–")),
        ("system", str(facts.machine.get("system", "–"))),
        *facts.versions.items(),
    ]
    return Source(
        run.title, str(run.folder), again, lines,
        [("Resolved configuration", configuration.dumps(run.result.config))],
    )  # fmt: skip


def over(run: Run) -> Channel:
    """The channel of the horizontal axis of a run.

    Args:
        run: whose curves are drawn.

    Returns:
        That of its charts (:func:`dolfingrip.experiments.chart.over`).
    """
    return chart.over(run.experiment, run.result)
