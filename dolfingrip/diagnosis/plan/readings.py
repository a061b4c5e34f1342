"""The readings that a rig would take: covariance, changes by effects, and two sets joined."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.channels import PRESSURE
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.noise import noise as instrument_noise
from dolfingrip.diagnosis.inference.arrays import Matrix
from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import ChannelNoise, noise_matrix
from dolfingrip.diagnosis.inference.readings import load
from dolfingrip.diagnosis.simulation import secants
from dolfingrip.diagnosis.simulation.base import BaseSimulation, simulate_base
from dolfingrip.diagnosis.simulation.nuisances import Nuisance
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.sections.geometry.index import TABLES

LAW_LENGTH: Final = 0.3
"""Length of the error of a material's law, as part of the largest travel: exp(−distance), so of any
shape, smooth or not."""

LONG: Final = 1e6
"""Correlation over the whole run, in seconds."""


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings to be, n of them.

    Attributes:
        index: table of the readings.
        noise: Σ, shape (n, n).
        noise_std: of each, shape (n,).
        nuisances: change by one standard deviation of each, shape (n,), by name.
        mesh: what the mesh gets wrong, shape (n,).
        laws: what laws of materials get wrong, in columns, shape (n, l).
        candidates: changes by the effects of the catalogue.
    """

    index: pd.DataFrame
    noise: Matrix
    noise_std: np.ndarray
    nuisances: dict[str, np.ndarray]
    mesh: np.ndarray
    laws: Matrix
    candidates: Sequence[Candidate]

    @property
    def covariance(self) -> Covariance:
        """Of noise, nuisances and errors."""
        columns = [change[:, None] for change in self.nuisances.values()]
        mesh = self.mesh[:, None]
        return Covariance.of(self.noise).widened(np.hstack([mesh, self.laws, *columns]))


def simulated(
    measurement: Measurement, config: Config, workers: Workers, effects: Sequence[str]
) -> Readings:
    """The readings of a measurement to be, at the noise of its instruments.

    Raises:
        ConfigError: one line, where the base simulation does not reach all of them.
    """
    base = simulate_base(measurement, config, workers, effects=effects)
    if np.isnan(base.readings).any():
        why = "; ".join(dict.fromkeys(each.sentence for each in base.failures))
        raise ConfigError(f"the simulation does not reach all readings: {why}")
    index = index_of(measurement)
    told = instrument_noise(measurement)
    noise = {}
    for at, key in enumerate(noise_keys(index)):
        lasting = float(told.correlation_time_s[at])
        noise[key] = ChannelNoise(
            max(float(told.independent[at]), 1e-9), float(told.correlated[at]),
            lasting if np.isfinite(lasting) else LONG,
        )  # fmt: skip
    keys = noise_keys(index)
    gauge = np.abs(base.by_control) * told.control
    covariance = noise_matrix(index.assign(channel=keys), noise)
    covariance[np.diag_indices(len(covariance))] += gauge**2
    std = np.hypot([noise[key].total_std() for key in keys], gauge)
    nuisances = [*base.nuisance_list, *_slack(measurement, base, index)]
    return Readings(
        index, covariance, np.asarray(std), {each.name: each.change for each in nuisances},
        np.nan_to_num(base.mesh).sum(axis=1), _tolerance(measurement, base, index),
        [as_candidate(each) for each in base.candidates if len(each.shapes)],
    )  # fmt: skip


def _slack(measurement: Measurement, base: BaseSimulation, index: pd.DataFrame) -> list[Nuisance]:
    """Travel at which each coupon's force begins."""
    found = []
    for test in measurement.tests:
        std_mm = test.setup.nuisances["coupon_slack_mm"]
        if test.experiment == "coupon" and std_mm:
            mine = (index["run"] == test.number).to_numpy()
            change = np.where(mine, base.by_control * std_mm, 0.0)
            found.append(Nuisance(f"coupon_slack_mm of {test.specimen}", change))
    return found


def _tolerance(measurement: Measurement, base: BaseSimulation, index: pd.DataFrame) -> Matrix:
    """Smooth changes of coupons' readings that no simple law follows, shape (n, m).

    Those of the force and of the width are independent of one another.
    """
    coupons = (index["experiment"] == "coupon").to_numpy()
    channels = index["channel"].to_numpy()
    spreads = {t.number: t.setup.nuisances["material_law"] for t in measurement.tests}
    parts = [np.zeros((len(index), 0))]
    for name in dict.fromkeys(channels[coupons]):
        rows = coupons & (channels == name)
        std = np.array([spreads[number] for number in index["run"]]) * rows
        place, where = np.unique(np.round(load(index), 3), return_inverse=True)
        apart = (place[:, None] - place[None, :]) / LAW_LENGTH
        values, vectors = np.linalg.eigh(np.exp(-np.abs(apart)))
        keep = values > 1e-6 * values[-1]
        root = (vectors[:, keep] * np.sqrt(values[keep]))[where]
        parts.append(root * (std * np.abs(base.readings))[:, None])
    return np.hstack(parts)


def as_candidate(found: secants.Candidate) -> Candidate:
    """An effect's secants as the inference takes them."""
    # tried on both sides: each has a change of its own, and a strength above 0
    side = np.sign(found.parts)
    shapes = tuple(
        Shape(change * sign, label)
        for change, label, sign in zip(found.shapes, found.labels, side, strict=True)
    )
    one_sided = found.one_sided or bool((side < 0).any())
    return Candidate(found.name, shapes, spread=found.spread, one_sided=one_sided)


def index_of(measurement: Measurement) -> pd.DataFrame:
    """The table of single readings as the inference wants it, a row for each of ``listed()``."""
    listed = measurement.listed()
    rows = measurement.readings.iloc[listed["row"].to_numpy()].reset_index(drop=True)
    test = listed["test"].to_numpy()
    rates = {test.number: _pressure_rate(measurement, test) for test in measurement.tests}
    designs = {test.number: _design(test) for test in measurement.tests}
    return pd.DataFrame(
        {
            "channel": listed["column"].to_numpy(),
            "run": test,
            "experiment": listed["experiment"].to_numpy(),
            "specimen": listed["specimen"].to_numpy(),
            "design": np.array([designs[number] for number in test], dtype=object),
            "cycle": listed["cycle"].to_numpy(),
            "branch": listed["branch"].to_numpy(),
            "time_s": listed["time_s"].to_numpy(dtype=float),
            "pressure_kPa": rows["pressure_kPa"].to_numpy(dtype=float),
            "displacement_mm": rows["displacement_mm"].to_numpy(dtype=float),
            "rate_kPa_per_s": np.array([rates[number] for number in test], dtype=float),
        }
    )


DRAWN: Final = (*TABLES, "morph", "material", "film")
"""Sections of a set-up that tell how a specimen is drawn."""


def _design(test: SpecimenTest) -> str:
    """What a laboratory tells of a specimen's own dimensions and materials."""
    own = {name: dict(test.setup.sections.get(name, {})) for name in DRAWN}
    return json.dumps(own, sort_keys=True, default=str)


def _pressure_rate(measurement: Measurement, test: SpecimenTest) -> float:
    """Rate of the ramps in kPa/s; NaN where there is none, or another quantity is controlled."""
    rate = measurement.ramp_rate(test) if test.control == PRESSURE.name else None
    return np.nan if rate is None else rate


def noise_keys(index: pd.DataFrame) -> np.ndarray:
    """Which noise each reading has: a column of a test, shape (n,)."""
    return np.array(
        [
            f"{column} of test {run}"
            for column, run in zip(index["channel"], index["run"], strict=True)
        ]
    )


def joined(first: Readings, second: Readings) -> Readings:
    """Both together: nuisances of the same name are the same, effects of the same shape, too.

    A plate that is set once more is off by another gap.
    """
    n, m = len(first.index), len(second.index)
    runs = second.index["run"] + int(first.index["run"].max()) + 1
    index = pd.concat([first.index, second.index.assign(run=runs)], ignore_index=True)
    noise = np.zeros((n + m, n + m))
    noise[:n, :n], noise[n:, n:] = first.noise, second.noise
    nuisances: dict[str, np.ndarray] = {}
    for name, change in first.nuisances.items():
        shared = name in second.nuisances and not name.startswith("plate_gap")
        nuisances[name] = np.append(change, second.nuisances[name] if shared else np.zeros(m))
    for name, change in second.nuisances.items():
        if name not in first.nuisances or name.startswith("plate_gap"):
            nuisances[f"{name} of the addition"] = np.append(np.zeros(n), change)
    return Readings(
        index, noise, np.append(first.noise_std, second.noise_std), nuisances,
        np.append(first.mesh, second.mesh), _apart(first.laws, second.laws),
        [_joined(each, second.candidates, m) for each in first.candidates],
    )  # fmt: skip


def _apart(first: Matrix, second: Matrix) -> Matrix:
    """Columns of each alone."""
    upper = np.hstack([first, np.zeros((len(first), second.shape[1]))])
    return np.vstack([upper, np.hstack([np.zeros((len(second), first.shape[1])), second])])


def _joined(candidate: Candidate, others: Sequence[Candidate], count: int) -> Candidate:
    """An effect's changes of both, by shape; 0 where the addition does not feel it."""
    other = next((each for each in others if each.name == candidate.name), None)
    changes = {shape.label: shape.change for shape in other.shapes} if other else {}
    shapes = tuple(
        Shape(np.append(shape.change, changes.get(shape.label, np.zeros(count))), shape.label)
        for shape in candidate.shapes
    )
    return Candidate(candidate.name, shapes, candidate.mean, candidate.spread, candidate.one_sided)
