"""How probable each kind of hypothesis is before measuring: no cause, one, two, an unknown one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dolfingrip.diagnosis.inference.arrays import Matrix


@dataclass(frozen=True)
class HypothesisWeights:
    """How probable each kind of hypothesis is before measuring; only ratios count.

    Single effects share ``single`` equally, pairs share ``pair``. Half of ``unknown`` is for an
    unknown cause alone, half for one beside one effect, shared equally.
    """

    none: float = 0.25
    single: float = 0.5
    pair: float = 0.1
    unknown: float = 0.15

    def __post_init__(self) -> None:
        """Check the weights.

        Raises:
            ValueError: one line naming the weight and its value.
        """
        for name in ("none", "single", "pair", "unknown"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise ValueError(f"weight of {name} = {value}: allowed: at least 0")
        if self.none == 0:
            raise ValueError("weight of none = 0: allowed: above 0")


@dataclass(frozen=True, eq=False)
class LogPriors:
    """ln of the weight of each hypothesis of a kind before measuring (−∞ where there is none).

    Attributes:
        visible: of each candidate; what cannot be seen counts as no cause.
        log_total: ln of the sum over all hypotheses.
    """

    none: float
    single: float
    pair: float
    unknown: float
    beside: float
    visible: npt.NDArray[np.bool_]
    log_total: float

    @classmethod
    def of(cls, weights: HypothesisWeights, visible: npt.NDArray[np.bool_]) -> LogPriors:
        """Share the weights among the visible candidates."""
        count = int(visible.sum())
        pairs = count * (count - 1) / 2
        alone = weights.unknown * (0.5 if count else 1.0)
        return cls(
            none=_log(weights.none),
            single=_log(weights.single / count) if count else -np.inf,
            pair=_log(weights.pair / pairs) if pairs else -np.inf,
            unknown=_log(alone),
            beside=_log((weights.unknown - alone) / count) if count else -np.inf,
            visible=visible,
            log_total=_log(
                weights.none
                + weights.unknown
                + (weights.single if count else 0.0)
                + (weights.pair if pairs else 0.0)
            ),
        )

    @property
    def log_odds_something(self) -> float:
        """ln of the odds of any cause before measuring."""
        return _log(float(np.expm1(self.log_total - self.none)))

    def of_singles(self, log_evidence: Matrix) -> Matrix:
        """Prior times evidence, by logarithm, of single effects, (candidates,) or with samples."""
        return self._masked(self.single + log_evidence)

    def of_beside(self, log_evidence: Matrix) -> Matrix:
        """The same of effects beside an unknown cause."""
        return self._masked(self.beside + log_evidence)

    def _masked(self, logs: Matrix) -> Matrix:
        mask = self.visible if logs.ndim == 1 else self.visible[:, None]
        return np.asarray(np.where(mask, logs, -np.inf))


def _log(x: float) -> float:
    return float(np.log(x)) if x > 0 else -np.inf
