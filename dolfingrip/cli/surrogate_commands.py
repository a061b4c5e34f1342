"""``dolfingrip train``, ``optimise`` and ``study``: a surrogate, its front, NSGA-II's rates."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import typer
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.charts import picture
from dolfingrip.cli import doe_commands, progress
from dolfingrip.cli.console import Screen, console, one_process, resumable
from dolfingrip.cli.settings import OptimiseSettings, StudySettings, TradeOffSettings, TrainSettings
from dolfingrip.config import Change, Config, ConfigError
from dolfingrip.design.campaign.plan import OBJECTIVE
from dolfingrip.design.optimum import optimum
from dolfingrip.design.optimum import study as work
from dolfingrip.design.optimum.pareto import NSGA2Settings
from dolfingrip.design.optimum.study_file import trade_off
from dolfingrip.design.surrogate import surrogate, training
from dolfingrip.design.surrogate import surrogate as network
from dolfingrip.design.surrogate import table as designs
from dolfingrip.design.surrogate.training import GOAL_MSE, Training, TrainingSettings
from dolfingrip.files import table
from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.optimum import ChosenDesign, OptimumFile
from dolfingrip.jobs.cluster import Where
from dolfingrip.report import design as pictures
from dolfingrip.report.design import label, surrogate_front
from dolfingrip.report.table import of_columns, of_rows
from dolfingrip.sections.errors import shown


def train(args: TrainSettings) -> None:
    """Train a neural network on the designs of a campaign."""
    one_process("one process")

    facts = designs.campaign(args.source) or {}
    inputs = args.inputs or tuple(facts.get("parameters", ()))
    outputs = args.outputs or tuple(facts.get("quantities", ()))
    if not inputs or not outputs:
        raise ConfigError("--input, --output: allowed: names of columns with a table")
    data = designs.read(args.source, inputs, outputs)
    settings = TrainingSettings(epochs=args.epochs, seed=args.seed)
    screen = console()
    screen.say(
        f"{len(data)} designs; {data.failed} failed and {data.incomplete} incomplete ones left out"
    )
    if _trained(args.out, data, settings):
        screen.say(f"already trained on this table: {args.out}")
        return
    with progress.shown(screen, "epochs") as show:
        result = training.train(
            data, settings, lambda done: show(done, args.epochs), campaign=facts or None
        )
    _write(result, data, args.out)
    said = result.surrogate.facts
    for part in ("training", "test"):
        mse = getattr(said, f"{part}_mse")
        verdict = "" if mse < GOAL_MSE else f", above the goal of {GOAL_MSE:g}"
        rms = {name: getattr(error, part) for name, error in said.rms_error.items()}
        errors = ", ".join(f"{name} {value:.3g}" for name, value in rms.items())
        count = getattr(said, f"{part}_designs")
        screen.say(f"{part}: {count} designs, MSE {mse:.2e}{verdict}; RMS error {errors}")
    screen.say(f"surrogate: {args.out}")


def _trained(out: Path, data: designs.Table, settings: TrainingSettings) -> bool:
    """True where the folder holds this training's result; its description is written last."""

    try:
        facts = surrogate.load(out).facts
    except ConfigError:
        return False
    same = json.loads(json.dumps(asdict(settings)))
    return facts.table_sha256 == data.sha256() and facts.settings == same


def _write(result: Training, data: designs.Table, out: Path) -> None:

    table.write(out / "learning_curve.csv", result.curve)
    learnt = {name: [sample[name] for sample in result.curve] for name in result.curve[0]}
    chart = pictures.learning_curve(learnt, GOAL_MSE)
    picture.write([chart], out / "learning_curve.png")
    predicted = result.surrogate.predict(data.inputs)
    fits = pictures.fit(data.output_names, data.outputs, predicted, result.test)
    picture.write(fits, out / "fit.png", picture.Look(panel_in=(4.0, 4.0)))
    names = (*data.input_names, *data.output_names)
    guesses = [f"surrogate.{name}" for name in data.output_names]
    numbers = np.hstack([data.inputs, data.outputs, predicted])
    rows = pd.DataFrame(numbers, columns=[*names, *guesses])
    rows["set"] = np.where(result.test, "test", "training")
    table.write(out / "designs.csv", rows.to_dict("records"))
    result.surrogate.save(out)


def optimise(args: OptimiseSettings) -> None:
    """Find the Pareto front by NSGA-II, choose by a limit, compute the choice again."""
    one_process("--workers, without mpirun")

    model = network.load(args.surrogate)
    campaign = model.facts.campaign or {}
    base = _base(campaign, args.config, args.overrides) if args.resolve else None
    computed_by = str(campaign.get("objective", OBJECTIVE))
    foreign = computed_by not in (OBJECTIVE, args.objective)
    if args.resolve and foreign:
        raise ConfigError(
            f"{args.surrogate}: objective = {shown(computed_by)}: no objective of this package; "
            f"allowed: --no-resolve, or --objective {computed_by}, which runs it"
        )
    objectives = objectives_of(args, model.output_names)
    genetic = NSGA2Settings(
        args.population, args.generations, args.crossover, args.mutation, args.seed
    )
    screen = console()
    with progress.shown(screen, "generations") as show:
        optimised = optimum.find(
            model,
            objectives,
            sorted({*args.at_most, *args.at_least}),
            genetic,
            lambda done: show(done, args.generations),
        )
    optimum.write_front(optimised, args.out)
    ends = [optimised.front[0].surrogate, optimised.front[-1].surrogate]
    reach = ", ".join(
        f"{label(goal.title)} {ends[0][goal.title]:z.2f} to {ends[1][goal.title]:z.2f}"
        for goal in objectives
    )
    screen.say(f"front: {len(optimised.front)} points, {reach}")
    if base is not None:
        jobs = progress.jobs(screen, "designs", progress.FEW)
        with resumable(screen, args.out / "fem"), jobs as advance:
            evaluate = optimum.evaluator(
                base,
                (*model.output_names, *args.also),
                args.out / "fem",
                Where(workers=args.workers),
                progress=advance,
                objective=computed_by,
            )
            optimised = optimum.resolve(optimised, args.along, evaluate)
    optimum.write(optimised, args.out)
    learnt = model.facts.designs(args.surrogate)
    chart = surrogate_front(optimised, model.facts.failed_designs, learnt)
    picture.write([chart], args.out / "pareto.png", picture.Look(across=1, key="above"))
    _print(optimised, screen)
    screen.say(f"results: {args.out}")
    if optimised.limits_below_the_front or any(one.failure for one in optimised.designs):
        raise typer.Exit(1)


def objectives_of(
    args: TradeOffSettings, outputs: Sequence[str]
) -> tuple[NamedObjective, NamedObjective]:
    """Return the two objectives that a command asks for.

    Args:
        args: settings of the command.
        outputs: of the surrogate; the defaults are its first two.

    Returns:
        The limited objective, the improved one.

    Raises:
        ConfigError: one line, where there are not just two of them.
    """
    given = (args.maximise, args.minimise)
    against = args.against or next(name for name in outputs if name not in given)
    maximise = args.maximise
    if not any(given):
        maximise = next((name for name in outputs if name != against), None)
    return trade_off(against, args.at_most, args.at_least, maximise, args.minimise)


def _base(campaign: dict[str, Any], file: Path | None, overrides: Change) -> Config:
    """The configuration that a design's inputs are set in."""
    if file is not None or "base" not in campaign:
        return doe_commands.base(file, overrides)
    return configuration.changed(configuration.from_dict(campaign["base"]), overrides)


def _print(facts: OptimumFile, screen: Screen) -> None:
    first, second = facts.objectives
    for limit in facts.limits_below_the_front:
        screen.print(f"no design of the front has {first.title} {first.sense} {limit:g}")
    if facts.designs:
        screen.print(_table(facts.designs, first, second))
    for one in facts.designs:
        if one.failure:
            screen.say(f"{one.role} design failed: {one.failure}", style="red")
    for name, error in facts.surrogate_error_on_front.items():
        screen.say(
            f"surrogate on {error.designs} points along the front, {name}: RMS error "
            f"{error.rms:.3g} ({100 * error.relative:.2g} %), largest {error.largest:.3g}"
        )


def _table(
    designs: Sequence[ChosenDesign], limited: NamedObjective, improved: NamedObjective
) -> Table:
    """The chosen designs; by the surrogate, and by finite elements where they are checked."""

    first, roles = designs[0], "Design"
    columns = {roles: [_role(one, limited) for one in designs]}
    for name in first.inputs:
        columns[label(name)] = [f"{one.inputs[name]:z.3f}" for one in designs]
    for name in first.surrogate:
        columns[label(name)] = [f"{one.surrogate[name]:z.3f}" for one in designs]
        if first.resolved:
            what, bracket, unit = label(name).partition(" (")
            columns[f"{what} by FEM{bracket}{unit}"] = [
                "failed" if one.fem is None else f"{one.fem[name]:z.3f}" for one in designs
            ]
    if first.resolved:
        gains = [one.gain for one in designs]
        columns["Gain (%)"] = ["–" if gain is None else f"{100 * gain:+z.1f}" for gain in gains]
    table = of_columns(columns, "Designs", left=(roles,))
    if first.resolved:
        name = label(improved.title).partition(" (")[0]
        table.caption = (
            f"by the surrogate; FEM: by finite elements; gain over the original's: {name}"
        )
    return table


def _role(design: ChosenDesign, limited: NamedObjective) -> str:
    if design.limit is None:
        return design.role
    return f"{design.role} {'≤' if limited.sign > 0 else '≥'} {design.limit:g} {limited.unit}"


def study(args: StudySettings) -> None:
    """Try NSGA-II's hyperparameters: all combinations, each with several seeds."""
    one_process("--processes, without mpirun")

    model = network.load(args.surrogate)
    objectives = objectives_of(args, model.output_names)
    if len(args.at_most + args.at_least) != 1:
        raise ConfigError("--at-most, --at-least: allowed: one of them, to choose designs by")
    (limit,) = args.at_most + args.at_least
    plan = work.HyperparameterStudy(
        objectives,
        limit,
        tuple(dict.fromkeys(args.population)),
        tuple(dict.fromkeys(args.generations)),
        tuple(dict.fromkeys(args.crossover)),
        tuple(dict.fromkeys(args.mutation)),
        args.seeds,
    )
    names, improved = model.input_names, objectives[1].title
    screen = console()
    processes = args.processes or len(os.sched_getaffinity(0))
    with resumable(screen, args.out), progress.jobs(screen, "runs") as show:
        runs = work.run(args.surrogate, args.out, plan, processes, show)
    combinations = work.combine(runs.choices, names, improved)
    best = work.best(combinations, names[0])
    for name, rows in (("combinations", combinations), ("best", best)):
        table.write(args.out / f"{name}.csv", rows.to_dict("records"), list(rows))
    screen.say(
        f"{len(combinations)} combinations of {args.seeds} seeds, from {len(plan.runs())} runs of "
        f"NSGA-II ({runs.cpu_s / 60:.1f} minutes of one core)"
    )
    if best.empty:
        first = objectives[0]
        screen.print(f"no front of all seeds has {first.title} {first.sense} {limit:g}")
        raise typer.Exit(1)
    _plot(best, names, args.out)
    screen.print(_combinations(best, names, improved))
    screen.say(f"study: {args.out}")


def _plot(best: pd.DataFrame, names: Sequence[str], out: Path) -> None:
    sd = {
        population: (line["generations"].tolist(), line[[f"{n}_sd" for n in names]].to_numpy())
        for population, line in best.groupby("population")
    }
    look = picture.Look(panel_in=(4.0, 4.0), titled=True)
    picture.write(pictures.scatter(names, sd), out / "scatter.png", look)


def _combinations(best: pd.DataFrame, names: Sequence[str], improved: str) -> Table:
    rates = ("popu-\nlation", "gene-\nrations", "cross-\nover", "muta-\ntion")
    rows = [
        (
            *(f"{one[name]:g}" for name in work.SETTINGS),
            *(f"{one[f'{name}_mean']:z.4f} ± {one[f'{name}_sd']:.4f}" for name in names),
            f"{one[f'mean_{improved}']:.4f}",
        )
        for one in best.to_dict("records")
    ]
    title = "Best rates, and their choice: mean ± standard deviation over the seeds"
    return of_rows([*rates, *map(label, names), label(improved)], rows, title)
