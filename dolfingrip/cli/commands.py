"""The commands, in the order of use; they are made of all experiments and keys that there are."""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from dolfingrip.cli import edge, settings
from dolfingrip.cli.command import NOTHING, Group, Listed, Subcommand
from dolfingrip.cli.installation import solver
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.version import __version__

INSTEAD = {"coupon": {"fit": "fit_command:fit_coupons"}}
"""Work that an option of an experiment asks for in place of the experiment."""

DESIGN, DIAGNOSIS, IMPORTING = ("design",), ("diagnosis",), ("importing", "diagnosis")

ALL = (
    Subcommand("demo", settings.DemoSettings, "loop_commands:demo", rooms=DESIGN),
    *(
        Subcommand(
            experiment.command, settings.of_experiment(experiment), "experiment_commands:perform",
            experiment.summary(), instead=INSTEAD.get(experiment.name, NOTHING),
        )
        for experiment in EXPERIMENTS.values()
    ),
    Subcommand("pickup", settings.PickupSettings, "pickup_commands:pickup", rooms=DESIGN),
    Subcommand("friction", settings.FrictionSettings, "pickup_commands:friction", rooms=DESIGN),
    Subcommand("supply", settings.SupplySettings, "supply_command:supply"),
    Subcommand("adopt", settings.AdoptSettings, "adopt_command:adopt"),
    Subcommand("mesh", settings.MeshSettings, "shape_commands:mesh"),
    Subcommand("export", settings.ExportSettings, "export_command:export", rooms=("exporting",)),
    Subcommand("robot", settings.RobotSettings, "robot_command:robot", rooms=("robot",)),
    Subcommand("morph", settings.MorphSettings, "shape_commands:morph"),
    Subcommand("config", settings.ConfigSettings, "reference_commands:show_config"),
    Subcommand("columns", settings.ColumnsSettings, "reference_commands:columns"),
    Subcommand("extensions", settings.EffectSettings, "reference_commands:extensions"),
    Subcommand(
        "synthetic", settings.SyntheticSettings, "experiment_commands:synthetic_measurement"
    ),
    Subcommand("import", settings.ImportSettings, "import_command:import_table", rooms=IMPORTING),
    Subcommand(
        "track", settings.TrackSettings, "track_command:track_video",
        rooms=("tracking", *IMPORTING),
    ),
    Subcommand(
        "diagnose", settings.DiagnoseSettings, "diagnosis_commands:diagnose", rooms=DIAGNOSIS
    ),
    Subcommand(
        "plan-experiment", settings.PlanExperimentSettings, "diagnosis_commands:plan_experiment",
        rooms=DIAGNOSIS,
    ),
    Subcommand("predict", settings.PredictSettings, "diagnosis_commands:predict", rooms=DIAGNOSIS),
    Subcommand("design", settings.DesignSettings, "design_command:design", rooms=DESIGN),
    Subcommand(
        "doe", settings.DoeSettings, "doe_commands:doe",
        below=(Subcommand("export", settings.DoeExportSettings, "doe_commands:export"),),
        rooms=DESIGN,
    ),
    Subcommand("train", settings.TrainSettings, "surrogate_commands:train", rooms=DESIGN),
    Subcommand("optimise", settings.OptimiseSettings, "surrogate_commands:optimise", rooms=DESIGN),
    Subcommand("study", settings.StudySettings, "surrogate_commands:study", rooms=DESIGN),
    Subcommand("reproduce", settings.ReproduceSettings, "loop_commands:reproduce", rooms=DESIGN),
    Subcommand("report", settings.ReportSettings, "report_command:report"),
    Subcommand(
        "explore", settings.ExploreSettings, "explore_command:explore",
        rooms=("explore", *DESIGN, *DIAGNOSIS),
    ),
    Subcommand("doctor", settings.DoctorSettings, "doctor_command:doctor"),
)  # fmt: skip


COMMANDS = tuple(command for command in ALL if command.is_there)
"""The commands in the order in which a new user needs them, of the folders that there are."""


class _InOrder(Group):
    """Has :data:`COMMANDS`, in their order."""

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        self.commands = {
            command.name: Listed(command, settings.group(command.settings)) for command in COMMANDS
        }


app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


def _print_version(wanted: bool) -> None:
    """Print the version and exit if ``--version`` is given."""
    if wanted:
        sys.stdout.write(f"dolfingrip {__version__}\n{solver()}; dolfingrip doctor says more\n")
        raise typer.Exit


@app.callback(
    cls=_InOrder,
    no_args_is_help=True,
    help="Simulate, design and diagnose pneumatic gripper fingers, printed or cast in silicone.",
)
def _start(
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", metavar="", help="Log details to the terminal.")
    ] = False,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, metavar="",
            help="Show the version and exit.",
        ),
    ] = False,
    _plugin: Annotated[  # plugins.taken() has read them before there were commands
        list[Path] | None,
        typer.Option(
            "--plugin", metavar="FILE.py",
            help="A law, an effect, a food or another thing of your own; repeatable.",
        ),
    ] = None,
) -> None:  # fmt: skip
    level = (logging.INFO if verbose else logging.WARNING) if edge.rank() == 0 else logging.CRITICAL
    logging.basicConfig(level=level, format="%(message)s", stream=sys.stderr)
