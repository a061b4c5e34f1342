"""An effect that may be the cause: how it changes the readings, and how strong it may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dolfingrip.diagnosis.inference.arrays import Vector


@dataclass(frozen=True, eq=False)
class Shape:
    """One form that an effect's change of the readings can have, e.g. at one relaxation time.

    The change is a secant, a full simulation minus that without the effect, since the
    tangent at no effect can point another way.

    Attributes:
        change: change of all readings at the effect's ordinary strength, shape (n,).
        label: what tells it from the other shapes, with units.
    """

    change: Vector
    label: str = ""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect that may be the cause.

    Attributes:
        name: of the effect.
        shapes: those it can have; each is as likely as the others before measuring.
        mean, spread: of the strength's normal prior, in units of the ordinary strength.
        one_sided: whether the strength can only be above 0; the prior is cut there.
    """

    name: str
    shapes: tuple[Shape, ...]
    mean: float = 0.0
    spread: float = 1.0
    one_sided: bool = False

    def __post_init__(self) -> None:
        """Check the candidate.

        Raises:
            ValueError: one line naming the candidate and what is wrong.
        """
        if not self.shapes:
            raise ValueError(f"{self.name}: has no shape")
        if not (np.isfinite(self.spread) and self.spread > 0):
            raise ValueError(f"{self.name}: spread = {self.spread}: allowed: above 0")
        for shape in self.shapes:
            if not np.isfinite(shape.change).all():
                raise ValueError(f"{self.name}: its change {shape.label} is not finite")

    def draw(self, rng: np.random.Generator) -> tuple[int, float]:
        """A shape's number and a strength from the prior."""
        number = int(rng.integers(len(self.shapes)))
        while True:
            strength = float(rng.normal(self.mean, self.spread))
            if strength > 0 or not self.one_sided:
                return number, strength
