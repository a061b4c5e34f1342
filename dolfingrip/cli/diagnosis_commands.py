"""``dolfingrip diagnose``, ``plan-experiment`` and ``predict``: model against measurement."""

from __future__ import annotations

import textwrap

import numpy as np
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.channels import CHORD_ANGLE, PRESSURE
from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import check_writable, console, one_process, resumable
from dolfingrip.cli.import_command import offered
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


def diagnose(asked: DiagnoseSettings) -> None:
    """Find out what the simulation gets wrong about measured data, and why."""
    one_process("--workers, without mpirun")

    resolved = configuration.load(asked.config, asked.overrides)
    check_writable(asked.out)
    screen = console()
    data = offered(asked.data, "diagnose", screen, asked.out)
    kept = asked.store or asked.out / "simulations"
    with resumable(screen, kept), progress.jobs(screen, "simulations") as show:
        chosen = diagnosing.DiagnosisSettings(
            asked.workers, kept, asked.quick, list(asked.effects) or None, asked.campaign,
            screen.say, show,
        )  # fmt: skip
        found = diagnosing.diagnose(data, resolved, asked.out, chosen)
    result = write(found, data, asked.out)

    pictures.draw(result.result, result.readings, asked.out)
    for line in lines(result.result):
        screen.say(line)
    screen.say(f"diagnosis: {asked.out}")


NAMES = 26
"""Width, in characters, to which cells are wrapped."""
LEFT = ("effect", "not told from", "addition", "newly named")
"""Columns that are aligned on the left."""


def tables(found: PlanFile) -> list[Table]:
    """The effects and the additions of a plan, for a terminal of 80 columns."""
    shown = []
    for each in found.tables():
        kept = [i for i, heading in enumerate(each.headings) if heading != "ordinary strength"]
        rows = [["\n".join(textwrap.wrap(row[i], NAMES)) for i in kept] for row in each.rows]
        shown.append(of_rows([each.headings[i] for i in kept], rows, each.title, LEFT))
    return shown


def plan_experiment(asked: PlanExperimentSettings) -> None:
    """Find which effects a rig could name, at which strength, and what to add to it."""
    one_process("--workers, without mpirun")

    resolved = configuration.load(asked.config, asked.overrides)
    check_writable(asked.out)
    screen = console()
    effects = list(asked.effects) or None
    check_effects(effects)
    check_noise(asked.noise)
    kept = asked.store or asked.out / "simulations"
    with resumable(screen, kept), progress.jobs(screen, "simulations") as show:
        chosen = diagnosing.DiagnosisSettings(
            asked.workers, kept, asked.quick, effects, say=screen.say, progress=show
        )
        found = planning.plan(asked.rig, resolved, asked.out, chosen, asked.changes, asked.noise)
    found.write(asked.out)
    text = plan_text(found)
    whole.write(asked.out / "plan.md", text)

    picture.write(plan_pictures.charts(found), asked.out / "plan.png", plan_pictures.look(found))
    screen.say(text.partition("\n|")[0].lstrip("# "))
    for table in tables(found):
        screen.print(table)
        screen.print()
    for warning in found.warnings:
        screen.say(f"- {warning}")
    screen.say(f"plan: {asked.out}")


def predict(asked: PredictSettings) -> None:
    """Predict an actuator from fits to others: angle and ballooning pressure, 90 % intervals."""
    one_process("without mpirun")

    pressures = asked.pressures
    if not pressures or min(pressures) <= 0:
        given = ",".join(f"{each:g}" for each in pressures)
        raise ConfigError(f"--pressures {given}: allowed: numbers above 0 kPa, joined by commas")
    fits = posterior.read(asked.source)
    config = configuration.load(asked.source, asked.overrides)
    config = config.changed(experiment={"max_pressure_kPa": 1.15 * max(pressures)})
    check_writable(asked.out)
    screen = console()
    with progress.shown(screen, "fits", total=len(fits.fit)) as show:
        curves = prediction.simulated(
            config, fits, asked.out,
            lambda i, row: show(i, len(fits.fit), f"{row['pressure_kPa']:.1f} kPa"),
        )  # fmt: skip
    found = prediction.predict(curves, fits, np.array(pressures))
    file = asked.csv or asked.out / "prediction.csv"
    text = _table(found)
    whole.write(file, text)
    screen.say(text, end="")
    for i, curve in enumerate(curves, 1):
        if curve.simulated_deg < curve.at(np.array([max(pressures)]))[0]:
            screen.say(f"fit {i}: simulated to {curve.simulated_deg:.0f}°, beyond as at its end")
    screen.say(f"prediction: {file}")


def _table(found: Prediction) -> str:
    """The CSV's text; a comment at its end tells the ballooning pressure."""
    lines = [f"{PRESSURE.name},{CHORD_ANGLE.name},low_deg,high_deg"]
    for pressure, (low, middle, high) in zip(found.pressure_kPa, found.angle_deg.T, strict=True):
        lines.append(f"{pressure:g},{middle:z.2f},{low:z.2f},{high:z.2f}")
    low, middle, high = found.ballooning_kPa
    lines.append(
        f"# ballooning pressure {middle:.2f} kPa, 90 % interval {low:.2f} to {high:.2f} kPa"
    )
    return "\n".join(lines) + "\n"
