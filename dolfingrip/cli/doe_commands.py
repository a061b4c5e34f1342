"""``dolfingrip doe`` and ``dolfingrip doe export``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from dolfingrip import config as configuration
from dolfingrip.cli.options import (
    ConfigFile,
    Gradients,
    Out,
    Overrides,
    Parameters,
    check_writable,
    console,
    gradient_keys,
    one_process,
)
from dolfingrip.cli.simulations import resumable
from dolfingrip.config import Config, ConfigError

if TYPE_CHECKING:
    from dolfingrip.design.campaign.plan import Plan
    from dolfingrip.jobs.job import Answer

app = typer.Typer()

DEFAULTS = {
    "experiment.max_pressure_kPa": 300.0,
    "experiment.step_kPa": 100.0,
    "solver.max_step_kPa": 100.0,
}
"""The paper reads the blocked force at 300 kPa; long load steps cost least."""

OUT = Path("out/doe")


@app.callback(invoke_without_command=True)
def doe(
    context: typer.Context,
    out: Out = OUT,
    points: Annotated[
        Literal["grid", "sobol", "lhs"], typer.Option(help="Evenly spaced, or sampled.")
    ] = "grid",
    number: Annotated[int | None, typer.Option(help="Number of samples.")] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=LOW:HIGH[:COUNT]",
            help="What varies; repeatable. Default: the paper's 16 x 13 values of ξ1 and ξ2.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the samples.")] = 0,
    quantity: Annotated[
        list[str] | None,
        typer.Option(help="Outputs; repeatable. Default: cog_offset_mm and force_N."),
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Local processes, or Slurm jobs.")] = 1,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A Dask cluster that is there, tls://HOST:PORT."),
    ] = None,
    slurm: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Start workers as Slurm jobs.")
    ] = None,
    ranks: Annotated[int, typer.Option(min=1, help="MPI processes of each design.")] = 1,
    retry_failed: Annotated[bool, typer.Option(help="Compute failed designs anew.")] = False,
    objective: Annotated[
        str | None, typer.Option(metavar="MODULE:FUNCTION", help="Another objective function.")
    ] = None,
    fields: Annotated[
        bool,
        typer.Option(
            "--fields",
            help="Keep deformed shapes of designs computed now (2 MB for each reading, default "
            "mesh), for explore.",
        ),
    ] = False,
    gradients: Gradients = False,
    parameters: Parameters = None,
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Design of experiments: compute every design that is missing in a campaign."""
    if context.invoked_subcommand is not None:
        return
    one_process("--ranks, without mpirun")
    from dolfingrip.cli import progress
    from dolfingrip.design.campaign import campaign, plan, space
    from dolfingrip.design.campaign import objective as ours
    from dolfingrip.jobs.cluster import Where

    resolved = configuration.load(config, dict(overrides or ()), DEFAULTS)
    varied = [space.parse(text) for text in parameter or space.PAPER]
    keys = _keys(gradients, parameters, objective, resolved)
    if fields and objective is not None:
        raise ConfigError("--fields: allowed: without --objective, whose results are its own")
    asked = quantity or list(plan.QUANTITIES)
    wanted = plan.Plan(
        base=resolved,
        parameters=tuple(p.key for p in varied),
        points=tuple(space.points(varied, points, number, seed)),
        quantities=plan.quantities(asked, ours.QUANTITIES if objective is None else asked),
        objective=objective or plan.OBJECTIVE,
        gradients=keys,
        fields=out / plan.FIELDS if fields else None,
    )
    check_writable(out)
    screen = console()
    where = Where(scheduler, slurm, workers, ranks)
    shown = progress.jobs(screen, "designs", progress.FEW, told=_so_far(wanted))
    with resumable(screen, out), shown as show:
        standing = campaign.run(wanted, out, where, retry_failed=retry_failed, progress=show)
    screen.print(
        f"{standing.total} designs: {standing.computed} computed now, {standing.done} done, "
        f"{standing.failed} failed",
        soft_wrap=True,
    )
    for kind, count in sorted(standing.classes.items()):
        screen.print(f"  {count} failed: {kind}", soft_wrap=True)
    if keys is not None:
        _write(out, [out / "designs.csv"])
    screen.print(f"campaign: {out}", soft_wrap=True)


def _so_far(plan: Plan) -> Callable[[Answer], str]:
    """Says what a design and its outputs are."""
    from dolfingrip.report.design import label
    from dolfingrip.report.page.numbers import said

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
    from dolfingrip.experiments.derivatives.choices import choices
    from dolfingrip.experiments.derivatives.sensitivities import chosen

    chosen(resolved, keys)
    choices(resolved, keys)
    return tuple(sorted(set(keys)))


def _write(out: Path, tables: list[Path]) -> None:
    """Write a campaign's designs, and their derivatives where there are any."""
    from dolfingrip.design.campaign import export

    number = export.write(out, tables)
    for path in tables:
        console().print(f"wrote {number} designs: {path}", soft_wrap=True)
    slopes = out / "sensitivity.csv"
    number = export.write_sensitivities(out, slopes)
    if number:
        console().print(f"wrote {number} derivatives: {slopes}", soft_wrap=True)


@app.command()
def export(
    out: Out = OUT,
    csv: Annotated[Path | None, typer.Option(help="Default: designs.csv in --out.")] = None,
    parquet: Annotated[Path | None, typer.Option(help="Default: designs.parquet in --out.")] = None,
) -> None:
    """Write a campaign's designs as CSV and Parquet, and derivatives as sensitivity.csv."""
    _write(out, [csv or out / "designs.csv", parquet or out / "designs.parquet"])
