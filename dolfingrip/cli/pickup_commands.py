"""``dolfingrip pickup`` and ``dolfingrip friction``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import typer

from dolfingrip import config as configuration
from dolfingrip.cli.console import Screen, console, one_process, resumable
from dolfingrip.cli.settings import FrictionSettings, GraspSearchSettings, PickupSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import pickup as searches
from dolfingrip.design.campaign.pickup import GraspTrial, GraspTrials
from dolfingrip.design.campaign.policy import LIFT_MM
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import computed_in
from dolfingrip.files import table
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Standing
from dolfingrip.report.table import of_rows

SIMULATIONS = "simulations"
"""Folder in ``--out`` that keeps the grasps."""


def pickup(args: PickupSettings) -> None:
    """Find the least pressure that picks food up, by grasps at multiples of --resolution."""
    _check("--resolution", args.resolution, args.highest)
    _check("--start", args.start, args.highest)
    base = _base(args, args.friction)

    screen = console()
    with _trials(base, args.out, screen) as trials:
        threshold = searches.pickup_pressure(trials, args.resolution, args.start, args.highest)
    _print(trials.made, screen)
    _write(trials.made, args.out / "pickup.csv")
    up_to = f"any pressure up to {args.highest:g} kPa"
    ended = threshold.undecided
    if threshold.least_kPa is None:
        unknown = "" if ended is None else f"not known whether {up_to} picks it up: {ended.why}"
        screen.say(unknown or f"not picked up at {up_to}")
        raise typer.Exit(1)
    below = "" if threshold.fails_kPa is None else f", not at {threshold.fails_kPa:g} kPa"
    if ended is not None:
        below = f", not known below: {ended.why}"
    screen.say(f"picked up from {threshold.least_kPa:g} kPa on{below} (μ = {base.food.friction:g})")


def friction(args: FrictionSettings) -> None:
    """Calibrate friction from the least pressure that picks food up: μ and its interval."""
    if args.resolution >= args.pickup_pressure:
        raise ConfigError(
            f"--resolution {args.resolution:g}: allowed: above 0 and below "
            f"{args.pickup_pressure:g} kPa"
        )
    base = _base(args)

    screen = console()
    with _trials(base, args.out, screen) as trials:
        estimate = searches.friction(trials, args.pickup_pressure, args.resolution, args.tolerance)
    _print(trials.made, screen)
    _write(trials.made, args.out / "friction.csv")
    screen.say(
        f"μ = {estimate.friction:.3g}, between {estimate.low:.3g} and {estimate.high:.3g} "
        f"(each ± {args.tolerance:g}): least pressure {args.pickup_pressure:g} kPa, "
        f"found in steps of {args.resolution:g} kPa"
    )


def _check(flag: str, value: float, most: float) -> None:
    if value > most:
        raise ConfigError(f"{flag} {value:g}: allowed: above 0 and up to {most:g} kPa")


def _base(args: GraspSearchSettings, friction: float | None = None) -> Config:
    """The configuration of all grasps, with a short lift if no other one is asked for."""
    one_process("one process")
    given = {
        "food.kind": args.food,
        "gripper.pose": args.pose,
        "gripper.preset": args.preset,
        "food.friction": friction,
    }
    set_keys = {key: value for key, value in given.items() if value is not None}
    changes = {**args.overrides, **set_keys}
    loaded = configuration.load(args.config, changes, {"gripper.lift_mm": LIFT_MM})
    Request.of("grasp", loaded)  # a bad key raises before anything is computed
    return loaded


@contextmanager
def _trials(base: Config, out: Path, screen: Screen) -> Iterator[GraspTrials]:
    """Grasps that print a line each."""
    standing: list[Standing] = []
    with (
        resumable(screen, out),
        screen.status("grasping") as status,
        Pool(Where()) as pool,
    ):
        compute = computed_in(out / SIMULATIONS, pool, standing.append)

        def show(trial: GraspTrial) -> None:
            note = "" if standing[-1].computed else " (known)"
            screen.say(f"{_named(trial)}: {trial.outcome}{note}")
            status.update(f"grasping, after {_named(trial)}")

        yield GraspTrials(base, compute, show)


def _named(trial: GraspTrial) -> str:
    return f"{trial.pressure_kPa:g} kPa, μ = {trial.friction:.4g}"


def _print(trials: list[GraspTrial], screen: Screen) -> None:
    headings = ("Pressure (kPa)", "μ", "Normal forces (N)", "Weight (N)", "Outcome")
    rows = [
        (f"{trial.pressure_kPa:g}", f"{trial.friction:.4g}", f"{trial.normal_N:.3f}",
         f"{trial.weight_N:.3f}", trial.outcome)
        for trial in sorted(trials, key=lambda trial: (trial.pressure_kPa, trial.friction))
    ]  # fmt: skip
    screen.print(of_rows(headings, rows, left=headings[-1:]))


def _write(trials: list[GraspTrial], path: Path) -> None:
    table.write(path, [asdict(trial) for trial in trials])
