"""``dolfingrip reproduce``: the design loop of a study file; and the small loop of the demo."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import typer
from mpi4py import MPI
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.cli import doe_commands, settings, surrogate_commands
from dolfingrip.cli.console import console, one_process
from dolfingrip.cli.experiment_commands import exit_early, run_demo
from dolfingrip.cli.installation import missing, need
from dolfingrip.cli.report_command import write_report
from dolfingrip.config import Config
from dolfingrip.design.campaign import campaign
from dolfingrip.design.optimum import study_file
from dolfingrip.design.optimum.study_file import Published
from dolfingrip.files import whole
from dolfingrip.files.optimum import ChosenDesign, OptimumFile
from dolfingrip.jobs.interrupts import Interrupted
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.report.design import label
from dolfingrip.report.table import of_rows
from dolfingrip.sections import tables


def reproduce(args: settings.ReproduceSettings) -> None:
    """Run doe, train, optimise and study as a file says, and compare with published designs."""
    one_process("--workers, without mpirun")
    need("torch")  # of the step after the campaign, which takes hours
    study = study_file.read(args.file)
    limited, improved = study.front.objectives()
    names = (limited.title, improved.title)
    doe, surrogate, optimum = args.out / "doe", args.out / "surrogate", args.out / "optimum"
    run_step(
        doe_commands.doe,
        settings.DoeSettings(
            out=doe, workers=args.workers, parameter=args.parameter or study.parameters,
            quantity=names, config=args.config or study.config,
            overrides={**tables.assignments(study.set, "set"), **args.overrides},
        ),
    )  # fmt: skip
    run_step(
        surrogate_commands.train, settings.TrainSettings(source=doe, out=surrogate, outputs=names)
    )
    front = study.front
    choice = settings.OptimiseSettings(
        surrogate=surrogate, out=optimum, workers=args.workers, against=front.against,
        at_most=front.at_most, at_least=front.at_least, maximise=front.maximise,
        minimise=front.minimise, also=() if study.published is None else (study.published.gain_of,),
    )  # fmt: skip
    failed = run_step(surrogate_commands.optimise, choice)
    if study.published is not None:
        console().print(comparison(OptimumFile.read(optimum), study.published))
    if args.study and study.hyperparameters is not None:
        limit = (study.hyperparameters.limit,)
        tried = settings.StudySettings(
            surrogate=surrogate, out=args.out / "study", processes=args.workers,
            against=front.against, maximise=front.maximise, minimise=front.minimise,
            at_most=() if front.at_least else limit, at_least=limit if front.at_least else (),
        )  # fmt: skip
        failed |= run_step(surrogate_commands.study, tried)
    if failed:
        raise typer.Exit(1)


def run_step[S](command: Callable[[S], None], args: S) -> bool:
    """Run a step of a loop; return whether it told of a failure.

    Args:
        command: work of a command.
        args: its settings.

    Raises:
        Interrupted: Ctrl-C, with what is kept.
    """
    console().rule(command.__name__)
    try:
        command(args)
    except typer.Exit as ending:
        return bool(ending.exit_code)
    except KeyboardInterrupt:
        raise Interrupted(
            "what was computed is kept; the same command goes on from there"
        ) from None
    return False


def comparison(optimum: OptimumFile, published: Published) -> Table:
    """Compare chosen designs with published ones, a row for each limit."""
    limited, _ = optimum.objectives
    roles = {(one.role, one.limit): one for one in optimum.designs}
    original = _number(roles.get(("original", None)), published.gain_of)
    inputs = [label(name) for name in (optimum.designs[0].inputs if optimum.designs else ())]
    headings = [
        f"{limited.title} {limited.sense}",
        *(part for name in inputs for part in (name, "published")),
        f"gain of {published.gain_of}, %",
        "published, measured",
    ]
    rows = []
    for theirs in published.designs:
        one = roles.get(("chosen", theirs.limit))
        if one is None:
            continue
        ours = _number(one, published.gain_of) / original - 1
        pairs = zip(one.inputs.values(), theirs.inputs, strict=True)
        row = [
            f"{theirs.limit:g}",
            *(text for computed, other in pairs for text in (f"{computed:z.3f}", f"{other:.3f}")),
            "–" if math.isnan(ours) else f"{100 * ours:+z.1f}",
            f"{theirs.gain_percent:+.1f}",
        ]
        rows.append(row)
    return of_rows(headings, rows, "Chosen designs and published ones")


def _number(design: ChosenDesign | None, name: str) -> float:
    """A quantity of a design by finite elements; NaN where it is not known."""
    return math.nan if design is None or design.fem is None else design.fem.get(name, math.nan)


@dataclass(frozen=True, slots=True)
class LoopPolicy:
    """The size of the small loop.

    Attributes:
        size_mm: size of the elements, coarser than the default: the demo shows the loop, not exact
            figures.
        longest_step_kPa: the only reading is at the highest pressure, so long load steps cost
            least.
        largest_offset_mm: of the centre of gravity.
    """

    size_mm: float = 10.0
    longest_step_kPa: float = 100.0
    largest_offset_mm: float = 3.0


POLICY: Final = LoopPolicy()


DESIGNS = ("morph.xi1=-0.2:1:6", "morph.xi2=-0.5:1:5")
"""30 designs in the paper's range."""


def coarsened(config: Config, policy: LoopPolicy = POLICY) -> Config:
    """Return ``config`` with a coarse mesh and one reading, at its highest pressure."""
    size = max(policy.size_mm, config.mesh.size_mm or 0.0)
    mesh = {"size_mm": size, "edge_size_mm": size, "target_elements": None}
    return config.changed(
        mesh={} if config.mesh.file else mesh,
        experiment={"step_kPa": config.experiment.largest_kPa},
        solver={"max_step_kPa": max(policy.longest_step_kPa, config.solver.max_step_kPa)},
    )


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
        settings.DoeSettings(out=doe, workers=workers, config=file, parameter=tuple(designs)),
    )
    run_step(surrogate_commands.train, settings.TrainSettings(source=doe, out=surrogate))
    choice = settings.OptimiseSettings(
        surrogate=surrogate, out=optimum, workers=workers, population=200, generations=60,
        along=0, at_most=(policy.largest_offset_mm,),
    )  # fmt: skip
    if run_step(surrogate_commands.optimise, choice):
        raise typer.Exit(1)


def demo(args: settings.DemoSettings) -> None:
    """Run both experiments on the reference finger and a small design loop, write a report."""
    resolved = configuration.load(args.config, args.overrides)
    screen = console()
    if args.loop:  # an older campaign of other settings is refused before minutes of solving
        designs = doe_commands.planned(settings.DoeSettings(parameter=DESIGNS), coarsened(resolved))
        campaign.check(designs, args.out / "loop" / "doe")
    alone = MPI.COMM_WORLD.size == 1
    lacking = missing("torch") if alone else "under mpirun it cannot start processes"
    if args.loop and lacking:
        screen.say(f"no design loop: {lacking}")
    results = run_demo(resolved, args.out, screen)
    if args.loop and not lacking:
        run_small_loop(resolved, args.out / "loop")

    def work() -> None:
        with screen.status("writing the report"):
            page = write_report([args.out], args.out / "report.html")
        screen.say(f"report: {page}")

    on_root(MPI.COMM_WORLD, work)
    exit_early(*results)
