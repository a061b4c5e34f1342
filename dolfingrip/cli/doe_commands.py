"""``dolfingrip doe`` and ``dolfingrip doe export``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import typer

from dolfingrip import config as configuration
from dolfingrip.cli import progress
from dolfingrip.cli.console import check_writable, console, gradient_keys, one_process, resumable
from dolfingrip.cli.settings import DoeExportSettings, DoeSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign, plan, space
from dolfingrip.design.campaign import campaign as files
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.experiments.derivatives.sensitivities import choices, chosen
from dolfingrip.jobs import run
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import Answer
from dolfingrip.report.design import label
from dolfingrip.report.page.numbers import said

DEFAULTS = {
    "experiment.max_pressure_kPa": 300.0,
    "experiment.step_kPa": 100.0,
    "solver.max_step_kPa": 100.0,
}
"""The paper reads the blocked force at 300 kPa; long load steps cost least."""


def doe(asked: DoeSettings) -> None:
    """Design of experiments: compute every design that is missing in a campaign.

    Raises:
        typer.Exit: with code 1, if every design failed.
    """
    one_process("--ranks, without mpirun")
    if asked.check is not None:
        _check(asked.check)
        return
    wanted = planned(asked, configuration.load(asked.config, asked.overrides, DEFAULTS))
    check_writable(asked.out)
    screen = console()
    where = Where(asked.scheduler, asked.slurm, asked.workers, asked.ranks)
    shown = progress.jobs(screen, "designs", progress.FEW, told=_so_far(wanted))
    with resumable(screen, asked.out), shown as show:
        standing = campaign.run(
            wanted, asked.out, where, retry_failed=asked.retry_failed, progress=show
        )
    screen.say(
        f"{standing.total} designs: {standing.computed} computed now, {standing.done} done, "
        f"{standing.failed} failed"
    )
    designs = campaign.read(asked.out).designs if standing.failed else ()
    for kind, count in sorted(standing.classes.items()):
        why = next((each.failure for each in designs if each.failure_class == kind), None)
        screen.say(f"  {count} failed: {kind}: {why}" if why else f"  {count} failed: {kind}")
    if wanted.gradients is not None:
        _write(asked.out, [asked.out / "designs.csv"])
    screen.say(f"campaign: {asked.out}")
    if not standing.done:
        raise typer.Exit(1)


def planned(asked: DoeSettings, resolved: Config) -> Plan:
    """Return the designs that are asked for.

    Args:
        asked: settings of the command.
        resolved: configuration that the designs share.

    Raises:
        ConfigError: one line.
    """
    varied = [space.parse(text) for text in asked.parameter or space.PAPER]
    configuration.followed(resolved, {each.key: each.low for each in varied})
    keys = _keys(asked.gradients, asked.parameters, asked.objective, resolved)
    if asked.fields and asked.objective is not None:
        raise ConfigError("--fields: allowed: without --objective, whose results are its own")
    objective = asked.objective or plan.OBJECTIVE
    return plan.Plan(
        base=resolved,
        parameters=tuple(p.key for p in varied),
        points=tuple(space.points(varied, asked.points, asked.number, asked.seed)),
        quantities=plan.quantities(asked.quantity or plan.QUANTITIES, objective),
        objective=objective,
        gradients=keys,
        fields=asked.out / plan.FIELDS if asked.fields else None,
    )


def _check(folder: Path) -> None:
    """Say how much of a campaign is whole; end with code 1 where something is not."""
    whole, aside = run.check(folder)
    screen = console()
    screen.say(f"{folder}: {whole} designs and answers are whole")
    for name in aside:
        screen.say(f"damaged, set aside: {name}")
    if aside:
        screen.say("the command that made the campaign computes them anew")
        raise typer.Exit(1)


def _so_far(plan: Plan) -> Callable[[Answer], str]:
    """Says what a design and its outputs are."""

    inputs = {design.key: design.inputs for design in plan.designs()}

    def told(answer: Answer) -> str:
        def words(values: Mapping[str, Any]) -> str:
            return ", ".join(
                f"{label(name)} {said(v) if isinstance(v, float | int) else v}"
                for name, v in values.items()
            )

        found = words((answer.result or {}).get("outputs", {})) or answer.failure_class
        return f"{words(inputs.get(answer.key, {}))}: {found}"

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

    number = files.write(out, tables)
    for path in tables:
        console().say(f"wrote {number} designs: {path}")
    slopes = out / "sensitivity.csv"
    number = files.write_sensitivities(out, slopes)
    if number:
        console().say(f"wrote {number} derivatives: {slopes}")


def export(asked: DoeExportSettings) -> None:
    """Write a campaign's designs as CSV and Parquet, and derivatives as sensitivity.csv."""
    _write(
        asked.out,
        [asked.csv or asked.out / "designs.csv", asked.parquet or asked.out / "designs.parquet"],
    )
