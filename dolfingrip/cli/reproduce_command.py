"""``dolfingrip reproduce``: run the paper's design loop and compare it with the paper's results."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from dolfingrip.channels import FORCE
from dolfingrip.cli import doe_commands, optimise_command, study_command, train_command
from dolfingrip.cli.endings import INTERRUPTED
from dolfingrip.cli.options import (
    ConfigFile,
    Out,
    check_writable,
    console,
    one_process,
)
from dolfingrip.files.optimum import ChosenDesign, OptimumFile
from dolfingrip.jobs.interrupts import Interrupted

PAPER = {
    2.5: (0.236, -0.363, -7.7),
    3.0: (0.306, -0.298, 12.9),
    3.5: (0.374, -0.229, 23.5),
}
"""For each COG limit (mm): ξ1, ξ2, and the measured gain of force (%) (the paper's section IV)."""

MEASURED_KPA = 250.0
"""Pressure at which the paper compares forces; its designs were optimised at 300 kPa."""

READ = ("experiment.step_kPa=50",)
"""Settings with which the readings include this pressure."""


def reproduce(
    out: Out = Path("out/reproduce"),
    workers: Annotated[int, typer.Option(min=1, help="Local processes.")] = 1,
    config: ConfigFile = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", "-s", metavar="KEY=VALUE", help="e.g. mesh.size_mm=4; repeatable."),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=LOW:HIGH:COUNT", help="Default: the paper's 208 designs."),
    ] = None,
    study: Annotated[bool, typer.Option(help="With the study of hyperparameters.")] = True,
) -> None:
    """Run doe, train, optimise and study as in the paper, and compare with it.

    Each step writes into its own folder under OUT and resumes there.
    """
    one_process("--workers, without mpirun")
    check_writable(out)
    doe, surrogate, optimum = out / "doe", out / "surrogate", out / "optimum"
    settings = [f"--set={each}" for each in (*READ, *(overrides or ()))]
    if config is not None:
        settings.append(f"--config={config}")
    varied = [f"--parameter={each}" for each in parameter or ()]
    limits = [f"--cog-max={limit:g}" for limit in PAPER]
    many = f"--workers={workers}"
    step(doe_commands.doe, "--out", doe, many, *settings, *varied)
    step(train_command.train, doe, "--out", surrogate)
    failed = step(optimise_command.optimise, surrogate, "--out", optimum, many, *limits)
    console().print(comparison(optimum))
    if study:
        failed |= step(
            study_command.study, surrogate, "--out", out / "study", f"--processes={workers}"
        )
    if failed:
        raise typer.Exit(1)


def step(function: Any, *arguments: object) -> int:
    """Run a command with its options, as from the command line; its exit code.

    Raises:
        Interrupted: Ctrl-C, which typer turns into an exit code.
    """
    app = typer.Typer(add_completion=False)
    app.command()(function)
    command = typer.main.get_command(app)
    console().rule(function.__name__)
    code = command.main([str(each) for each in arguments], standalone_mode=False)
    if code == INTERRUPTED:
        raise Interrupted("what was computed is kept; the same command goes on from there")
    return int(code or 0)


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
    from dolfingrip.design.campaign.campaign import read

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
