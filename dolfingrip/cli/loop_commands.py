"""``dolfingrip reproduce``: the paper's design loop; and the small loop of the demo."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import typer
from mpi4py import MPI
from rich.box import SIMPLE_HEAD
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.channels import FORCE
from dolfingrip.cli import doe_commands, optimise_command, study_command, train_command
from dolfingrip.cli.console import (
    check_writable,
    console,
    one_process,
)
from dolfingrip.cli.experiment_commands import exit_early, run_demo
from dolfingrip.cli.report_command import write_report
from dolfingrip.cli.settings import (
    DemoSettings,
    DoeSettings,
    OptimiseSettings,
    ReproduceSettings,
    StudySettings,
    TrainSettings,
)
from dolfingrip.config import Config
from dolfingrip.design.campaign.campaign import read
from dolfingrip.files import whole
from dolfingrip.files.optimum import ChosenDesign, OptimumFile
from dolfingrip.jobs.interrupts import Interrupted
from dolfingrip.mechanics.model.domain import on_root

PAPER = {
    2.5: (0.236, -0.363, -7.7),
    3.0: (0.306, -0.298, 12.9),
    3.5: (0.374, -0.229, 23.5),
}
"""For each COG limit (mm): ξ1, ξ2, and the measured gain of force (%) (the paper's section IV)."""

MEASURED_KPA = 250.0
"""Pressure at which the paper compares forces; its designs were optimised at 300 kPa."""

READ = {"experiment.step_kPa": 50.0}
"""Settings with which the readings include this pressure."""


def reproduce(asked: ReproduceSettings) -> None:
    """Run doe, train, optimise and study as in the paper, and compare with it."""
    one_process("--workers, without mpirun")
    check_writable(asked.out)
    doe, surrogate, optimum = asked.out / "doe", asked.out / "surrogate", asked.out / "optimum"
    changes = {**READ, **asked.overrides}
    run_step(
        doe_commands.doe,
        DoeSettings(
            out=doe, workers=asked.workers, parameter=asked.parameter,
            config=asked.config, overrides=changes,
        ),
    )  # fmt: skip
    run_step(train_command.train, TrainSettings(source=doe, out=surrogate))
    limits = tuple(PAPER)
    choice = OptimiseSettings(
        surrogate=surrogate, out=optimum, workers=asked.workers, cog_max=limits
    )
    failed = run_step(optimise_command.optimise, choice)
    console().print(comparison(optimum))
    if asked.study:
        tried = StudySettings(surrogate=surrogate, out=asked.out / "study", processes=asked.workers)
        failed |= run_step(study_command.study, tried)
    if failed:
        raise typer.Exit(1)


def run_step[S](command: Callable[[S], None], asked: S) -> bool:
    """Run a step of a loop; return whether it told of a failure.

    Args:
        command: work of a command.
        asked: its settings.

    Raises:
        Interrupted: Ctrl-C, with what is kept.
    """
    console().rule(command.__name__)
    try:
        command(asked)
    except typer.Exit as ending:
        return bool(ending.exit_code)
    except KeyboardInterrupt:
        raise Interrupted(
            "what was computed is kept; the same command goes on from there"
        ) from None
    return False


def comparison(optimum: Path) -> Table:
    """A table of an optimisation's chosen designs and the paper's, a row for each COG limit."""
    designs = OptimumFile.read(optimum).designs
    forces = _forces_N(optimum / "fem")
    original = _force(forces, "original", None, designs)
    table = Table(title="Chosen designs and the paper's", box=SIMPLE_HEAD, padding=(0, 1))
    gain = f"gain at\n{MEASURED_KPA:g} kPa, %"
    for heading in ("COG ≤\nmm", "ξ₁", "paper", "ξ₂", "paper", gain, "paper,\nmeasured"):
        table.add_column(heading, justify="right")
    for one in designs:
        if one.role != "chosen" or one.limit is None:
            continue
        limit = one.limit
        xi1, xi2 = one.inputs.values()
        force = _force(forces, "chosen", limit, designs)
        ours = "–" if math.isnan(force / original) else f"{100 * (force / original - 1):+z.1f}"
        theirs = PAPER[limit]
        table.add_row(
            f"{limit:g}",
            f"{xi1:z.3f}",
            f"{theirs[0]:.3f}",
            f"{xi2:z.3f}",
            f"{theirs[1]:.3f}",
            ours,
            f"{theirs[2]:+.1f}",
        )
    return table


Forces = dict[tuple[float, ...], float]


def _forces_N(campaign: Path) -> Forces:
    """Blocked force (N) at the paper's pressure by inputs, for the designs that reached it."""

    found = {}
    for row in read(campaign).rows:
        curve = row["curve"] or {}
        pressures = curve.get("blocked_pressure_kPa")
        if row["status"] != "done" or pressures is None:
            continue
        for pressure, force in zip(pressures, curve[FORCE.name], strict=True):
            if math.isclose(pressure, MEASURED_KPA):
                found[tuple(row["inputs"].values())] = force
    return found


def _force(
    forces: Forces, role: str, limit: float | None, designs: Sequence[ChosenDesign]
) -> float:
    """Force (N) of the design with this role; NaN if it is not known."""
    for one in designs:
        if one.role == role and one.limit == limit:
            return forces.get(tuple(one.inputs.values()), math.nan)
    return math.nan


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


def coarsened(config: Config, policy: LoopPolicy = POLICY) -> Config:
    """Return ``config`` with a coarse mesh and one reading, at its highest pressure."""
    data = config.model_dump(mode="json")
    size = max(policy.size_mm, config.mesh.size_mm or 0.0)
    data["mesh"] |= {"size_mm": size, "edge_size_mm": size, "target_elements": None}
    data["experiment"]["step_kPa"] = config.experiment.max_pressure_kPa
    data["solver"]["max_step_kPa"] = max(policy.longest_step_kPa, config.solver.max_step_kPa)
    return configuration.from_dict(data)


def run_small_loop(
    config: Config,
    out: Path,
    designs: Sequence[str] = DESIGNS,
    policy: LoopPolicy = POLICY,
) -> None:
    """Run doe, train and optimise in folders of their own under ``out``; each resumes its work.

    Args:
        config: configuration of the finger; :func:`coarsened` coarsens its mesh and readings.
        out: folder, which is made if it is missing.
        designs: ``KEY=LOW:HIGH:COUNT`` for each parameter.
        policy: size of the loop.

    Raises:
        typer.Exit: with code 1, if a chosen design failed or none could be chosen.
    """
    file = out / "config.toml"
    whole.write(file, configuration.dumps(coarsened(config, policy)))
    doe, surrogate, optimum = out / "doe", out / "surrogate", out / "optimum"
    workers = len(os.sched_getaffinity(0))
    run_step(
        doe_commands.doe,
        DoeSettings(out=doe, workers=workers, config=file, parameter=tuple(designs)),
    )
    run_step(train_command.train, TrainSettings(source=doe, out=surrogate))
    choice = OptimiseSettings(
        surrogate=surrogate, out=optimum, workers=workers, population=200, generations=60,
        along=0, cog_max=(policy.cog_max_mm,),
    )  # fmt: skip
    if run_step(optimise_command.optimise, choice):
        raise typer.Exit(1)


def demo(asked: DemoSettings) -> None:
    """Run both experiments on the reference finger and a small design loop, write a report."""
    resolved = configuration.load(asked.config, asked.overrides)
    screen = console()
    results = run_demo(resolved, asked.out, screen)
    if asked.loop and MPI.COMM_WORLD.size > 1:
        screen.print("no design loop under mpirun: it starts processes of its own")
    elif asked.loop:
        run_small_loop(resolved, asked.out / "loop")

    def work() -> None:
        with screen.status("writing the report"):
            page = write_report([asked.out], asked.out / "report.html")
        screen.say(f"report: {page}")

    on_root(MPI.COMM_WORLD, work)
    exit_early(*results)
