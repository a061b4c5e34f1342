"""A synthetic measurement: a simulation with hidden effects, nuisances and noise."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.channels import WHO, at_marker, measured, of_line
from dolfingrip.config import Config, ConfigError, checked
from dolfingrip.experiments.index import find
from dolfingrip.experiments.loop import run
from dolfingrip.experiments.results.readings import Row
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.files import table, whole
from dolfingrip.files.run import RunFailure
from dolfingrip.mechanics.model.compilation import Tell
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.mechanics.path.failure import Failure
from dolfingrip.parameter.search import scaled_priors

MEASURED = (*WHO, *(each.name for each in measured() if each.synthetic))
"""The columns of a synthetic measurement."""

NOISE: Mapping[str, float] = {each.name: each.noise for each in measured() if each.noise}
"""Standard deviation of each column's noise, for an ordinary camera, load cell and regulator.
Markers have that of their channels."""

TRIES = 1000
"""Largest number of draws from a prior until one is an allowed value."""


@dataclass(slots=True)
class SyntheticMeasurement:
    """A synthetic measurement, and the truth that is hidden in it.

    Attributes:
        kinds: names of its experiments.
        config: set-up that the laboratory believes in.
        truth: set-up that was simulated, with hidden effects and drawn nuisances.
        rows: readings with noise, by column.
        noise: standard deviation of the noise of each column that was read.
        failures: failures of experiments that ended early.
    """

    kinds: Sequence[str]
    config: Config
    truth: Config
    rows: list[Row]
    noise: Mapping[str, float]
    failures: list[Failure | RunFailure]


def check_noise(noise: Mapping[str, Any]) -> None:
    """Check standard deviations by column.

    Args:
        noise: values by column.

    Raises:
        ConfigError: one line naming the column, the value and what is allowed.
    """
    for name, std in noise.items():
        if name not in NOISE and at_marker(name) is None:
            raise ConfigError(f"--noise {name} = {std}: allowed: {', '.join(NOISE)}")
        number = isinstance(std, int | float) and not isinstance(std, bool)
        if not number or not 0 <= std < math.inf:
            raise ConfigError(f"--noise {name} = {std}: allowed: a number from 0 on")


def drawn(config: Config, names: Iterable[str], rng: np.random.Generator) -> Config:
    """Switch effects on, with parameters drawn from their priors.

    Args:
        config: to which they are added.
        names: of the effects.
        rng: source of random numbers.

    Raises:
        ConfigError: one line, if there is no such effect.
    """
    by_name = {effect.name(): effect for effect in EFFECTS}
    names = set(names)
    unknown = sorted(names - set(by_name))
    if unknown:
        raise ConfigError(f"--nuisance {unknown[0]}: no effect; allowed: {', '.join(by_name)}")
    for name, effect in by_name.items():  # in the index' order, whatever the order of the names
        if name in names:
            config = config.changed(
                extensions={name: _values(effect, config.material.shear_MPa, rng)}
            )
    return config


def _values(effect: type[Effect], shear_MPa: float, rng: np.random.Generator) -> dict[str, Any]:
    """Parameters of ``effect``, drawn from their priors until they are allowed values."""
    for _ in range(TRIES):
        values: dict[str, Any] = {}
        for key, prior in scaled_priors(effect, shear_MPa).items():
            value = prior.at(float(rng.standard_normal()))
            is_list = isinstance(effect.model_fields[key].default, tuple)
            values[key] = [value] if is_list else value
        try:
            checked(effect, values)
        except ConfigError:
            continue
        return values
    raise ConfigError(f"--nuisance {effect.name()}: its priors allow no values")


def measure(
    kinds: Sequence[str],
    config: Config,
    *,
    hidden: Config | None = None,
    nuisances: Iterable[str] = (),
    noise: Mapping[str, float] = NOISE,
    seed: int = 0,
    comm: MPI.Comm = MPI.COMM_WORLD,
    progress: Callable[[Row], None] = lambda row: None,
    tell: Tell | None = None,
) -> SyntheticMeasurement:
    """Simulate experiments and read them with the noise of instruments.

    Args:
        kinds: names of the experiments, in the order of the table.
        config: set-up that the laboratory believes in.
        hidden: set-up that is true instead; default: ``config``.
        nuisances: effects that are added, with parameters drawn from their priors.
        noise: standard deviation of each column's noise, in the column's unit.
        seed: seed of the nuisances' draws and of the noise.
        comm: ranks to run on.
        progress: called with each new row, before noise is added.
        tell: called with lines about what takes long; see :func:`~dolfingrip.experiments.run`.
    """
    rng = np.random.default_rng(seed)
    truth = drawn(hidden or config, nuisances, rng)
    markers = of_line(config.camera.markers, curve=False)
    columns = (*MEASURED, *(channel.name for channel in markers))
    noise = {**{channel.name: channel.noise for channel in markers if noise}, **noise}
    rows: list[Row] = []
    failures = []
    for kind in kinds:
        result = run(kind, truth, comm=comm, progress=progress, tell=tell)
        if result.failure is not None:
            failures.append(result.failure)
        for row in result.rows:
            read = {name: row[name] for name in columns if name in row}
            read["specimen"] = "synthetic"
            for name, spread in noise.items():
                if name in read:
                    read[name] += rng.normal(0.0, spread)
            rows.append(read)
    present = {name: noise[name] for name in noise if any(name in row for row in rows)}
    return SyntheticMeasurement(tuple(kinds), config, truth, rows, present, failures)


def write(measurement: SyntheticMeasurement, out: Path, comm: MPI.Comm = MPI.COMM_WORLD) -> None:
    """Write ``measured.csv`` and ``.toml``, and the hidden truth to ``truth.toml``.

    Args:
        measurement: that is written.
        out: folder of the files.
        comm: ranks, the first of which writes.

    Raises:
        WriteError: on every rank, one line.
    """

    def work() -> None:
        every = dict.fromkeys((*MEASURED, *(name for row in measurement.rows for name in row)))
        names = [name for name in every if any(name in row for row in measurement.rows)]
        rows = [
            {k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()}
            for row in measurement.rows
        ]
        table.write(out / "measured.csv", rows, names)
        whole.write(out / "measured.toml", _described(measurement))
        whole.write(out / "truth.toml", configuration.dumps(measurement.truth))

    on_root(comm, work)


def _described(measurement: SyntheticMeasurement) -> str:
    data: dict[str, Any] = {"experiment": "", "note": "synthetic, by dolfingrip synthetic"}
    for kind in measurement.kinds:
        data |= find(kind).described(measurement.config)
    if len(measurement.kinds) > 1:
        data["experiment"] = list(measurement.kinds)
    data["noise"] = dict(measurement.noise)
    return tomlkit.dumps(data)
