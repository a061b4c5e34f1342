"""``dolfingrip train``: train a surrogate on a campaign or a table."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import check_writable, console, one_process
from dolfingrip.cli.settings import TrainSettings
from dolfingrip.config import ConfigError
from dolfingrip.design.surrogate import surrogate, training
from dolfingrip.design.surrogate import table as designs
from dolfingrip.design.surrogate.training import Training, TrainingPolicy, TrainingSettings
from dolfingrip.files import table
from dolfingrip.report import design as pictures


def train(asked: TrainSettings) -> None:
    """Train a neural network on the designs of a campaign."""
    one_process("one process")

    facts = designs.campaign(asked.source) or {}
    inputs = asked.inputs or tuple(facts.get("parameters", ()))
    outputs = asked.outputs or tuple(facts.get("quantities", ()))
    if not inputs or not outputs:
        raise ConfigError("--input, --output: allowed: names of columns with a table")
    data = designs.read(asked.source, inputs, outputs)
    settings = TrainingSettings(epochs=asked.epochs, seed=asked.seed)
    check_writable(asked.out)
    screen = console()
    screen.say(
        f"{len(data)} designs; {data.failed} failed and {data.incomplete} incomplete ones left out"
    )
    if _trained(asked.out, data, settings):
        screen.say(f"already trained on this table: {asked.out}")
        return
    with progress.shown(screen, "epochs") as show:
        result = training.train(
            data, settings, lambda done: show(done, asked.epochs), campaign=facts or None
        )
    _write(result, data, asked.out)
    said = result.surrogate.facts
    goal = TrainingPolicy().goal_mse
    for part in ("training", "test"):
        mse = getattr(said, f"{part}_mse")
        verdict = "" if mse < goal else f", above the goal of {goal:g}"
        rms = {name: getattr(each, part) for name, each in said.rms_error.items()}
        errors = ", ".join(f"{name} {value:.3g}" for name, value in rms.items())
        count = getattr(said, f"{part}_designs")
        screen.say(f"{part}: {count} designs, MSE {mse:.2e}{verdict}; RMS error {errors}")
    screen.say(f"surrogate: {asked.out}")


def _trained(out: Path, data: designs.Table, settings: TrainingSettings) -> bool:
    """True where the folder holds this training's result; its description is written last."""

    try:
        facts = surrogate.load(out).facts
    except ConfigError:
        return False
    same = json.loads(json.dumps(asdict(settings)))
    return facts.table_sha256 == data.sha256() and facts.settings == same


def _write(result: Training, data: designs.Table, out: Path) -> None:

    curve = zip(result.epoch, result.training_mse, result.test_mse, strict=True)
    table.write(
        out / "learning_curve.csv",
        [
            {"epoch": int(epoch), "training_mse": float(known), "test_mse": float(unseen)}
            for epoch, known, unseen in curve
        ],
    )
    learnt = {
        "epoch": result.epoch, "training_mse": result.training_mse, "test_mse": result.test_mse,
    }  # fmt: skip
    chart = pictures.learning_curve(learnt, TrainingPolicy().goal_mse)
    picture.write([chart], out / "learning_curve.png")
    predicted = result.surrogate.predict(data.inputs)
    fits = pictures.fit(data.output_names, data.outputs, predicted, result.test)
    picture.write(fits, out / "fit.png", picture.Look(panel_in=(4.0, 4.0)))
    names = (*data.input_names, *data.output_names)
    guesses = [f"surrogate.{name}" for name in data.output_names]
    table.write(
        out / "designs.csv",
        [
            {
                **dict(zip(names, [*map(float, x), *map(float, y)], strict=True)),
                **dict(zip(guesses, map(float, guess), strict=True)),
                "set": "test" if held_out else "training",
            }
            for x, y, guess, held_out in zip(
                data.inputs, data.outputs, predicted, result.test, strict=True
            )
        ],
    )
    result.surrogate.save(out)
