"""Ask what few numbers the readings of two pneu-nets leave: simulations scaled, and least squares.

An elastic body's angle and force scale exactly with its moduli, α(p; cμ) = α(p / c; μ) and
F(p; cμ) = c F(p / c; μ), so one simulation serves all moduli. The printed pneu-net's angle is read
as the tip's and as the chord's, with and without a zero of the angle. n of the cast ones press:

    F(p, g) = n max(F₀(p − p₀) − k (g + g₀), 0),

where F₀ is the force without a gap and k the tip's stiffness, both simulated.

    scripts/run python examples/measured_pneunets/readings.py printed cast
    scripts/run python examples/measured_pneunets/fit.py docs/measured_pneunets.png
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from dolfingrip import config
from dolfingrip.experiments import run

mpl.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).resolve().parent
TABLES = Path("out/measured_pneunets")
ANGLES = {"angle_deg": "tip face", "chord_angle_deg": "chord"}
COUPON_MPa = 4.95
"""Shear modulus of examples/coupons/ninjaflex_uniaxial.csv by neo-Hooke's law."""
GAP_mm, FURTHER_mm = 2.0, 6.0
"""Gaps whose simulation tells the tip's stiffness, and checks that the force falls evenly."""
MEMBERS = range(1, 7)

Model = Callable[[np.ndarray], np.ndarray]


def fitted(model: Model, start: list[float], free: list[bool]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers by least squares, those that are not free being 0, and what is left."""
    at = np.array(free, dtype=float)
    found = least_squares(lambda x: model(x * at), start)
    return found.x * at, found.fun


def rms(left: np.ndarray) -> float:
    return float(np.sqrt(np.mean(left**2)))


def _turned(
    curve: CubicSpline, pressure: np.ndarray, angle: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Differences of an angle from a curve with moduli times exp(x₀) and a zero of x₁, (n,)."""
    return np.asarray(curve(pressure / np.exp(x[0])) + x[1] - angle)


def printed(axes: Any) -> None:
    """The angle as two of its kinds, by a factor of the modulus and a zero."""
    setup = config.load(HERE / "printed.toml", {"experiment.max_pressure_kPa": 450.0,
                                                "experiment.step_kPa": 25.0})  # fmt: skip
    bent = run("bending", setup)
    factor = setup.material.mu_MPa / COUPON_MPa
    for source, name in (("tip", "measured"), ("author", "simulated by its maker")):
        table = pd.read_csv(TABLES / "printed" / f"{source}.csv").iloc[1:]
        pressure, angle = (table[each].to_numpy() for each in ("pressure_kPa", "angle_deg"))
        marks = "o" if source == "tip" else "x"
        axes.plot(pressure, angle, marks, color="black", mfc="none", ms=4, label=name)
        for column, kind in ANGLES.items():
            curve = CubicSpline(bent.column("pressure_kPa") / factor, bent.column(column))
            for zero in (False, True):
                model = partial(_turned, curve, pressure, angle)
                (log, off), left = fitted(model, [0.5, 0.0], [True, zero])
                print(
                    f"{name}, {kind}: moduli {np.exp(log):.2f} times the coupons', zero "
                    f"{off:+.1f}°, left {rms(left):.2f}° rms, {np.abs(left).max():.1f}° at most"
                )
                if zero and source == "tip":
                    axes.plot(
                        pressure,
                        angle + left,
                        label=f"{kind}, moduli × {np.exp(log):.1f}, zero {off:+.1f}°",
                    )
    axes.set(xlabel="Pressure (kPa)", ylabel="Angle (°)", title="Printed")
    axes.legend(fontsize=7)


def cast(axes: Any) -> None:
    """The force at all gaps, by a modulus, the number that press, and the scale's place."""
    model = config.load(HERE / "cast.toml", {"experiment.step_kPa": 12.0, "experiment.snaps": False,
                                             "experiment.max_pressure_kPa": 180.0})  # fmt: skip
    touched = {gap: run("blocked_force", model.changed(plate={"gap_mm": gap}))
               for gap in (0.0, GAP_mm, FURTHER_mm)}  # fmt: skip
    pressure = touched[0.0].column("pressure_kPa")
    force = {gap: each.column("force_N") for gap, each in touched.items()}
    own = force[GAP_mm] > 0.05 * force[GAP_mm].max()
    stiffness = float(np.mean((force[0.0] - force[GAP_mm])[own]) / GAP_mm)
    mu_MPa = model.material.mu_MPa
    off = (np.maximum(force[0.0] - FURTHER_mm * stiffness, 0) - force[FURTHER_mm])[pressure < 113]
    print(
        f"tip's stiffness {stiffness / mu_MPa:.4f} N/mm for each MPa of the shear modulus; "
        f"{FURTHER_mm:g} mm away off by {np.abs(off).max():.3f} N at most"
    )
    at_rest = CubicSpline(pressure, force[0.0])
    rows = pd.read_csv(TABLES / "cast1" / "every.csv")
    p, gap, read = (rows[each].to_numpy() for each in ("pressure_kPa", "gap_mm", "force_N"))

    def model_of(n: int, x: np.ndarray, p: np.ndarray, gap: np.ndarray) -> np.ndarray:
        c = np.exp(x[0])
        return n * c * np.maximum(at_rest((p - x[2]) / c) - stiffness * (gap + x[1]), 0.0)

    for what, free in {"the scale's place": [True, True, False],
                       "the regulator's zero": [True, False, True]}.items():  # fmt: skip
        for n in MEMBERS:
            x, left = fitted(lambda x, n=n: model_of(n, x, p, gap) - read, [0.1, 1.0, 10.0], free)
            print(f"{n} press, {what}: μ {mu_MPa * np.exp(x[0]):.2f} MPa, {x[1]:+.1f} mm, "
                  f"{x[2]:+.0f} kPa, left {rms(left[read > 0]):.3f} N rms")  # fmt: skip
            if free[1] and n in (1, 4):
                for each in range(6):
                    line = np.linspace(12, 113, 60)
                    label = (
                        f"{n} press, {mu_MPa * np.exp(x[0]):.1f} MPa, {x[1]:+.1f} mm"
                        if each == 0
                        else None
                    )
                    axes.plot(line, model_of(n, x, line, np.full(60, each)), lw=0.9, label=label,
                              color="#0072b2" if n == 4 else "#999999")  # fmt: skip
    axes.plot(p, read, "o", color="black", mfc="none", ms=2, label="measured, 0 to 5 mm")
    axes.set(xlabel="Pressure (kPa)", ylabel="Force (N)", title="Cast")
    axes.legend(fontsize=7)


def main(picture: Path) -> None:
    """Print both tables and draw them."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.6), constrained_layout=True)
    printed(left)
    cast(right)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
