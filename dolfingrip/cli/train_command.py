"""``dolfingrip train``: train a surrogate on a campaign or a table."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dolfingrip.cli.options import Out, check_writable, console, one_process
from dolfingrip.config import ConfigError

if TYPE_CHECKING:
    from dolfingrip.design.surrogate.table import Table
    from dolfingrip.design.surrogate.training import Settings, Training


def train(
    source: Annotated[
        Path, typer.Argument(metavar="FROM", help="Folder of a campaign, or .csv or .parquet.")
    ],
    out: Out = Path("out/surrogate"),
    inputs: Annotated[
        list[str] | None,
        typer.Option("--input", help="Column; repeatable. Default: morph.xi1 and morph.xi2."),
    ] = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option("--output", help="Column; repeatable. Default: cog_offset_mm and force_N."),
    ] = None,
    epochs: Annotated[int, typer.Option(min=1, help="Passes over the training designs.")] = 5000,
    seed: Annotated[int, typer.Option(min=0, help="Of the split and the first weights.")] = 0,
) -> None:
    """Train a neural network on the designs of a campaign."""
    one_process("one process")
    from dolfingrip.cli import progress
    from dolfingrip.design.surrogate import table, training

    data = table.read(source, inputs or table.INPUTS, outputs or table.OUTPUTS)
    settings = training.Settings(epochs=epochs, seed=seed)
    check_writable(out)
    screen = console()
    screen.print(
        f"{len(data)} designs; {data.failed} failed and {data.incomplete} incomplete ones left out",
        soft_wrap=True,
    )
    if _trained(out, data, settings):
        screen.print(f"already trained on this table: {out}", soft_wrap=True)
        return
    with progress.shown(screen, "epochs") as show:
        result = training.train(data, settings, lambda done: show(done, epochs))
    result.surrogate.facts["campaign"] = table.campaign(source)
    _write(result, data, out)
    facts = result.surrogate.facts
    for part in ("training", "test"):
        mse = facts[f"{part}_mse"]
        goal = training.JUDGEMENT.goal_mse
        verdict = "" if mse < goal else f", above the goal of {goal:g}"
        errors = ", ".join(f"{name} {rms[part]:.3g}" for name, rms in facts["rms_error"].items())
        screen.print(
            f"{part}: {facts[f'{part}_designs']} designs, MSE {mse:.2e}{verdict}; "
            f"RMS error {errors}",
            soft_wrap=True,
        )
    screen.print(f"surrogate: {out}", soft_wrap=True)


def _trained(out: Path, data: Table, settings: Settings) -> bool:
    """Whether the folder holds this training's result; its description is written last."""
    from dolfingrip.design.surrogate import surrogate

    try:
        facts = surrogate.load(out).facts
    except ConfigError:
        return False
    same = json.loads(json.dumps(asdict(settings)))
    return facts.get("table_sha256") == data.sha256() and facts.get("settings") == same


def _write(result: Training, data: Table, out: Path) -> None:
    from dolfingrip.charts import picture
    from dolfingrip.design.surrogate.training import JUDGEMENT
    from dolfingrip.files import table
    from dolfingrip.report import design as pictures

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
    chart = pictures.learning_curve(learnt, JUDGEMENT.goal_mse)
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
