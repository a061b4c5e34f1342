"""Isotropic, incompressible laws as functions of the principal stretches, in numbers.

Each is the law of a file in ``forms/`` at constant volume;
``tests/experiments/test_material_fit.py`` holds one against the other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from dolfingrip.sections.material import ALPHA, POLYNOMIAL

Slopes = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Stretches (3, n) and values to ∂ψ/∂λ (MPa), (3, n)."""


@dataclass(frozen=True, slots=True)
class Law:
    """A strain energy with parameters.

    Attributes:
        name: as chosen with ``--law``.
        title: in tables.
        keys: of its parameters in the configuration, entries of lists numbered from 0.
        slopes: derivatives of the energy by the principal stretches.
        low, high: bounds of the values.
        linear: in its values; then one start will do.
        material: the configuration's ``material.law``.
    """

    name: str
    title: str
    keys: tuple[str, ...]
    slopes: Slopes
    low: tuple[float, ...]
    high: tuple[float, ...]
    linear: bool = True
    material: str = "neo-hooke"

    def tables(self, values: Sequence[float] | np.ndarray) -> dict[str, Any]:
        """Tables of the configuration, by name."""
        found: dict[str, Any] = {"material": {"law": self.material}}
        for key, value in zip(self.keys, values, strict=True):
            path, _, place = key.partition("[")
            *sections, name = path.split(".")
            table = found
            for section in sections:
                table = table.setdefault(section, {})
            if place:
                table.setdefault(name, []).append(float(value))
            else:
                table[name] = float(value)
        return found


def _by_invariants(powers: Sequence[tuple[int, int]]) -> Slopes:
    def slopes(stretches: np.ndarray, values: np.ndarray) -> np.ndarray:
        first, second = (stretches**2).sum(0) - 3, (stretches**-2.0).sum(0) - 3
        by_first, by_second = np.zeros_like(first), np.zeros_like(first)
        for (i, j), c in zip(powers, values, strict=True):
            if i:
                by_first = by_first + c * i * first ** (i - 1) * second**j
            if j:
                by_second = by_second + c * j * first**i * second ** (j - 1)
        return 2 * by_first * stretches - 2 * by_second * stretches**-3.0

    return slopes


def _neo_hooke(stretches: np.ndarray, values: np.ndarray) -> np.ndarray:
    return values[0] * stretches


def _gent(stretches: np.ndarray, values: np.ndarray) -> np.ndarray:
    mu, inverse = values
    left = 1 - inverse * ((stretches**2).sum(0) - 3)
    # beyond the chains' limit there is no state: far too stiff, but a number
    return mu * stretches / np.maximum(left, 1e-6)


def _ogden(stretches: np.ndarray, values: np.ndarray) -> np.ndarray:
    found = np.zeros_like(stretches)
    for mu, alpha in values.reshape(2, -1).T:
        found = found + 2 * mu / alpha * stretches ** (alpha - 1)
    return found


def _polynomial(name: str, title: str, *keys: str) -> Law:
    return Law(
        name,
        title,
        tuple(f"material.{key}" for key in keys),
        _by_invariants([POLYNOMIAL[key] for key in keys]),
        (-np.inf,) * len(keys),
        (np.inf,) * len(keys),
        material="polynomial",
    )


def _ogden_law(terms: int) -> Law:
    keys = [f"material.ogden_{key}[{k}]" for key in ("mu_MPa", "alpha") for k in range(terms)]
    return Law(
        f"ogden-{terms}",
        f"Ogden, {terms} term{'s' if terms > 1 else ''}",
        tuple(keys),
        _ogden,
        (0.0,) * terms + (-ALPHA[1],) * terms,
        (np.inf,) * terms + (ALPHA[1],) * terms,
        linear=False,
        material="ogden",
    )


LAWS: Final[Mapping[str, Law]] = {
    law.name: law
    for law in (
        Law("neo-hooke", "neo-Hooke", ("material.mu_MPa",), _neo_hooke, (0.0,), (np.inf,)),
        _polynomial("mooney-rivlin", "Mooney–Rivlin", "C10_MPa", "C01_MPa"),
        _polynomial("yeoh", "Yeoh", "C10_MPa", "C20_MPa", "C30_MPa"),
        Law(
            "gent",
            "Gent",
            ("material.mu_MPa", "extensions.gent.inverse_J_m"),
            _gent,
            (0.0, 0.0),
            (np.inf, 10.0),
            linear=False,
        ),
        *(_ogden_law(terms) for terms in (1, 2, 3)),
        _polynomial("polynomial", "polynomial (Biderman)", "C10_MPa", "C01_MPa", "C20_MPa",
                    "C30_MPa"),
    )
}  # fmt: skip
"""By name. Biderman's polynomial (1958) has the first invariant to the third power and the second
to the first."""
