"""Fits what the coupon leaves open to measured bending, and writes it for ``dolfingrip predict``.

    scripts/run python examples/ecoflex_actuators/fit.py [--only NUMBER]

simulates each hypothesis (``laws.py``) as each specimen with two values of the modulus that the
coupon leaves open, or finds it simulated in ``out/``. Pressures at an equal angle are interpolated
between these values. They are in proportion to all moduli, whose factor is fitted, too. A fit to
one specimen predicts the other. Writes ``fits.csv``, ``predicted.csv`` and ``extended.toml``.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from laws import HYPOTHESES, Hypothesis, changes
from scipy.optimize import least_squares
from specimens import CHAMBERS, HERE, Family, family, measured

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.experiments.prediction import PressureCurve, predict
from dolfingrip.sections.posterior import PosteriorTable, WeightedFit, appended

MODEL_KPA, SPECIMEN, ANGLE, CAMERA_DEG, BATCH = 0.5, 0.03, 0.1, 0.3, 0.1
"""Standard deviations: of pressures at equal angles from a fit's; relative, of all moduli of one
specimen; relative, of the angle; of the camera; relative, of the coupon's moduli from those of the
batch that was cast."""

INDEPENDENT = 6.0
"""Readings that a curve is worth: what a fit leaves is smooth along it."""

GROWTH = (2, 3, 4, 6, 8, 11, 15, 20, 26, 33, 42, 52, 62, 72)
"""Of the cavity, where factors are told."""

LEAST = 0.01
"""Probability, by the best fit's, of those that are worth a simulation."""

HELD_KPA = 32.5
"""Up to this pressure the angle is compared: beyond, 1 kPa doubles it."""


@dataclass(frozen=True, slots=True)
class Fitted:
    """Modulus and scale that agree best with specimens.

    Attributes:
        modulus_MPa: of the term that the coupon leaves open.
        scale: of all moduli, relative to the coupon's.
        own: relative deviation of each specimen from that.
        misfit: half the sum of squares of all deviations, in standard deviations, of as many
            readings as are independent.
        rms_kPa: of pressures at equal angles above 6°.
    """

    modulus_MPa: float
    scale: float
    own: tuple[float, ...]
    misfit: float
    rms_kPa: float


def fitted(families: Sequence[Family], specimens: Sequence[str]) -> Fitted:
    """The best fit to these specimens together."""
    rows = []
    for found, specimen in zip(families, specimens, strict=True):
        pressure, angle = measured(specimen)
        slope = np.maximum(np.gradient(angle, pressure), 0.05)
        deviation = np.hypot(MODEL_KPA, CAMERA_DEG / slope)
        inside = angle <= found.largest_deg
        count = np.sqrt(INDEPENDENT / inside.sum())
        rows.append((found, pressure[inside], angle[inside], deviation[inside] / count))

    def apart_kPa(free: np.ndarray) -> list[np.ndarray]:
        scales = np.exp(free[1]) * (1 + free[2:])
        return [
            scale * found.pressure_kPa(np.exp(free[0]), angle) - pressure
            for scale, (found, pressure, angle, _) in zip(scales, rows, strict=True)
        ]

    def residuals(free: np.ndarray) -> np.ndarray:
        parts = [apart / row[3] for apart, row in zip(apart_kPa(free), rows, strict=True)]
        return np.concatenate([*parts, free[2:] / SPECIMEN, [free[1] / BATCH]])

    low, high = np.log(families[0].moduli_MPa)
    wide, many = high - low, len(specimens)
    best = least_squares(
        residuals, [(low + high) / 2, 0.1, *[0.0] * many],
        bounds=([low - wide, -1, *[-0.3] * many], [high + wide, 1, *[0.3] * many]),
    )  # fmt: skip
    above = [apart[row[2] > 6] for apart, row in zip(apart_kPa(best.x), rows, strict=True)]
    return Fitted(
        float(np.exp(best.x[0])), float(np.exp(best.x[1])), tuple(map(float, best.x[2:])),
        float(best.cost), float(np.sqrt(np.mean(np.concatenate(above) ** 2))),
    )  # fmt: skip


def posterior(fits: Mapping[Hypothesis, Fitted], specimens: int) -> PosteriorTable:
    """All fits by their probability, and what none of them explains.

    Args:
        fits: by hypothesis.
        specimens: number of those that were fitted, whose mean the next one deviates from.
    """
    least = min(each.misfit for each in fits.values())
    found = []
    for tried, each in fits.items():
        values = changes(tried, float(f"{each.modulus_MPa:.4g}"), each.scale)
        found.append(
            WeightedFit(weight=max(round(float(np.exp(least - each.misfit)), 4), 1e-4), set=values)
        )
    spread = float(f"{SPECIMEN * np.sqrt(1 + 1 / specimens):.3g}")
    return PosteriorTable(
        model_kPa=MODEL_KPA, specimen=spread, angle=ANGLE, reading_deg=CAMERA_DEG, fit=tuple(found)
    )


def predicted(
    fits: Mapping[Hypothesis, Fitted], families: Mapping[Hypothesis, Family], specimen: str
) -> tuple[pd.DataFrame, dict[str, object]]:
    """A specimen from fits to the other: interval at each reading, and how it agrees."""
    pressure, angle = measured(specimen)
    curves = [families[tried].curve(fit.modulus_MPa, fit.scale) for tried, fit in fits.items()]
    found = predict(curves, posterior(fits, 1), pressure)
    low, median, high = found.angle_deg
    held = pressure <= HELD_KPA
    table = pd.DataFrame(
        {
            "specimen": specimen, "pressure_kPa": pressure, "measured_deg": angle,
            "chord_angle_deg": median, "low_deg": low, "high_deg": high,
        }
    )  # fmt: skip
    return table.round(3), {
        "specimen": specimen,
        "ballooning_kPa": found.ballooning_kPa[1],
        "low_kPa": found.ballooning_kPa[0],
        "high_kPa": found.ballooning_kPa[2],
        "measured_kPa": PressureCurve.of(pressure, angle).ballooning_kPa,
        "rms_deg_to_32.5_kPa": np.sqrt(np.mean((median[held] - angle[held]) ** 2)),
        "inside": np.mean((low <= angle) & (angle <= high)),
    }


def fits_of(
    families: Mapping[Hypothesis, Mapping[str, Family]], names: Sequence[str]
) -> dict[Hypothesis, Fitted]:
    """The fit of each hypothesis to these specimens."""
    return {tried: fitted([own[name] for name in names], names) for tried, own in families.items()}


def table_of(fits: Mapping[Hypothesis, Fitted], names: Sequence[str]) -> pd.DataFrame:
    """A row for each fit."""
    shares = posterior(fits, len(names)).shares
    return pd.DataFrame(
        {
            "exponent": tried.exponent, "film_N_per_mm": tried.film_N_per_mm,
            "width_mm": tried.width_mm, "fitted_to": " ".join(names),
            "modulus_MPa": each.modulus_MPa, "scale": each.scale,
            "own": " ".join(f"{own:+.3f}" for own in each.own),
            "rms_kPa": each.rms_kPa, "misfit": each.misfit, "probability": share,
        }
        for (tried, each), share in zip(fits.items(), shares, strict=True)
    )  # fmt: skip


def write(
    base: Config,
    fits: Mapping[Hypothesis, Fitted],
    families: Mapping[Hypothesis, Mapping[str, Family]],
) -> None:
    """``extended.toml``: the best fit's configuration, and all fits that count.

    What a law gets wrong of a specimen is a factor on the pressure, by the growth of the cavity.
    """
    left = posterior(fits, len(CHAMBERS))
    best = max(left.fit, key=lambda each: each.weight)
    own = tuple(
        each.model_copy(update=factors(fits[tried], families[tried][name], name))
        for tried, each in zip(fits, left.fit, strict=True)
        if each.weight >= LEAST * best.weight
        for name in CHAMBERS
    )
    config = configuration.changed(base, best.set)
    found = left.model_copy(update={"fit": own, "specimen": SPECIMEN})
    text = appended(configuration.dumps(config), found)
    (HERE / "extended.toml").write_text(text, encoding="utf-8")


def factors(fit: Fitted, of: Family, specimen: str) -> dict[str, object]:
    """Measured pressure by a fit's at an equal angle, at :data:`GROWTH` of the cavity."""
    pressure, angle = measured(specimen)
    at = np.linspace(angle[0], min(angle[-1], of.largest_deg), 2000)
    factor = np.interp(at, angle, pressure) / (fit.scale * of.pressure_kPa(fit.modulus_MPa, at))
    growth = of.growth(fit.modulus_MPa, at)
    place = [each for each in GROWTH if growth[0] <= each <= growth[-1]]
    return {
        "growth": tuple(float(each) for each in place),
        "factor": tuple(round(float(each), 3) for each in np.interp(place, growth, factor)),
    }


def main() -> None:
    """Simulate, fit, print and write."""
    parser = argparse.ArgumentParser(description="Fits to two measured actuators.")
    parser.add_argument("--only", type=int, metavar="NUMBER", help="of a hypothesis, from 0")
    only = parser.parse_args().only
    base = configuration.load(HERE / "c5-w7.toml")
    families = {
        tried: {name: family(base, tried, name) for name in CHAMBERS}
        for number, tried in enumerate(HYPOTHESES)
        if only in (None, number)
    }
    both = tuple(CHAMBERS)
    tables, readings, agreement = [], [], []
    for name, other in (both, both[::-1]):
        fits = fits_of(families, [name])
        tables.append(table_of(fits, [name]))
        rows, told = predicted(fits, {t: own[other] for t, own in families.items()}, other)
        readings.append(rows)
        agreement.append(told)
    fits = fits_of(families, both)
    tables.append(table_of(fits, both))
    table = pd.concat(tables)
    print(table.to_string(index=False, float_format="%.4g"))
    print(pd.DataFrame(agreement).to_string(index=False, float_format="%.4g"))
    if only is None:
        table.to_csv(HERE / "fits.csv", index=False, float_format="%.5g", lineterminator="\n")
        pd.concat(readings).to_csv(HERE / "predicted.csv", index=False, lineterminator="\n")
        write(base, fits, families)


if __name__ == "__main__":
    main()
