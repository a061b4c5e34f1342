"""A small design loop for the demo: coarse mesh, 30 designs, surrogate, front, one choice."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import typer

from dolfingrip import config as configuration
from dolfingrip.cli import doe_commands, optimise_command, train_command
from dolfingrip.cli.reproduce_command import step
from dolfingrip.config import Config
from dolfingrip.files import whole


@dataclass(frozen=True, slots=True)
class LoopPolicy:
    """The size of the small loop.

    Attributes:
        size_mm: size of the elements, coarser than the default: the demo shows the loop, not exact
            figures.
        longest_step_kPa: the only reading is at the highest pressure, so long load steps cost
            least.
        cog_max_mm: largest offset of the centre of gravity.
    """

    size_mm: float = 10.0
    longest_step_kPa: float = 100.0
    cog_max_mm: float = 3.0


POLICY: Final = LoopPolicy()


DESIGNS = ("morph.xi1=-0.2:1:6", "morph.xi2=-0.5:1:5")
"""30 designs in the paper's range."""


def settings(config: Config, policy: LoopPolicy = POLICY) -> Config:
    """``config`` with a coarse mesh and one reading, at its highest pressure."""
    data = config.model_dump(mode="json")
    size = max(policy.size_mm, config.mesh.size_mm or 0.0)
    data["mesh"] |= {"size_mm": size, "edge_size_mm": size, "target_elements": None}
    data["experiment"]["step_kPa"] = config.experiment.max_pressure_kPa
    data["solver"]["max_step_kPa"] = max(policy.longest_step_kPa, config.solver.max_step_kPa)
    return configuration.from_dict(data)


def run(
    config: Config,
    out: Path,
    designs: Sequence[str] = DESIGNS,
    policy: LoopPolicy = POLICY,
) -> None:
    """Run doe, train and optimise in folders of their own under ``out``; each resumes its work.

    Args:
        config: configuration of the finger; :func:`settings` coarsens its mesh and readings.
        out: folder, which is made if it is missing.
        designs: ``KEY=LOW:HIGH:COUNT`` for each parameter.
        policy: size of the loop.

    Raises:
        typer.Exit: with code 1, if a chosen design failed or none could be chosen.
    """
    file = out / "config.toml"
    whole.write(file, configuration.dumps(settings(config, policy)))
    doe, surrogate, optimum = out / "doe", out / "surrogate", out / "optimum"
    workers = f"--workers={len(os.sched_getaffinity(0))}"
    varied = [f"--parameter={each}" for each in designs]
    step(doe_commands.doe, "--out", doe, workers, "--config", file, *varied)
    step(train_command.train, doe, "--out", surrogate)
    search = (
        "--population=200",
        "--generations=60",
        "--along=0",
        f"--cog-max={policy.cog_max_mm:g}",
    )
    if step(optimise_command.optimise, surrogate, "--out", optimum, workers, *search):
        raise typer.Exit(1)
