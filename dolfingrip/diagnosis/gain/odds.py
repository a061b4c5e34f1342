"""Whether a cause beats both rivals: by the odds of the readings that were left out.

A model that was fitted to the rest gives each left-out part a probability density; the odds are
R = p(part | rest, cause) / p(part | rest, rival). Where the rival is right, R is 1 in the mean, so
R ≥ 20 happens in one case of twenty at most (Markov); and the same holds for the mean of any number
of such R, however they depend on one another. So the mean over all parts that are left out in turn
counts the looks, for few folds as for many (Vovk and Wang 2021, Ann. Stat. 49:1736; with
likelihoods: Wasserman, Ramdas and Balakrishnan 2020, PNAS 117:16880). The product over all parts is
the predictive density that Geisser and Eddy (1979, J. Am. Stat. Assoc. 74:153) compare models by.

Root mean square errors, which are shown beside it, cannot decide that. They differ by chance where
a cause changes nothing, and that in some of a dozen rows; scatter between two to five folds does
not tell how much. And a prediction that is off by much may be no worse than the model says, as that
of a coupon's force from a finger alone. Odds near 1 say nothing, for neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.diagnosis.gain.refitted import Refitted
from dolfingrip.diagnosis.inference.arrays import Vector, log_mean_exp

RIVALS: Final = ("nuisances", "process")

CLEAR: Final = 20.0
"""Odds that come by chance in 5 % of cases at most."""


@dataclass(frozen=True)
class Odds:
    """Natural logarithms of the odds for a cause, a number for each fold of a kind.

    Attributes:
        left_out: kind of the folds.
        channel: whose readings are foretold; None for those of all channels together.
        nuisances: against the base model with its nuisances refitted.
        process: against that with a Gaussian process without cause.
    """

    left_out: str
    channel: str | None
    nuisances: tuple[float, ...]
    process: tuple[float, ...]

    def against(self, rival: str) -> tuple[float, ...]:
        """Those against one of :data:`RIVALS`."""
        return self.nuisances if rival == "nuisances" else self.process


@dataclass(frozen=True, eq=False)
class Fold:
    """Readings that are left out together, and models that were fitted to the rest.

    Attributes:
        part: which they are, shape (n,) of bool.
        nuisances, process, cause: the two rivals and the model with the cause.
    """

    part: np.ndarray
    nuisances: Refitted
    process: Refitted
    cause: Refitted

    @property
    def predictions(self) -> tuple[Vector, Vector, Vector]:
        """Of the two rivals and of the model with the cause, shape (n,) each."""
        return self.nuisances.predicted, self.process.predicted, self.cause.predicted

    def log_odds(self, which: np.ndarray) -> tuple[float, float]:
        """Against nuisances and process, by those left out that are among ``which`` (n,)."""
        own = self.part & which
        cause = self.cause.log_density(own)
        return cause - self.nuisances.log_density(own), cause - self.process.log_density(own)


def odds_of(left_out: str, channel: str | None, folds: Sequence[Fold], which: np.ndarray) -> Odds:
    """The odds of each fold of a kind by the readings ``which``, shape (n,) of bool."""
    every = [fold.log_odds(which) for fold in folds]
    return Odds(left_out, channel, tuple(n for n, _ in every), tuple(p for _, p in every))


def mean_log_odds(odds: Sequence[Odds], rival: str) -> float:
    """ln of the mean odds over all parts that were left out, all channels together."""
    logs = [log for each in odds if each.channel is None for log in each.against(rival)]
    return float(log_mean_exp(logs)) if logs else 0.0


def log_odds_of_kinds(odds: Sequence[Odds], rival: str) -> float:
    """Sum of ln odds over the folds of a kind, all channels together; the mean over the kinds."""
    sums = [sum(each.against(rival)) for each in odds if each.channel is None]
    return float(np.mean(sums)) if sums else 0.0


def least_log_odds(odds: Sequence[Odds], rival: str) -> float:
    """Sum over the folds of the kind and channel where a cause does worst."""
    sums = [sum(each.against(rival)) for each in odds if each.channel is not None]
    return min(sums, default=0.0)


def claimed(odds: Sequence[Odds]) -> bool:
    """Whether a cause beats both rivals.

    Against refitted nuisances the mean odds have to be :data:`CLEAR`, and likewise those of all
    folds together, in the mean over the kinds: where the rival is wrong, a single part that it
    foretells with false certainty must not do for any cause. Against the process all that was left
    out has to be more probable; certainty cannot be had there, as a process repeats what it has
    seen at the same place of another specimen as well as any law. And in no channel of a kind of
    folds may the product of the folds' odds be clearly for a rival: :data:`CLEAR` times the number
    of these looks.
    """
    looks = sum(each.channel is not None for each in odds)
    lost = looks and any(-least_log_odds(odds, rival) >= np.log(CLEAR * looks) for rival in RIVALS)
    return bool(
        looks
        and not lost
        and mean_log_odds(odds, "nuisances") >= np.log(CLEAR)
        and log_odds_of_kinds(odds, "nuisances") >= np.log(CLEAR)
        and log_odds_of_kinds(odds, "process") > 0
    )
