"""The readings that a rig would take: covariance, changes by effects, and two sets joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.noise import noise as instrument_noise
from dolfingrip.diagnosis.inference.arrays import Matrix
from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import ChannelNoise
from dolfingrip.diagnosis.noise_model import LONG
from dolfingrip.diagnosis.problem import Problem, as_candidate, index_of, noise_keys
from dolfingrip.diagnosis.simulation.base import simulate_base
from dolfingrip.diagnosis.simulation.runner import Workers


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
    everything = np.arange(len(index))
    problem = Problem(measurement, base, everything, index, base.readings, noise, told.control)
    return Readings(
        index, problem.noise_covariance, problem.noise_std,
        {each.name: each.change for each in problem.linear_nuisances()},
        np.nan_to_num(base.mesh).sum(axis=1), problem.tolerance(),
        [as_candidate(problem, each) for each in base.candidates if len(each.shapes)],
    )  # fmt: skip


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
