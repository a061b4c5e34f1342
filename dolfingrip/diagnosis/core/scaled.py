"""A factor of all moduli, which readings may be proportional to."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from dolfingrip.diagnosis.core.emulator import Emulator


@dataclass(frozen=True, slots=True)
class Factor:
    """c = exp(s ζ), a log-normal number.

    Attributes:
        std: s.
        low, high: range of ζ; draws go where no fit does.
    """

    std: float
    low: float
    high: float

    def __call__(self, zeta: float | np.ndarray) -> np.ndarray:
        """c, of the shape of ζ."""
        return np.exp(self.std * np.clip(zeta, self.low, self.high))


@dataclass(frozen=True, eq=False)
class Scaled(Emulator):
    """An emulator some of whose readings are c times what they are at c = 1.

    Attributes:
        inner: of a cause's change at c = 1; None for what c alone changes.
        factor: c by ζ, the first of the model's own numbers.
    """

    inner: Emulator | None
    factor: Factor
    takes: tuple[int, ...] = field(default=(0,), kw_only=True)

    @classmethod
    def of(cls, inner: Emulator, scaled: np.ndarray, factor: Factor) -> Scaled:
        """Of an emulator of a cause, whose readings are ``scaled`` or not, (n,)."""
        on = scaled[:, None]
        columns = np.hstack([inner.columns * on, inner.columns * ~on])
        return cls(columns, inner.errors, inner.left, inner, factor)

    @classmethod
    def alone(cls, base: np.ndarray, scaled: np.ndarray, factor: Factor) -> Scaled:
        """What c changes of the model's readings (n,) itself."""
        return cls((base * scaled)[:, None], np.zeros((len(base), 0)), 0.0, None, factor)

    def at(self, zeta: np.ndarray) -> np.ndarray:
        c = self.factor(zeta[:, :1])
        if self.inner is None:
            return c - 1
        g = self.inner.at(zeta[:, 1:])
        return np.hstack([c * g, g])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        c = float(self.factor(zeta[0]))
        rate = self.factor.std * c
        if self.inner is None:
            return np.array([c - 1]), np.array([[rate]])
        g, slopes = self.inner.with_slopes(zeta[1:])
        on = np.column_stack([rate * g, c * slopes])
        return np.r_[c * g, g], np.vstack([on, np.column_stack([0 * g, slopes])])
