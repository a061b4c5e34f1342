"""Quantities other than the unknowns that a tangent depends on; solutions do not depend on them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

import numpy as np


class Carried(Protocol):
    """Fields in a term's tangent that are carried along Newton's steps."""

    @property
    def values(self) -> np.ndarray:
        """All of them as one array, a copy."""
        ...

    @values.setter
    def values(self, values: np.ndarray) -> None: ...

    def reset(self) -> None:
        """Set the fields to the values that follow from the present unknowns."""
        ...

    def follow(self, *steps: np.ndarray) -> None:
        """Predict them for ``steps`` (local dofs of each field) from the present unknowns."""
        ...


class CarriedTogether:
    """The carried fields of several terms as one; False if there are none.

    Args:
        parts: one for each term that has such fields.
    """

    def __init__(self, parts: Sequence[Carried]) -> None:
        self._parts = parts

    def __bool__(self) -> bool:
        return bool(self._parts)

    @property
    def values(self) -> np.ndarray:
        """All of them as one array, a copy."""
        return np.concatenate([np.empty(0), *(part.values for part in self._parts)])

    @values.setter
    def values(self, values: np.ndarray) -> None:
        place = 0
        for part in self._parts:
            size = len(part.values)
            part.values = values[place : place + size]
            place += size

    def reset(self) -> None:
        """Set the fields to the values that follow from the present unknowns."""
        for part in self._parts:
            part.reset()

    def follow(self, *steps: np.ndarray) -> None:
        """Predict them for ``steps`` (local dofs of each field) from the present unknowns."""
        for part in self._parts:
            part.follow(*steps)


class Regularised(ABC):
    """A term that adds a stiffness to its tangent which vanishes with the residual."""

    @abstractmethod
    def set_residual(self, residual_N: float) -> None:
        """Set the residual at which a tangent is assembled; 0 for the exact tangent."""
