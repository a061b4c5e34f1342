"""A model that was fitted to a part of the readings, and what it expects of the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.problem import Problem


@dataclass(frozen=True, eq=False)
class Refitted:
    """A model that was fitted to a part of the readings.

    Attributes:
        known: which readings it was fitted to, shape (n,) of bool.
        predicted: what it expects of all of them, shape (n,).
        residual: measured less what it expected before it was fitted, shape (n,).
        covariance: of the residual before the fit, with noise, mesh and laws, shape (n, n).
    """

    known: np.ndarray
    predicted: Vector
    residual: Vector
    covariance: Matrix

    @classmethod
    def of(
        cls,
        problem: Problem,
        hypothesis: Hypothesis,
        known: np.ndarray,
        others: Sequence[Matrix] = (),
    ) -> Refitted:
        """A hypothesis with its parameters and nuisances fitted.

        Args:
            problem: with noise and nuisances.
            hypothesis: linear about its fit to all readings.
            known: which readings are used, shape (n,) of bool.
            others: further columns of one standard deviation, shape (n, k) each.
        """
        covariance = hypothesis.covariance(problem).matrix
        for columns in others:
            covariance = covariance + columns @ columns.T
        predicted = hypothesis.predicted(problem, known, others)
        return cls(known, predicted, hypothesis.residual(problem.value), covariance)

    def log_density(self, left_out: np.ndarray) -> float:
        """ln p(readings left out | known readings): their joint density, by that of the known.

        Args:
            left_out: readings that are not known, shape (n,) of bool.
        """
        return self._log_density(self.known | left_out) - self._of_known

    @cached_property
    def _of_known(self) -> float:
        return self._log_density(self.known)

    def _log_density(self, which: np.ndarray) -> float:
        block = Covariance.of(self.covariance[np.ix_(which, which)])
        return block.log_density(self.residual[which])
