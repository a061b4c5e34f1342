"""``dolfingrip predict``: predict an actuator that was never measured, with an interval."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dolfingrip import config as configuration
from dolfingrip.channels import CHORD_ANGLE, PRESSURE
from dolfingrip.cli.options import Out, Overrides, check_writable, console, one_process
from dolfingrip.config import ConfigError
from dolfingrip.files import whole


def predict(
    source: Annotated[
        Path, typer.Option("--from", metavar="FILE", help="Configuration with a \\[posterior].")
    ],
    out: Out = Path("out/prediction"),
    overrides: Overrides = None,
    pressures: Annotated[
        str, typer.Option("--pressures", metavar="kPa,kPa,…", help="Where to predict the angle.")
    ] = "",
    csv: Annotated[
        Path | None,
        typer.Option("--csv", metavar="FILE", help="Table; default: prediction.csv in --out."),
    ] = None,
) -> None:
    """Predict an actuator from fits to others: angle and ballooning pressure, 90 % intervals."""
    one_process("without mpirun")
    import numpy as np

    from dolfingrip.cli import progress
    from dolfingrip.experiments import prediction
    from dolfingrip.sections import posterior

    asked = _pressures(pressures)
    fits = posterior.read(source)
    config = configuration.load(source, dict(overrides or ()))
    config = config.changed(experiment={"max_pressure_kPa": 1.15 * max(asked)})
    check_writable(out)
    screen = console()
    with progress.shown(screen, "fits", total=len(fits.fit)) as show:
        curves = prediction.simulated(
            config, fits, out,
            lambda i, row: show(i, len(fits.fit), f"{row['pressure_kPa']:.1f} kPa"),
        )  # fmt: skip
    found = prediction.predict(curves, fits, np.array(asked))
    file = csv or out / "prediction.csv"
    text = _table(found)
    whole.write(file, text)
    screen.print(text, end="", soft_wrap=True)
    for i, curve in enumerate(curves, 1):
        if curve.simulated_deg < curve.at(np.array([max(asked)]))[0]:
            screen.print(
                f"fit {i}: simulated to {curve.simulated_deg:.0f}°, beyond as at its end",
                soft_wrap=True,
            )
    screen.print(f"prediction: {file}", soft_wrap=True)


def _pressures(text: str) -> list[float]:
    try:
        found = [float(part) for part in text.split(",") if part.strip()]
    except ValueError:
        found = []
    if not found or min(found) <= 0:
        raise ConfigError(f"--pressures {text}: allowed: numbers above 0 kPa, joined by commas")
    return found


def _table(found: object) -> str:
    """The CSV's text; a comment at its end tells the ballooning pressure."""
    from dolfingrip.experiments.prediction import Prediction

    assert isinstance(found, Prediction)
    lines = [f"{PRESSURE.name},{CHORD_ANGLE.name},low_deg,high_deg"]
    for pressure, (low, middle, high) in zip(found.pressure_kPa, found.angle_deg.T, strict=True):
        lines.append(f"{pressure:g},{middle:z.2f},{low:z.2f},{high:z.2f}")
    low, middle, high = found.ballooning_kPa
    lines.append(
        f"# ballooning pressure {middle:.2f} kPa, 90 % interval {low:.2f} to {high:.2f} kPa"
    )
    return "\n".join(lines) + "\n"
