"""``dolfingrip doe`` and ``dolfingrip doe export``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import typer

from dolfingrip import config as configuration
from dolfingrip.cli import progress
from dolfingrip.cli.console import console, gradient_keys, one_process, resumable
from dolfingrip.cli.settings import DoeExportSettings, DoeSettings
from dolfingrip.config import Change, Config, ConfigError
from dolfingrip.design.campaign import campaign, plan, space
from dolfingrip.design.campaign.objective import check_quantities
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.quantities.index import parse
from dolfingrip.design.quantities.quantity import AskedDesign
from dolfingrip.experiments.derivatives.sensitivities import choices, chosen
from dolfingrip.experiments.idle import idle
from dolfingrip.experiments.index import find
from dolfingrip.jobs import run
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import JobResult
from dolfingrip.report.design import label
from dolfingrip.report.page.numbers import said

LONGEST_KPA = 100.0
"""Longest step between two readings, and of a load: long steps cost least."""


def base(file: Path | None, overrides: Change) -> Config:
    """Read the configuration that designs vary; the paper reads the blocked force at 300 kPa.

    Args:
        file: as of :func:`dolfingrip.config.load`.
        overrides: as of that.
    """
    defaults = {"experiment.max_pressure_kPa": 300.0, "solver.max_step_kPa": LONGEST_KPA}
    highest_kPa = configuration.load(file, overrides, defaults).experiment.largest_kPa
    defaults["experiment.step_kPa"] = min(LONGEST_KPA, highest_kPa)
    return configuration.load(file, overrides, defaults)


def doe(args: DoeSettings) -> None:
    """Design of experiments: compute every design that is missing in a campaign.

    Raises:
        typer.Exit: with code 1, if every design failed.
    """
    one_process("--ranks, without mpirun")
    if args.check is not None:
        _check(args.check)
        return
    wanted = planned(args, base(args.config, args.overrides))
    screen = console()
    where = Where(args.scheduler, args.slurm, args.workers, args.ranks)
    shown = progress.jobs(screen, "designs", progress.FEW, describe=_so_far(wanted))
    with resumable(screen, args.out), shown as show:
        standing = campaign.run(
            wanted, args.out, where, retry_failed=args.retry_failed, progress=show
        )
    screen.say(
        f"{standing.total} designs: {standing.computed} computed now, {standing.done} done, "
        f"{standing.failed} failed"
    )
    designs = campaign.read(args.out).designs if standing.failed else ()
    for kind, count in sorted(standing.classes.items()):
        why = next((design.failure for design in designs if design.failure_class == kind), None)
        screen.say(f"  {count} failed: {kind}: {why}" if why else f"  {count} failed: {kind}")
    if wanted.gradients is not None:
        _write(args.out, [args.out / "designs.csv"])
    screen.say(f"campaign: {args.out}")
    if not standing.done:
        raise typer.Exit(1)


def planned(args: DoeSettings, resolved: Config) -> Plan:
    """Return the designs that are asked for.

    Args:
        args: settings of the command.
        resolved: configuration that the designs share.

    Raises:
        ConfigError: one line.
    """
    varied = [space.parse(text) for text in args.parameter or space.PAPER]
    configuration.followed(resolved, {parameter.key: parameter.low for parameter in varied})
    keys = _keys(args.gradients, args.parameters, args.objective, resolved)
    if args.fields and args.objective is not None:
        raise ConfigError("--fields: allowed: without --objective, whose results are its own")
    objective = args.objective or plan.OBJECTIVE
    quantities = plan.quantities(args.quantity or plan.QUANTITIES, objective)
    if objective == plan.OBJECTIVE:
        check_quantities(quantities, AskedDesign(resolved, keys, args.ranks))
        for parameter in varied:
            _check_felt(parameter.key, quantities, resolved)
    return plan.Plan(
        base=resolved,
        parameters=tuple(p.key for p in varied),
        points=tuple(space.points(varied, args.points, args.number, args.seed)),
        quantities=quantities,
        objective=objective,
        gradients=keys,
        fields=args.out / plan.FIELDS if args.fields else None,
    )


def _check_felt(key: str, quantities: Sequence[str], config: Config) -> None:
    """Refuse a parameter that none of the quantities depends on, as all designs would be one."""
    names = [quantity.experiment for quantity in map(parse, quantities)]
    # the unloaded shape is that of a finger that is bent
    experiments = [find(name or "bending") for name in names]
    change = {} if None in names and key.startswith("cog.") else {key: None}
    said = [list(idle(one, one.settings(config), change)) for one in experiments]
    if said and all(said):
        raise ConfigError(f"--parameter {said[0][0]}; allowed: a key that a quantity depends on")


def _check(folder: Path) -> None:
    """Say how much of a campaign is whole; end with code 1 where something is not."""
    sound_count, aside = run.check(folder)
    screen = console()
    screen.say(f"{folder}: {sound_count} designs and answers are whole")
    for name in aside:
        screen.say(f"damaged, set aside: {name}")
    if aside:
        screen.say("the command that made the campaign computes them anew")
        raise typer.Exit(1)


def _so_far(plan: Plan) -> Callable[[JobResult], str]:
    """Says what a design and its outputs are."""

    inputs = {design.key: design.inputs for design in plan.designs()}

    def told(answer: JobResult) -> str:
        def words(values: Mapping[str, Any]) -> str:
            return ", ".join(
                f"{label(name)} {said(v) if isinstance(v, float | int) else v}"
                for name, v in values.items()
            )

        outcome = words((answer.result or {}).get("outputs", {})) or answer.failure_class
        return f"{words(inputs.get(answer.key, {}))}: {outcome}"

    return told


def _keys(
    gradients: bool, parameters: str | None, objective: str | None, resolved: Config
) -> tuple[str, ...] | None:
    """Keys that each design's quantities are derived by; the designs check them if they can.

    Raises:
        ConfigError: one line.
    """
    keys = gradient_keys(gradients, parameters)
    if keys is None:
        return None
    if objective is not None:
        raise ConfigError("--gradients: allowed: without --objective, whose gradients are its own")

    chosen(resolved, keys)
    choices(resolved, keys)
    return tuple(sorted(set(keys)))


def _write(out: Path, tables: list[Path]) -> None:
    """Write a campaign's designs, and their derivatives where there are any."""

    number = campaign.write(out, tables)
    for path in tables:
        console().say(f"wrote {number} designs: {path}")
    slopes = out / "sensitivity.csv"
    number = campaign.write_sensitivities(out, slopes)
    if number:
        console().say(f"wrote {number} derivatives: {slopes}")


def export(args: DoeExportSettings) -> None:
    """Write a campaign's designs as CSV and Parquet, and derivatives as sensitivity.csv."""
    _write(
        args.out,
        [args.csv or args.out / "designs.csv", args.parquet or args.out / "designs.parquet"],
    )
