"""What the diagnosis of printed NinjaFlex coupons changes on the finger.

    scripts/run dolfingrip diagnose examples/coupons/ninjaflex_uniaxial.csv --out out/ninjaflex
    scripts/run python docs/pictures/ninjaflex_finger.py --diagnosis out/ninjaflex

prints the angle and the blocked force of the reference finger as configured, with the modulus that
the coupons tell, and with each cause that they cannot tell apart; and draws
``docs/ninjaflex_finger.png``. The first cause's curves are those of ``dolfingrip bend`` and
``dolfingrip force`` with ``--config out/ninjaflex/extended.toml``.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt

from dolfingrip import config as configuration
from dolfingrip.charts import theme
from dolfingrip.config import Config
from dolfingrip.experiments import Result, run
from dolfingrip.files.diagnosis import DiagnosisFile, FittedHypothesis
from dolfingrip.sections.tables import assignments

PICTURE = Path(__file__).resolve().parents[1] / "ninjaflex_finger.png"
EXPERIMENTS = {"bending": "angle_deg", "blocked_force": "force_N"}
LABELS = {"angle_deg": "Tip angle (°)", "force_N": "Blocked force (N)"}
PRINTED_kPa = (50, 100, 200, 250)
STYLES = ((theme.INK, "s"), (theme.GREEN, "^"), (theme.BLUE, "o"), (theme.ORANGE, "v"))


def materials(found: DiagnosisFile) -> Iterator[tuple[str, Config]]:
    """Configurations by name: before, and after."""
    yield "as configured", Config()
    for fit in found.fits:
        if not fit.effects:
            yield "its modulus fitted", fitted(fit)
    for fit in found.fits:
        if len(fit.effects) == 1 and fit.effects[0] in found.verdict.effects:
            yield fit.effects[0], fitted(fit)


def fitted(fit: FittedHypothesis) -> Config:
    """The reference finger of the material of a fit."""
    values = {parameter.key: parameter.value for parameter in fit.parameters}
    lists = ("extensions.prony.g", "extensions.prony.tau_s")
    return configuration.load(
        None,
        assignments(
            [f"{key}={[value] if key in lists else value}" for key, value in values.items()]
        ),
    )


def draw(curves: dict[str, dict[str, Result]], path: Path) -> None:
    """Angle and force against pressure, a line for each material."""
    with theme.figure_theme():
        figure, panels = plt.subplots(1, 2, figsize=(7.6, 3.3), layout="constrained")
        for axes, (experiment, column) in zip(panels, EXPERIMENTS.items(), strict=True):
            for (name, own), (colour, marker) in zip(curves.items(), STYLES, strict=False):
                result = own[experiment]
                pressure = result.column("pressure_kPa")
                axes.plot(
                    pressure, result.column(column), marker + "-", color=colour, ms=3, label=name
                )
            axes.set(xlabel="Pressure (kPa)", ylabel=LABELS[column], xlim=(0, None), ylim=(0, None))
        panels[0].legend(title="NinjaFlex")
        figure.savefig(path)
        plt.close(figure)


def main() -> None:
    """Compute, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--diagnosis", type=Path, default=Path("out/diagnosis"))
    found = DiagnosisFile.read(parser.parse_args().diagnosis)
    curves: dict[str, dict[str, Result]] = {}
    for name, config in materials(found):
        curves[name] = {}
        for experiment, column in EXPERIMENTS.items():
            result = run(experiment, config)
            if result.failure is not None:
                raise SystemExit(f"{name}, {experiment}: {result.failure.sentence()}")
            curves[name][experiment] = result
            read = dict(zip(result.column("pressure_kPa"), result.column(column), strict=True))
            values = ", ".join(f"{read[p]:.3g} at {p} kPa" for p in PRINTED_kPa)
            print(f"{name}: {column} {values}", flush=True)
    draw(curves, PICTURE)


if __name__ == "__main__":
    main()
