"""``dolfingrip supply``: which commands of a supply make a finger follow a curve."""

from __future__ import annotations

from pathlib import Path

from dolfingrip import config as configuration
from dolfingrip.channels import ANGLE, PRESSURE, TIME
from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import console, one_process
from dolfingrip.cli.settings import SupplySettings
from dolfingrip.config import ConfigError
from dolfingrip.experiments import feedforward
from dolfingrip.files import table
from dolfingrip.sections import protocol_file, tables


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
    picture.write([control.chart()], drawn)
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
