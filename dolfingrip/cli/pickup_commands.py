"""``dolfingrip pickup`` and ``dolfingrip friction``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Out, Overrides, check_writable, console, one_process
from dolfingrip.cli.simulations import resumable
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign.policy import SEARCH
from dolfingrip.experiments.request import Request
from dolfingrip.files import table

if TYPE_CHECKING:
    from dolfingrip.design.campaign.trials import Trial, Trials

Food = Annotated[str | None, typer.Option(help="What is grasped, e.g. potato-large.")]
Pose = Annotated[str | None, typer.Option(help="scoop, pinch or claw.")]
Preset = Annotated[str | None, typer.Option(help="Mesh: coarse or default.")]
Resolution = Annotated[
    float, typer.Option(metavar="kPa", help="Distance of the pressures that are tried.")
]


def pickup(
    out: Out = Path("out/pickup"),
    food: Food = None,
    pose: Pose = None,
    friction: Annotated[float | None, typer.Option(help="Of fingers on food.")] = None,
    resolution: Resolution = 5.0,
    start: Annotated[float, typer.Option(metavar="kPa", help="Of the first grasp.")] = 150.0,
    highest: Annotated[
        float, typer.Option(metavar="kPa", help="None above is tried.")
    ] = SEARCH.highest_kPa,
    preset: Preset = None,
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Find the least pressure that picks food up, by grasps at multiples of --resolution.

    A call that was killed goes on where it was. pickup.csv has all grasps.
    """
    _check("--resolution", resolution, highest)
    _check("--start", start, highest)
    _check("--highest", highest, SEARCH.largest_pressure_kPa)
    base = _base(config, overrides, food, pose, preset, friction)
    from dolfingrip.design.campaign.pickup import pickup_pressure

    screen = console()
    with _trials(base, out, screen) as trials:
        found = pickup_pressure(trials, resolution, start, highest)
    _print(trials.made, screen)
    _write(trials.made, out / "pickup.csv")
    if found.least_kPa is None:
        screen.print(f"not picked up at any pressure up to {highest:g} kPa", soft_wrap=True)
        raise typer.Exit(1)
    below = "" if found.fails_kPa is None else f", not at {found.fails_kPa:g} kPa"
    screen.print(
        f"picked up from {found.least_kPa:g} kPa on{below} (μ = {base.food.friction:g})",
        soft_wrap=True,
    )


def friction(
    pickup_pressure: Annotated[
        float, typer.Option(metavar="kPa", help="Least pressure that picks up, as measured.")
    ],
    out: Out = Path("out/friction"),
    food: Food = None,
    pose: Pose = None,
    resolution: Resolution = 5.0,
    tolerance: Annotated[float, typer.Option(help="Of the friction that is sought.")] = 0.01,
    preset: Preset = None,
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Calibrate friction from the least pressure that picks food up: μ and its interval.

    A call that was killed goes on where it was. friction.csv has all grasps.
    """
    _check("--pickup-pressure", pickup_pressure, SEARCH.largest_pressure_kPa)
    if not 0 < resolution < pickup_pressure:
        raise ConfigError(
            f"--resolution {resolution:g}: allowed: above 0 and below {pickup_pressure:g} kPa"
        )
    if not 1e-4 <= tolerance <= 0.5:
        raise ConfigError(f"--tolerance {tolerance:g}: allowed: 0.0001 to 0.5")
    base = _base(config, overrides, food, pose, preset)
    from dolfingrip.design.campaign import calibration

    screen = console()
    with _trials(base, out, screen) as trials:
        found = calibration.friction(trials, pickup_pressure, resolution, tolerance)
    _print(trials.made, screen)
    _write(trials.made, out / "friction.csv")
    screen.print(
        f"μ = {found.friction:.3g}, between {found.low:.3g} and {found.high:.3g} "
        f"(each ± {tolerance:g}): least pressure {pickup_pressure:g} kPa, found in steps of "
        f"{resolution:g} kPa",
        soft_wrap=True,
    )


def _check(flag: str, value: float, most: float) -> None:
    if not 0 < value <= most:
        raise ConfigError(f"{flag} {value:g}: allowed: above 0 and up to {most:g} kPa")


def _base(
    config: Path | None,
    overrides: list[Any] | None,
    food: str | None,
    pose: str | None,
    preset: str | None,
    friction: float | None = None,
) -> Config:
    """The configuration of all grasps, with a short lift if no other one is asked for."""
    one_process("one process")
    given = {
        "food.kind": food,
        "gripper.pose": pose,
        "gripper.preset": preset,
        "food.friction": friction,
    }
    options = {key: value for key, value in given.items() if value is not None}
    asked = {**dict(overrides or ()), **options}
    loaded = configuration.load(config, asked, {"gripper.lift_mm": SEARCH.lift_mm})
    Request.of("grasp", loaded)  # a bad key raises before anything is computed
    return loaded


@contextmanager
def _trials(base: Config, out: Path, screen: Console) -> Iterator[Trials]:
    """Grasps that print a line each."""
    check_writable(out)
    from dolfingrip.design.campaign.trials import Trials

    with resumable(screen, out), screen.status("grasping") as status:

        def show(trial: Trial) -> None:
            known = "" if trial.computed else " (known)"
            screen.print(f"{_named(trial)}: {trial.outcome}{known}", soft_wrap=True)
            status.update(f"grasping, after {_named(trial)}")

        yield Trials(base, out, show)


def _named(trial: Trial) -> str:
    return f"{trial.pressure_kPa:g} kPa, μ = {trial.friction:.4g}"


def _print(trials: list[Trial], screen: Console) -> None:
    table = Table("Pressure (kPa)", "μ", "Normal forces (N)", "Weight (N)", "", box=SIMPLE_HEAD)
    for each in sorted(trials, key=lambda trial: (trial.pressure_kPa, trial.friction)):
        table.add_row(
            f"{each.pressure_kPa:g}",
            f"{each.friction:.4g}",
            f"{each.normal_N:.3f}",
            f"{each.weight_N:.3f}",
            each.outcome,
        )
    screen.print(table)


def _write(trials: list[Trial], path: Path) -> None:
    names = [field.name for field in fields(trials[0]) if field.name != "computed"]
    table.write(path, [{name: getattr(each, name) for name in names} for each in trials])
