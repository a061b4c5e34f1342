"""A made-up finger for the statistics: readings, nuisances and effects as smooth columns.

Import it as ``from diagnosis.inference import synthetic`` (tests are on the path).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.special import softmax

from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import ChannelNoise, noise_matrix
from dolfingrip.diagnosis.inference.screen import Screen

NOISE = {"angle_deg": ChannelNoise(0.3), "force_N": ChannelNoise(0.02)}
CHANNELS = {"angle_deg": "bending", "force_N": "blocked_force"}


def index(specimens: int = 1, cycles: int = 1, points: int = 11) -> pd.DataFrame:
    """Loading and unloading in each cycle, 10 s between readings."""
    rows = []
    for specimen in range(specimens):
        for channel, experiment in CHANNELS.items():
            time_s = 0.0
            for cycle in range(1, cycles + 1):
                for branch in ("loading", "unloading"):
                    pressures = np.linspace(0, 250, points)
                    for pressure in pressures if branch == "loading" else pressures[::-1]:
                        time_s += 10.0
                        rows.append(
                            {
                                "channel": channel,
                                "run": f"{experiment} {specimen}",
                                "experiment": experiment,
                                "specimen": f"finger {specimen}",
                                "cycle": cycle,
                                "branch": branch,
                                "time_s": time_s,
                                "pressure_kPa": float(pressure),
                            }
                        )
    return pd.DataFrame(rows)


def base(table: pd.DataFrame) -> np.ndarray:
    """Angle (deg) and force (N) of the simple model."""
    x = load(table)
    return np.where(is_angle(table), 140 * x**1.3, 3.7 * x**1.2)


def load(table: pd.DataFrame) -> np.ndarray:
    return table["pressure_kPa"].to_numpy() / 250


def is_angle(table: pd.DataFrame) -> np.ndarray:
    return (table["channel"] == "angle_deg").to_numpy()


def nuisances(table: pd.DataFrame) -> np.ndarray:
    """A stiffness of 5 % and an offset of pressure of 2 kPa."""
    x, y = load(table), base(table)
    slope = np.where(is_angle(table), 1.3 * 140 * x**0.3, 1.2 * 3.7 * x**0.2)
    return np.column_stack([0.05 * y, 2 / 250 * slope])


def covariance(table: pd.DataFrame, noise: dict[str, ChannelNoise] | None = None) -> Covariance:
    return Covariance.of(noise_matrix(table, noise or NOISE)).widened(nuisances(table))


def noise_std(table: pd.DataFrame, noise: dict[str, ChannelNoise] | None = None) -> np.ndarray:
    each = noise or NOISE
    return np.array([each[channel].total_std() for channel in table["channel"]])


def columns(table: pd.DataFrame) -> dict[str, np.ndarray]:
    """Changes by eight effects at ordinary strength; the first two are tied."""
    x, y, angle = load(table), base(table), is_angle(table)
    down = (table["branch"] == "unloading").to_numpy()
    late = (table["cycle"] > 1).to_numpy()
    unit = np.where(angle, 0.3, 0.02)
    touch = np.maximum(x - 0.56, 0)
    friction = np.where(angle, 0.0, y * (0.03 - 0.1 * x) * np.where(down, -0.7, 1.0))
    return {
        "plate_friction": friction,
        "no_self_contact": friction + 0.15 * unit * np.sin(9 * x),
        "hardening": unit * 12 * x**3,
        "softening": unit * 7 * np.sin(np.pi * x) * np.where(angle, 1.0, 0.4),
        "prony": unit * 6 * down * x * (1 - x) * 4,
        "set": unit * 6 * np.where(down | late, 1 - 0.6 * x, 0.0),
        "kink": np.where(angle, 0.0, 0.5 * touch),
        "plate_tilt": np.where(angle, 0.0, unit * 6 * np.cos(7 * x)),
    }


def candidates(table: pd.DataFrame) -> list[Candidate]:
    return [
        Candidate(name, (Shape(change),), mean=1.0, spread=0.5, one_sided=True)
        for name, change in columns(table).items()
    ]


def screen(table: pd.DataFrame, noise: dict[str, ChannelNoise] | None = None) -> Screen:
    return Screen(candidates(table), covariance(table, noise))


def exact_posterior(
    residual: np.ndarray,
    candidates: Sequence[Candidate],
    covariance: Covariance,
    none: float = 0.0,
) -> np.ndarray:
    """Probability of no cause and of each candidate alone, shape (1 + candidates,), sum 1.

    ``none`` is the weight of no cause by that of one candidate.
    """
    logs = Screen(candidates, covariance).log_evidence(covariance.whiten(residual)[:, None])[:, 0]
    first = np.log(none) if none > 0 else -np.inf
    return np.asarray(softmax(np.concatenate([[first], logs])))
