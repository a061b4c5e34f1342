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
        at: place on the grid of shapes, where the shapes lie along a line.
        second: another strength (neither 0 nor 1) and the change there, shape (n,); with it the
            change is quadratic in the strength.
    """

    change: Vector
    label: str = ""
    at: float | None = None
    second: tuple[float, Vector] | None = None

    def polynomial(self) -> tuple[Vector, Vector]:
        """b and c of change(a) = a b + a² c, shape (n,) each."""
        if self.second is None:
            return self.change, np.zeros(self.change.shape)
        strength, change = self.second
        curved = (change - strength * self.change) / (strength * (strength - 1))
        return self.change - curved, np.asarray(curved)

    def at_strength(self, strength: float) -> Vector:
        """The change at a strength, in units of the ordinary one, shape (n,)."""
        straight, curved = self.polynomial()
        return strength * straight + strength**2 * curved


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
            if shape.second is not None and shape.second[0] in (0.0, 1.0):
                raise ValueError(
                    f"{self.name}: second strength = {shape.second[0]}: allowed: not 0 or 1"
                )

    def draw(self, rng: np.random.Generator) -> tuple[int, float]:
        """A shape's number and a strength from the prior."""
        number = int(rng.integers(len(self.shapes)))
        while True:
            strength = float(rng.normal(self.mean, self.spread))
            if strength > 0 or not self.one_sided:
                return number, strength
