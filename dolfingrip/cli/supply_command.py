"""``dolfingrip supply``: which commands of a supply make a finger follow a curve."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from dolfingrip import config as configuration
from dolfingrip.channels import ANGLE, PRESSURE, TIME
from dolfingrip.charts import picture
from dolfingrip.charts.chart import Axis, Chart, Series
from dolfingrip.cli import progress
from dolfingrip.cli.console import console, one_process
from dolfingrip.cli.settings import SupplySettings
from dolfingrip.config import ConfigError
from dolfingrip.experiments import feedforward
from dolfingrip.experiments.feedforward import Feedforward
from dolfingrip.files import table
from dolfingrip.sections import protocol_file, tables

NAMES: Mapping[str, str] = {
    "set_point_kPa": "set point", "valve_open": "valve", "exhaust_open": "exhaust"
}  # fmt: skip
"""What the key of the picture calls the columns of commands."""


def supply(args: SupplySettings) -> None:
    """Find the commands of a supply with which the finger follows a curve of pressure or angle."""
    one_process("without mpirun")
    column = _column(args.curve)
    columns, _ = protocol_file.read(args.curve, "bending", column)
    defaults = {"supply.source": "ideal"}
    if column == PRESSURE.name:
        defaults["experiment.max_pressure_kPa"] = max(columns[column])
    config = configuration.load(args.config, args.overrides, defaults)
    screen = console()
    with progress.shown(screen, "steps") as show:
        control = feedforward.command_for(
            config, columns[TIME.name], every_s=args.every_s, regulator_kPa=args.regulator,
            progress=show, **{column: columns[column]},
        )  # fmt: skip
    file, drawn = args.out / "commands.csv", args.out / "commands.png"
    table.write(file, control.rows())
    picture.write([chart(control)], drawn)
    for line in control.sentences():
        screen.say(line)
    screen.say(f"commands: {file}; picture: {drawn}")


def _column(file: Path) -> str:
    """Column of a curve: the angle, where there is no pressure."""
    if file.suffix != ".csv":
        return PRESSURE.name
    names = tables.text_of(file, "CURVE").partition("\n")[0].strip().split(",")
    controls = [one.name for one in (PRESSURE, ANGLE) if one.name in names]
    if not controls:
        raise ConfigError(f"{file}: missing column {PRESSURE.name} or {ANGLE.name}")
    return controls[0]


def chart(control: Feedforward) -> Chart:
    """Draw the pressures over time, and the commands below them.

    Args:
        control: commands of a supply, and what follows from them.
    """
    time = Axis("Time (s)", "s", "Time")
    regulated = "set_point_kPa" in control.commands
    lower = Chart(
        "Commands", time, Axis("Set point (kPa)" if regulated else "Part of the time open (–)"),
        [Series(NAMES[name], control.time_s, values) for name, values in control.commands.items()],
    )  # fmt: skip
    pressures = [
        Series("tube", control.time_s, control.tube_kPa, colour="orange"),
        Series("cavity", control.time_s, control.reached_kPa, colour="blue"),
        Series("wished", control.time_s, control.wished_kPa, style="dash", colour="ink"),
    ]
    return Chart("Pressures", time, Axis("Pressure (kPa)"), pressures, below=lower)
