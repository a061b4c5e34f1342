"""By how much a bar narrows: a reading of one's own, with its column."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dolfingrip.channels import Channel

if TYPE_CHECKING:
    from dolfingrip.mechanics.model.model import Model
    from dolfingrip.mechanics.readings.reading import Reading

NAME = "narrowing_mm"


def narrowing(model: Model) -> Reading:
    """Read how much a bar narrows; the solver is imported here, as `--help` needs none.

    Args:
        model: of the bar.
    """
    import numpy as np

    from dolfingrip.mechanics.model.unknowns import Gradient
    from dolfingrip.mechanics.readings.reading import Reading

    class Narrowing(Reading):
        """Width along x at rest, less that between the mean places of both sides' nodes (mm)."""

        def __init__(self) -> None:
            super().__init__(model, NAME)
            x = model.u.function_space.tabulate_dof_coordinates()[:, 0]
            sides = [np.isclose(x, at) for at in (x.min(), x.max())]
            lower, upper = (side / side.sum() for side in sides)
            self._weights = lower - upper

        def value(self) -> float:
            return float(self._weights @ model.u.x.array.reshape(-1, 3)[:, 0])

        def gradient(self) -> np.ndarray:
            slopes = Gradient(model.unknowns)
            slopes.at_nodes[:, 0] += self._weights
            return slopes.array

    return Narrowing()


NARROWING = Channel(
    name=NAME,
    unit="mm",
    title="Narrowing",
    form=".3f",
    of=("bar",),
    plausible=(-100.0, 100.0),
    noise=0.006,
    tolerance=3e-4,
    reading=narrowing,
    added=2,
)
