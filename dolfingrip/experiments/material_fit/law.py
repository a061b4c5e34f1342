"""The laws of the base material that are fitted to coupons, under homogeneous deformation.

Each energy stands in a file of its own; here it is a function of numbers, with its stress in three
modes of tension, its limit points and its stability.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Literal

import numpy as np
import scipy  # which imports its parts when they are used

from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections import tables
from dolfingrip.sections.laws.index import LAWS as MATERIALS
from dolfingrip.sections.laws.law import Fittable, MaterialLaw


@dataclass(frozen=True, slots=True)
class Law:
    """A strain energy with parameters.

    Attributes:
        fittable: its values with their starts and bounds.
        material: law of the base material.
    """

    fittable: Fittable
    material: type[MaterialLaw]

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of its parameters in the configuration; entries of lists are numbered from 0."""
        return tuple(f"material.{key}" for key in self.fittable.keys)

    @property
    def name(self) -> str:
        """Name by which ``--law`` chooses it."""
        return self.fittable.name

    @property
    def title(self) -> str:
        """Name in tables."""
        return self.fittable.title

    def energy(self, values: Sequence[float] | np.ndarray, invariants: Invariants) -> Jet:
        """Energy per reference volume at constant volume (mJ/mm³), with its derivatives."""
        table = self.tables(values)["material"]
        c = {key: value for key, value in table.items() if key != "law"}
        return self.material.energy(c, invariants)

    def tables(self, values: Sequence[float] | np.ndarray) -> dict[str, Any]:
        """Tables of the configuration with these values, by name."""
        change: dict[str, Any] = {"material.law": self.material.law_name()}
        for key, value in zip(self.keys, values, strict=True):
            path, _, place = key.partition("[")
            if place:
                change.setdefault(path, []).append(float(value))
            else:
                change[path] = float(value)
        by_name: dict[str, Any] = {}
        tables.put(by_name, change)
        return by_name


LAWS: Final[Mapping[str, Law]] = {
    law.name: law
    for law in (Law(fittable, kind) for kind in MATERIALS.values() for fittable in kind.fits)
}
"""By name."""


Mode = Literal["uniaxial", "planar", "equibiaxial"]

EXPONENTS: Final[dict[Mode, np.ndarray]] = {
    "uniaxial": np.array([1.0, -0.5, -0.5]),
    "planar": np.array([1.0, 0.0, -1.0]),
    "equibiaxial": np.array([1.0, 1.0, -2.0]),
}
"""Principal stretches at constant volume, as powers of the stretch."""

LOG_STEP: Final = 0.005
"""Step of searches for instabilities and limit points, in the logarithm of the stretch."""

Values = Sequence[float] | np.ndarray
"""Values of a law's parameters, in the order of its keys."""

Energy = Callable[[Invariants], Jet]
"""Energy of a law with its values, at constant volume (mJ/mm³)."""


class OfStretches:
    """Invariants of isochoric stretches, with derivatives by the logarithms of the first two.

    Args:
        logarithms: (3, n) logarithms of the principal stretches, whose sum is 0.
    """

    def __init__(self, logarithms: np.ndarray) -> None:
        self._logarithms = logarithms

    @property
    def first(self) -> Jet:
        """Ī₁ − 3."""
        return self.power_sum(2.0)

    @property
    def second(self) -> Jet:
        """Ī₂ − 3."""
        return self.power_sum(-2.0)

    def power_sum(self, exponent: float) -> Jet:
        """Sum of the principal stretches to a power, less 3."""
        a, b, c = np.exp(exponent * self._logarithms)
        square = exponent**2
        return Jet(
            a + b + c - 3,
            exponent * (a - c),
            exponent * (b - c),
            square * (a + c),
            square * c,
            square * (b + c),
        )


def stress(law: Law, mode: Mode, stretch: np.ndarray, values: Values) -> np.ndarray:
    """Nominal stress (MPa) along the stretch.

    P = (λ₁ ∂ψ/∂λ₁ − λ₃ ∂ψ/∂λ₃)/λ₁ at constant volume, direction 3 being free (Ogden, Non-Linear
    Elastic Deformations, 1984, section 7.2).

    Args:
        law: the law.
        mode: mode of tension; in planar tension direction 2 is held.
        stretch: (n,) stretches, above 0.
        values: values of the law's parameters.
    """
    return _nominal(partial(law.energy, values), mode, np.asarray(stretch, dtype=float))


def _nominal(energy: Energy, mode: Mode, stretch: np.ndarray) -> np.ndarray:
    strains = OfStretches(EXPONENTS[mode][:, None] * np.log(stretch))
    return np.asarray(energy(strains).x / stretch)


def balloon(energy: Energy, stretch: np.ndarray) -> np.ndarray:
    """Pressure (MPa) in a thin spherical balloon, over 2 · wall / radius at rest: P/λ².

    Args:
        energy: of its wall, by the invariants.
        stretch: (n,) along both directions of the wall.
    """
    return _nominal(energy, "equibiaxial", stretch) / stretch**2


def limit_points(energy: Energy, highest: float) -> list[tuple[float, bool]]:
    """Find the stretches at which a balloon's pressure has a maximum or a minimum.

    Args:
        energy: energy of the balloon's walls, by the invariants.
        highest: stretch up to which they are sought. Nothing is known of larger stretches.

    Returns:
        Each stretch, and whether the pressure has a maximum there.
    """
    stretch = np.exp(np.arange(np.log(1.005), np.log(highest), LOG_STEP))

    def slope(at: np.ndarray | float) -> np.ndarray:
        at, h = np.atleast_1d(at), 1e-4
        after, before = (balloon(energy, at * (1 + way)) for way in (h, -h))
        return np.asarray(after - before)

    with np.errstate(all="ignore"):  # where chains of a limited length end
        rates, pressures = slope(stretch), balloon(energy, stretch)
        turned = np.signbit(rates[1:]) != np.signbit(rates[:-1])
        # the pressure jumps there and does not turn
        turned &= np.abs(np.diff(pressures)) < 0.5 * np.abs(pressures[:-1])
    turns = np.flatnonzero(turned)
    return [
        (
            float(scipy.optimize.brentq(lambda x: float(slope(x)[0]), stretch[i], stretch[i + 1])),
            bool(rates[i] > 0),
        )
        for i in turns
    ]


def unstable_from(law: Law, mode: Mode, values: Values, highest: float) -> float | None:
    """Find the stretch from which on the law violates Drucker's criterion, dτ : dε > 0.

    At constant volume the Hessian of ψ by the logarithmic strains must be positive definite.

    Args:
        law: the law.
        mode: mode of tension along which the law is deformed.
        values: values of its parameters.
        highest: stretch up to which it is sought. The end of the search is no finding.

    Returns:
        The largest stretch before the first violation; None if there is none up to ``highest``.
    """
    grid = np.append(np.arange(0, np.log(highest), LOG_STEP), np.log(highest))

    strains = OfStretches(EXPONENTS[mode][:, None] * grid)
    energy = law.energy(np.asarray(values, dtype=float), strains)
    stable = np.asarray((energy.xx > 0) & (energy.xx * energy.yy > energy.xy**2))
    if stable.all():
        return None
    return float(np.exp(grid[max(int(np.argmin(stable)) - 1, 0)]))
