"""Two measured actuators, and their simulations by each hypothesis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd
from laws import Hypothesis, changes
from scipy.interpolate import PchipInterpolator

from dolfingrip.config import Config, changed
from dolfingrip.experiments import run
from dolfingrip.experiments.prediction import PressureCurve, is_simulated

HERE = Path(__file__).resolve().parent
OUT = Path("out") / "ecoflex_actuators"

CHAMBERS = {"c5-w7": 5, "c7-w7": 7}
MOST_GROWTH = {"c5-w7": 70, "c7-w7": 80}
"""Of the cavity: beyond nearly all measured angles."""


def measured(specimen: str) -> tuple[np.ndarray, np.ndarray]:
    """Pressures (kPa) and rising angles (deg) above 11 kPa, where the ramp begins."""
    table = pd.read_csv(HERE / "bending.csv")
    table = table[(table["specimen"] == specimen) & (table["pressure_kPa"] > 11)]
    return table["pressure_kPa"].to_numpy(), table["chord_angle_deg"].cummax().to_numpy()


def simulated(base: Config, tried: Hypothesis, modulus_MPa: float, specimen: str) -> pd.DataFrame:
    """A free bending, from its folder where it is simulated."""
    own = changed(base, changes(tried, modulus_MPa)).changed(
        cast={"chambers": CHAMBERS[specimen]},
        experiment={"max_volume_ratio": MOST_GROWTH[specimen]},
    )
    name = (
        f"{specimen}{tried.exponent:g}-{modulus_MPa:g}-{tried.film_N_per_mm:g}-{tried.width_mm:g}"
    )
    folder = OUT / name
    if not is_simulated(folder, own):
        print(f"simulating {name}", flush=True)
        run("bending", own, out=folder)
    return pd.read_csv(folder / "result.csv")


@dataclass(frozen=True)
class Family:
    """A hypothesis, simulated as one specimen with both moduli.

    Attributes:
        moduli_MPa: both.
        paths: pressure (kPa), rising angle (deg) and growth of the cavity of each, (3, n).
    """

    moduli_MPa: tuple[float, float]
    paths: tuple[np.ndarray, np.ndarray]

    @property
    def largest_deg(self) -> float:
        """Angle that both reach."""
        return float(min(path[1, -1] for path in self.paths))

    @cached_property
    def _by_angle(self) -> tuple[PchipInterpolator, ...]:
        return tuple(PchipInterpolator(path[1], path[[0, 2]], axis=1) for path in self.paths)

    def pressure_kPa(self, modulus_MPa: float, angle_deg: np.ndarray) -> np.ndarray:
        """Pressures at angles, (n,), linear in the logarithm of the modulus."""
        return self._between(modulus_MPa, angle_deg)[0]

    def growth(self, modulus_MPa: float, angle_deg: np.ndarray) -> np.ndarray:
        """The cavity's volume by that at rest at angles, (n,), likewise."""
        return self._between(modulus_MPa, angle_deg)[1]

    def _between(self, modulus_MPa: float, angle_deg: np.ndarray) -> np.ndarray:
        low, high = np.log(self.moduli_MPa)
        part = (np.log(modulus_MPa) - low) / (high - low)
        one, other = (each(angle_deg) for each in self._by_angle)
        return np.asarray(one + part * (other - one))

    def curve(self, modulus_MPa: float, scale: float) -> PressureCurve:
        """Curve that is seen as the pressure rises."""
        angle = np.linspace(0.0, self.largest_deg, 2000)
        return PressureCurve.of(scale * self.pressure_kPa(modulus_MPa, angle), angle)


def family(base: Config, tried: Hypothesis, specimen: str) -> Family:
    """Both simulations of a specimen."""
    one, other = (_path(simulated(base, tried, mu, specimen)) for mu in tried.moduli_MPa)
    return Family(tried.moduli_MPa, (one, other))


def _path(table: pd.DataFrame) -> np.ndarray:
    names = ["pressure_kPa", "chord_angle_deg", "cavity_volume_mm3"]
    path = table[names].to_numpy(dtype=float).T
    path[2] /= path[2, 0]
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(path[1])) > 0])
    return path[:, rising]
