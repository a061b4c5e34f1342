"""Common parts of a case of coupons and one of a finger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
import scipy.linalg

from dolfingrip.config import Change
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.policy import Policy

SEEN: Final = 6.0
"""Standard deviations from which on something is hidden."""
FAR: Final = (3.0, 5.0)
"""Standard deviations of a nuisance that is far from what was told."""
HIDDEN: Final[Mapping[str, int]] = {"one": 1, "with_outsider": 1, "two": 2}
"""Causes of the catalogue by kind of case; others hide none."""
ARTEFACTS: Final[Mapping[str, str]] = {
    "jaws_slip": "jump", "slip": "jump", "screw": "sine",
    "cell_sticks": "play", "guide_rubs": "play", "backlash": "play",
}  # fmt: skip
"""Outsiders that a diagnosis tells as artefacts of instruments, and which."""


class Hidden(Protocol):
    """Hidden causes of a case."""

    @property
    def modulus(self) -> float:
        """True by told."""

    @property
    def outsider(self) -> tuple[str, float]:
        """Name, and strength by the ordinary one; none where empty."""


@dataclass(frozen=True, slots=True)
class Case[Truth: Hidden]:
    """A case.

    Attributes:
        protocol, kind, number: of it.
        wide: whether strengths are from priors twice as wide.
        truth: what is hidden.
        names: of the hidden causes and of a nuisance that is far out; an outsider's is not here.
        zeta: of the hidden causes' numbers.
        sigma: standard deviations that each of these changes; of an outsider alone, what the best
            single cause leaves of it.
        seed: of noise.
    """

    protocol: str
    kind: str
    number: int
    wide: bool
    truth: Truth
    names: tuple[str, ...]
    zeta: tuple[float, ...]
    sigma: tuple[float, ...]
    seed: tuple[int, ...]


def is_wide(kind: str, number: int) -> bool:
    """Tell if a case's strengths are from priors twice as wide."""
    return number % 2 == 1 and kind not in ("prior", "none")


def truncated(rng: np.random.Generator, box: np.ndarray, width: float | np.ndarray) -> np.ndarray:
    """ζ of a cause's numbers within their ranges (numbers, 2), from normals of some width."""
    while True:
        zeta = width * rng.standard_normal(len(box))
        if ((zeta >= box[:, 0]) & (zeta <= box[:, 1])).all():
            return np.asarray(zeta)


def ordinary(
    rng: np.random.Generator, cause: Cause, width: float, reach: float = Policy().reach
) -> np.ndarray:
    """ζ of a cause's numbers, drawn from the ordinary part of their priors alone."""
    return truncated(rng, np.clip(cause.box(), -reach, reach), width)


def after_modulus(change: np.ndarray, by_modulus: np.ndarray) -> float:
    """Length of a change (n,) of whitened readings, after what the modulus changes, (n,)."""
    along = by_modulus @ change / (by_modulus @ by_modulus)
    return float(np.linalg.norm(change - along * by_modulus))


def strength(change: np.ndarray, covariance: np.ndarray, by_modulus: np.ndarray) -> float:
    """Length of a change of readings, after what the modulus changes.

    Args:
        change: of the readings, shape (n,).
        covariance: of noise and of what the rig may change, shape (n, n).
        by_modulus: change of the readings by the modulus, shape (n,).

    Returns:
        Standard deviations.
    """
    lower = scipy.linalg.cholesky(covariance, lower=True)
    white, along = (
        scipy.linalg.solve_triangular(lower, each, lower=True) for each in (change, by_modulus)
    )
    return after_modulus(white, along)


def by_cause[T: Hidden](case: Case[T], causes: Mapping[str, Cause]) -> dict[str, Change]:
    """Return the change to each hidden cause alone.

    Args:
        case: with the numbers of all.
        causes: of the catalogue, by name.
    """
    found, at = {}, 0
    for name in case.names:
        if at < len(case.zeta):  # a number of the rig has none
            count = len(causes[name].numbers)
            found[name] = causes[name].overrides(np.array(case.zeta[at : at + count]))
            at += count
    return found


def names_of(effects: Sequence[str], hidden: int, rng: np.random.Generator) -> tuple[str, ...]:
    """So many causes, each as probable as the others, in the catalogue's order."""
    chosen = rng.choice(len(effects), hidden, replace=False)
    return tuple(effects[i] for i in sorted(chosen))
