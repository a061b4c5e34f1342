"""An unknown cause: a smooth change of the readings that no candidate makes.

It is a Gaussian process in the load (pressure by its largest), separate for each channel of each
experiment, common to all specimens, alike or half alike between branches and from cycle to cycle,
smooth in the logarithm of the time on hold. Its length scale, likeness, channels and size are
averaged over a small grid. A process of covariance α² Φ Φᵀ with whitened L⁻¹Φ = U √Λ Vᵀ has

    ln BF = −½ Σ ln(1 + α² λᵢ) + ½ Σ (uᵢ·r)² α² λᵢ/(1 + α² λᵢ),

and beside an effect, lengths and scores are those in the metric 1 − U diag(α²λ/(1 + α²λ)) Uᵀ.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np
import pandas as pd
from scipy.linalg import LinAlgError, eigh

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector, log_mean_exp
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.evidence import log_bayes_factor
from dolfingrip.diagnosis.inference.readings import load
from dolfingrip.diagnosis.inference.screen import Screen

LENGTHS = (0.15, 0.4, 1.0)
"""Length scales in load."""
LIKENESS = (1.0, 0.5)
"""Correlation between branches and between one cycle and the next."""
SIZES = tuple(float(2**k) for k in range(7))
"""Standard deviations of the process, in those of a reading's noise."""
NEGLIGIBLE = 1e-10


class System:
    """One process of several sizes, whitened.

    Attributes:
        vectors: U, shape (n, m), orthonormal.
        values: λ, shape (m,).
        sizes: α, shape (sizes,).
        shares: α²λ/(1 + α²λ) for each size and vector, shape (sizes, m).
    """

    def __init__(self, vectors: Matrix, values: Vector, sizes: Sequence[float]) -> None:
        self.vectors, self.values, self.sizes = vectors, values, np.asarray(sizes)
        scaled = self.sizes[:, None] ** 2 * values
        self.shares: Matrix = scaled / (1 + scaled)
        self._logdet = np.log1p(scaled).sum(axis=1)

    def log_evidence(self, projected: Matrix) -> Matrix:
        """ln BF at each size from Uᵀr of shape (m, k), shape (sizes, k)."""
        return np.asarray(0.5 * (self.shares @ projected**2 - self._logdet[:, None]))


class SmoothMisfit:
    """Unknown causes, prepared for one covariance.

    Attributes:
        systems: one for each length scale, likeness and choice of channels.
        sizes: grid of their standard deviations, in those of the noise.
    """

    def __init__(
        self,
        index: pd.DataFrame,
        covariance: Covariance,
        noise_std: Vector,
        sizes: Sequence[float] = SIZES,
    ) -> None:
        """Prepare.

        Args:
            index: of the readings, n rows.
            covariance: of the residual without an effect.
            noise_std: standard deviation of each reading's noise, shape (n,).
            sizes: grid, see the class.
        """
        self.sizes = tuple(sizes)
        self._features = [features * noise_std[:, None] for features in _processes(index)]
        self._prepare(covariance)

    def under(self, covariance: Covariance) -> SmoothMisfit:
        """The same unknown causes for another covariance of the same readings and noise."""
        other = copy(self)
        other._prepare(covariance)
        return other

    def _prepare(self, covariance: Covariance) -> None:
        self.systems = [
            decomposed(covariance.whiten(features), self.sizes) for features in self._features
        ]

    def log_evidence(self, whitened: Matrix) -> Vector:
        """ln BF against no cause for whitened residuals of shape (n, k), shape (k,)."""
        logs = [system.log_evidence(system.vectors.T @ whitened) for system in self.systems]
        return log_mean_exp(np.concatenate(logs))

    def beside(self, screen: Screen, whitened: Matrix) -> Matrix:
        """ln BF of each candidate together with an unknown cause, against neither.

        Args:
            screen: with the same covariance.
            whitened: residuals, shape (n, k).

        Returns:
            Shape (candidates, k).
        """
        plain = screen.columns.T @ whitened
        found = []
        for system in self.systems:
            residual = system.vectors.T @ whitened
            columns = system.vectors.T @ screen.columns
            squared = screen.length**2 - system.shares @ columns**2
            # what is left of a change within the process's span is no less than rounding
            length = np.sqrt(np.maximum(squared, NEGLIGIBLE * screen.length**2))[:, :, None]
            pulled = plain - (columns.T * system.shares[:, None, :]) @ residual
            logs = log_bayes_factor(
                length,
                pulled / np.where(length > 0, length, 1.0),
                screen.mean[:, None],
                screen.spread[:, None],
                screen.one_sided[:, None],
            )
            found.append(screen.by_candidate(logs) + system.log_evidence(residual)[:, None, :])
        return log_mean_exp(np.concatenate(found))

    def best(self, whitened: Vector) -> Matrix:
        """The most probable process for a whitened residual: columns whose outer product is its
        whitened covariance, shape (n, m)."""
        logs = np.array(
            [
                system.log_evidence(system.vectors.T @ whitened[:, None])[:, 0]
                for system in self.systems
            ]
        )
        best, size = np.unravel_index(logs.argmax(), logs.shape)
        system = self.systems[int(best)]
        return np.asarray(self.sizes[int(size)] * system.vectors * np.sqrt(system.values))


def smooth_changes(index: pd.DataFrame) -> Matrix:
    """Features of one smooth process of variance 1, shape (n, features).

    Its length scale is the middle one; branches and cycles are half alike, channels of experiments
    apart.
    """
    return np.hstack(_by_block(_places(index), LENGTHS[1], LIKENESS[1]))


def decomposed(features: Matrix, sizes: Sequence[float]) -> System:
    """Singular vectors and values, the largest first, by the smaller product with itself.

    That halves the digits, which leaves five to the smallest value that is kept. A diagnosis of 427
    readings spends 6 s on it; singular value decompositions took 43 s.
    """
    wide = features.shape[1] > features.shape[0]
    values, vectors = _eigen(features @ features.T if wide else features.T @ features)
    values, vectors = values[::-1], vectors[:, ::-1]
    keep = values > NEGLIGIBLE * max(float(values[0]), 1e-300)
    values, vectors = values[keep], vectors[:, keep]
    return System(vectors if wide else features @ (vectors / np.sqrt(values)), values, sizes)


def _processes(index: pd.DataFrame) -> list[Matrix]:
    """Features Φ of each process of variance 1, shape (n, features)."""
    table = _places(index)
    found = []
    for length in LENGTHS:
        for likeness in LIKENESS:
            parts = _by_block(table, length, likeness)
            found += [np.hstack(parts), *(parts if len(parts) > 1 else ())]
    return found


def _by_block(table: pd.DataFrame, length: float, likeness: float) -> list[Matrix]:
    """Features of a process of variance 1 in each channel of each experiment alone, (n, m) each."""
    found: list[Matrix] = []
    for name in dict.fromkeys(table["block"]):
        own = (table["block"] == name).to_numpy()
        places, where = _distinct(table[own])
        root = _root(_kernel(places, length, likeness))
        features = np.zeros((len(table), root.shape[1]))
        features[own] = root[where]
        found.append(features)
    return found


def _distinct(table: pd.DataFrame) -> tuple[pd.DataFrame, np.ndarray]:
    """Each place of the table once, and the row of each reading's place among them."""
    places = table.drop_duplicates().reset_index(drop=True)
    return places, table.merge(places.reset_index(), how="left")["index"].to_numpy()


def _places(index: pd.DataFrame) -> pd.DataFrame:
    """Where each reading stands; readings of several specimens share a place."""
    held = np.zeros(len(index))
    numbers = index.reset_index(drop=True)
    for _, rows in numbers[numbers["branch"] == "hold"].groupby(["run", "channel", "cycle"]):
        held[rows.index] = np.log1p(rows["time_s"] - rows["time_s"].min())
    return pd.DataFrame(
        {
            "block": [
                f"{channel} in {experiment}"
                for channel, experiment in zip(index["channel"], index["experiment"], strict=True)
            ],
            "load": np.round(load(index), 3),
            "branch": index["branch"].to_numpy(),
            "cycle": index["cycle"].to_numpy(dtype=float),
            "held": np.round(held, 2),
        }
    )


def _kernel(places: pd.DataFrame, length: float, likeness: float) -> Matrix:
    def apart(name: str) -> Matrix:
        values = places[name].to_numpy(dtype=float)
        return np.asarray(np.abs(values[:, None] - values[None, :]))

    branch = places["branch"].to_numpy()
    kernel = np.exp(-0.5 * (apart("load") / length) ** 2 - 0.5 * apart("held") ** 2)
    kernel *= likeness ** apart("cycle")
    return np.asarray(kernel * np.where(branch[:, None] == branch[None, :], 1.0, likeness))


def _root(kernel: Matrix) -> Matrix:
    values, vectors = _eigen(kernel)
    keep = values > 1e-8 * values[-1]
    return np.asarray(vectors[:, keep] * np.sqrt(values[keep]))


def _eigen(matrix: Matrix) -> tuple[Vector, Matrix]:
    """Eigenvalues, the smallest first, and vectors of a symmetric matrix.

    The quick algorithm does not converge for every matrix; the slower one does.
    """
    try:
        values, vectors = eigh(matrix)
    except LinAlgError:
        values, vectors = eigh(matrix, driver="ev")
    return values, vectors
