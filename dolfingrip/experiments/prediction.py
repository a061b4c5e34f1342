"""Predict an actuator that was never measured, with the uncertainty that fits to others left.

Each fit that agrees with the measurements is simulated. The prediction is a sample of four sources
of scatter: the fits by their probabilities, the deviation of a specimen, what no fit explained, and
the noise of the readings. The second and third are pressures at equal angle, because a small change
of pressure doubles the angle where chambers balloon.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip import config as configuration
from dolfingrip.channels import CAVITY_VOLUME, PRESSURE
from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.experiments.loop import run
from dolfingrip.experiments.results.readings import Row
from dolfingrip.files.run import RunFile
from dolfingrip.sections.posterior import PosteriorTable

QUANTILES: Final = (0.05, 0.5, 0.95)
"""Ends of a 90 % interval, and the median between them."""

SAMPLES: Final = 4000
"""Size of the sample; its quantiles are accurate to 2 % of the spread."""

FURTHER: Final = 1.5
"""Factor of the cavity's growth to which a path is extrapolated: large balloons grow evenly."""

POINTS: Final = 4000
"""Points of a curve; it is straight between them."""


@dataclass(frozen=True, slots=True)
class PressureCurve:
    """Angle against pressure of one simulation, for a pressure that only rises.

    If the simulated pressure falls, the angle jumps at the greatest pressure so far. Beyond its end
    a curve is extrapolated with the slope of its last part.

    Attributes:
        pressure_kPa: (n,) rising pressures.
        angle_deg: (n,) angles.
        simulated_deg: the largest angle that was simulated.
    """

    pressure_kPa: np.ndarray
    angle_deg: np.ndarray
    simulated_deg: float = np.inf

    @classmethod
    def of(cls, pressure_kPa: np.ndarray, angle_deg: np.ndarray) -> PressureCurve:
        """Make a curve from readings in their order.

        Args:
            pressure_kPa: (n,) pressures.
            angle_deg: (n,) angles.
        """
        place = np.arange(len(pressure_kPa), dtype=float)
        fine = np.linspace(0.0, place[-1], POINTS)
        pressure = np.interp(fine, place, pressure_kPa)
        angle = np.interp(fine, place, angle_deg)
        rising = pressure >= np.maximum.accumulate(pressure)
        return cls(pressure[rising], angle[rising])

    def at(self, pressure_kPa: np.ndarray) -> np.ndarray:
        """Angles (deg) at pressures (kPa)."""
        angle_deg = np.interp(pressure_kPa, self.pressure_kPa, self.angle_deg)
        beyond = np.maximum(pressure_kPa - self.pressure_kPa[-1], 0.0)
        return np.asarray(angle_deg + beyond * self._last_slope())

    def _last_slope(self) -> float:
        start = 0.9 * self.pressure_kPa[-1]
        rise = self.angle_deg[-1] - np.interp(start, self.pressure_kPa, self.angle_deg)
        return float(rise / (self.pressure_kPa[-1] - start))

    @property
    def ballooning_kPa(self) -> float:
        """Pressure (kPa) at which the angle rises the fastest, over 2 % of the pressure."""
        width = 0.02 * self.pressure_kPa[-1]
        middle = np.linspace(width, self.pressure_kPa[-1] - width, POINTS)
        rise = self.at(middle + width / 2) - self.at(middle - width / 2)
        return float(middle[rise.argmax()])


@dataclass(frozen=True, slots=True)
class Prediction:
    """Quantiles of a sample; see :data:`QUANTILES`.

    Attributes:
        pressure_kPa: (n,).
        angle_deg: (3, n).
        ballooning_kPa: (3,).
    """

    pressure_kPa: np.ndarray
    angle_deg: np.ndarray
    ballooning_kPa: np.ndarray


def predict(
    curves: Sequence[PressureCurve],
    posterior: PosteriorTable,
    pressure_kPa: np.ndarray,
) -> Prediction:
    """Predict from the simulated curve of each fit.

    Args:
        curves: one for each fit.
        posterior: the fits, and what they left.
        pressure_kPa: (n,) pressures at which angles are predicted.
    """
    random = np.random.default_rng(0)
    which = random.choice(len(curves), SAMPLES, p=posterior.shares)
    factor = 1 + posterior.specimen * random.standard_normal(SAMPLES)
    shift = posterior.model_kPa * random.standard_normal(SAMPLES)
    noise = posterior.reading_deg * random.standard_normal((SAMPLES, len(pressure_kPa)))
    gain = 1 + posterior.angle * random.standard_normal((SAMPLES, 1))
    angles = np.empty((SAMPLES, len(pressure_kPa)))
    for i, curve in enumerate(curves):
        drawn = which == i
        felt = (pressure_kPa - shift[drawn, None]) / factor[drawn, None]
        angles[drawn] = curve.at(np.maximum(felt, 0.0))
    at = np.array([curve.ballooning_kPa for curve in curves])[which] * factor + shift
    return Prediction(
        pressure_kPa,
        np.quantile(gain * angles + noise, QUANTILES, axis=0),
        np.quantile(at, QUANTILES),
    )


def simulated(
    config: Config,
    posterior: PosteriorTable,
    out: Path,
    progress: Callable[[int, Row], None] = lambda place, row: None,
) -> list[PressureCurve]:
    """Return the curve of each fit, and simulate those that have no finished folder.

    Args:
        config: of the actuator.
        posterior: the fits.
        out: folder, in which each fit has one.
        progress: called with the fit's number, from 0 on, and each new row.

    Raises:
        ConfigError: bad input, in one line.
    """
    curves = []
    for i, fit in enumerate(posterior.fit):
        fit_config = changed(config, fit.set)
        first = next(j for j, other in enumerate(posterior.fit) if other.set == fit.set)
        folder = out / f"fit-{first + 1}"
        if not is_simulated(folder, fit_config):
            run("bending", fit_config, out=folder, progress=lambda row, i=i: progress(i, row))  # type: ignore[misc]
        rows = pd.read_csv(folder / "result.csv")
        if len(rows) < 3:
            raise ConfigError(
                f"fit {i + 1} of {len(posterior.fit)}: its simulation ends at once; "
                f"{folder / 'run.json'} says why"
            )
        volume = rows[CAVITY_VOLUME.name].to_numpy()
        growth, pressure, angle = further(
            volume / volume[0], rows[PRESSURE.name].to_numpy(), rows[posterior.reading].to_numpy()
        )
        curve = PressureCurve.of(pressure * fit.correction(growth), angle)
        curves.append(replace(curve, simulated_deg=float(rows[posterior.reading].max())))
    return curves


def further(
    growth: np.ndarray,
    pressure_kPa: np.ndarray,
    angle_deg: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Readings of a path, extrapolated with the cavity's growth in the last tenth of the path."""
    start = growth[-1] - 0.1 * (growth[-1] - growth[0])
    ratio = FURTHER * (growth[-1] - growth[0]) / (growth[-1] - start)
    return tuple(
        np.append(path, path[-1] + ratio * (path[-1] - np.interp(start, growth, path)))
        for path in (growth, pressure_kPa, angle_deg)
    )  # type: ignore[return-value]


def is_simulated(folder: Path, config: Config) -> bool:
    """Return whether a folder holds a finished simulation of a configuration.

    Args:
        folder: of the simulation.
        config: that it must have.
    """
    if not RunFile.is_in(folder):
        return False
    run_file = RunFile.read(folder)
    return run_file.wall_s is not None and configuration.from_dict(run_file.config) == config
