"""``dolfingrip diagnose``, ``plan-experiment`` and ``predict``: model against measurement."""

from __future__ import annotations

import textwrap

import numpy as np
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.channels import CHORD_ANGLE, PRESSURE
from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import console, one_process, resumable
from dolfingrip.cli.rooms import offered
from dolfingrip.cli.settings import DiagnoseSettings, PlanExperimentSettings, PredictSettings
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis import diagnose as diagnosing
from dolfingrip.diagnosis import plan as planning
from dolfingrip.diagnosis.core.unknown import check_effects
from dolfingrip.diagnosis.results import plan_text, write
from dolfingrip.experiments import prediction
from dolfingrip.experiments.prediction import Prediction
from dolfingrip.experiments.synthetic import check_noise
from dolfingrip.files import whole
from dolfingrip.files.diagnosis_words import lines
from dolfingrip.files.plan import PlanFile
from dolfingrip.report import diagnosis as pictures
from dolfingrip.report import plan as plan_pictures
from dolfingrip.report.table import of_rows
from dolfingrip.sections import posterior


def diagnose(args: DiagnoseSettings) -> None:
    """Find out what the simulation gets wrong about measured data, and why."""
    one_process("--workers, without mpirun")

    resolved = configuration.load(args.config, args.overrides)
    screen = console()
    data = offered(args.data, "diagnose", screen, args.out)
    kept = args.store or args.out / "simulations"
    with resumable(screen, kept), progress.jobs(screen, "simulations") as show:
        chosen = diagnosing.DiagnosisSettings(
            args.workers, kept, args.quick, list(args.effects) or None, args.campaign,
            screen.say, show,
        )  # fmt: skip
        diagnosis = diagnosing.diagnose(data, resolved, args.out, chosen)
    result, readings = write(diagnosis, data, args.out)

    pictures.draw(result, readings, args.out)
    for line in lines(result):
        screen.say(line)
    screen.say(f"diagnosis: {args.out}")


NAMES = 26
"""Width, in characters, to which cells are wrapped."""
LEFT = ("effect", "not told from", "addition", "newly named")
"""Columns that are aligned on the left."""


def tables(plan: PlanFile) -> list[Table]:
    """The effects and the additions of a plan, for a terminal of 80 columns."""
    shown = []
    for table in plan.tables():
        kept = [i for i, heading in enumerate(table.headings) if heading != "ordinary strength"]
        rows = [["\n".join(textwrap.wrap(row[i], NAMES)) for i in kept] for row in table.rows]
        shown.append(of_rows([table.headings[i] for i in kept], rows, table.title, LEFT))
    return shown


def plan_experiment(args: PlanExperimentSettings) -> None:
    """Find which effects a rig could name, at which strength, and what to add to it."""
    one_process("--workers, without mpirun")

    resolved = configuration.load(args.config, args.overrides)
    screen = console()
    effects = list(args.effects) or None
    check_effects(effects)
    check_noise(args.noise)
    kept = args.store or args.out / "simulations"
    with resumable(screen, kept), progress.jobs(screen, "simulations") as show:
        chosen = diagnosing.DiagnosisSettings(
            args.workers, kept, args.quick, effects, say=screen.say, progress=show
        )
        plan = planning.plan(args.rig, resolved, args.out, chosen, args.changes, args.noise)
    plan.write(args.out)
    text = plan_text(plan)
    whole.write(args.out / "plan.md", text)

    picture.write(plan_pictures.charts(plan), args.out / "plan.png", plan_pictures.look(plan))
    screen.say(text.partition("\n|")[0].lstrip("# "))
    for table in tables(plan):
        screen.print(table)
        screen.print()
    for warning in plan.warnings:
        screen.say(f"- {warning}")
    screen.say(f"plan: {args.out}")


def predict(args: PredictSettings) -> None:
    """Predict an actuator from fits to others: angle and ballooning pressure, 90 % intervals."""
    one_process("without mpirun")

    pressures = args.pressures
    if not pressures or min(pressures) <= 0:
        given = ",".join(f"{pressure:g}" for pressure in pressures)
        raise ConfigError(f"--pressures {given}: allowed: numbers above 0 kPa, joined by commas")
    fits = posterior.read(args.source)
    config = configuration.load(args.source, args.overrides)
    config = config.changed(experiment={"max_pressure_kPa": 1.15 * max(pressures)})
    screen = console()
    with progress.shown(screen, "fits", total=len(fits.fit)) as show:
        curves = prediction.simulated(
            config, fits, args.out,
            lambda i, row: show(i, len(fits.fit), f"{row['pressure_kPa']:.1f} kPa"),
        )  # fmt: skip
    predicted = prediction.predict(curves, fits, np.array(pressures))
    file = args.csv or args.out / "prediction.csv"
    text = _table(predicted)
    whole.write(file, text)
    screen.say(text, end="")
    for i, curve in enumerate(curves, 1):
        if curve.simulated_deg < curve.at(np.array([max(pressures)]))[0]:
            screen.say(f"fit {i}: simulated to {curve.simulated_deg:.0f}°, beyond as at its end")
    screen.say(f"prediction: {file}")


def _table(predicted: Prediction) -> str:
    """The CSV's text; a comment at its end tells the ballooning pressure."""
    lines = [f"{PRESSURE.name},{CHORD_ANGLE.name},low_deg,high_deg"]
    for pressure, (low, middle, high) in zip(
        predicted.pressure_kPa, predicted.angle_deg.T, strict=True
    ):
        lines.append(f"{pressure:g},{middle:z.2f},{low:z.2f},{high:z.2f}")
    low, middle, high = predicted.ballooning_kPa
    lines.append(
        f"# ballooning pressure {middle:.2f} kPa, 90 % interval {low:.2f} to {high:.2f} kPa"
    )
    return "\n".join(lines) + "\n"
