"""A strawberry: a blunt cone that lies on its side."""

from __future__ import annotations

from typing import ClassVar, Final

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from dolfingrip.foods.kind import Portion, SampledKind
from dolfingrip.foods.skin import sampled
from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.solid import Floats

SLENDER: Final = 0.86
"""Length from the calyx to the tip, by the diameter."""

BLUNT: Final = 0.3
"""How much the tip is rounded; 0: it is that of a cone. The radius is 1/2 at most with this one."""


class Strawberry(SampledKind):
    """A strawberry without its calyx, the tip towards +x.

    USDA's FoodData Central (SR Legacy, "Strawberries, raw") lists an extra large one with a
    diameter of 1 5/8 in (41.3 mm) and 27 g. The flesh has 1026 kg/m³ by the composition there and
    the densities of Choi and Okos (Food Engineering and Process Applications 1, 1986). Fruit has
    air between its cells, as densities of strawberries tell (Salvatori et al., J. Food Process Eng.
    21, 1998); that it takes 6 % is assumed here. The length follows from the weight.
    """

    portions: ClassVar = {"strawberry": Portion(38.4, 41.3, 38.4, 965.0)}
    lying: ClassVar = (0.0, 0.0, 0.0)
    colour: ClassVar = "#CE2B37"

    def made(self, size_mm: tuple[float, float, float]) -> tuple[SignedDistance, ClosedSurface]:
        lies = strawberry()
        natural = np.ptp(lies.points, axis=0)
        scaled = ClosedSurface(lies.points * (np.array(size_mm) / natural), lies.triangles)
        # its two halves are sampled alike, so that half a gripper can be computed
        return sampled(scaled, size_mm[1] / np.ceil(size_mm[1] / self.grid_mm))


def strawberry() -> ClosedSurface:
    """Draw a strawberry of diameter 1 as it lies, its centre of gravity at the origin.

    It lies still on the point of its flank that is nearest to the centre of gravity. Other sizes
    along the axes leave that point below the centre.
    """
    import pyvista as pv

    ball = pv.Icosphere(radius=1.0, nsub=4)
    way = np.asarray(ball.points, dtype=float)
    way /= np.linalg.norm(way, axis=1)[:, None]
    along = (1 + way[:, 0]) / 2
    ring = way[:, 1:] / np.maximum(np.linalg.norm(way[:, 1:], axis=1), 1e-9)[:, None]
    points = np.column_stack([SLENDER * along, _radius(along)[:, None] * ring])
    surface = ClosedSurface(points, np.asarray(ball.regular_faces, dtype=np.int64))
    surface = surface.moved(-surface.centre_mm)
    flank = np.linspace(0.25, 1, 750)  # without the calyx' end
    ahead, deep = SLENDER * flank + surface.points[:, 0].min(), _radius(flank)
    nearest = np.hypot(ahead, deep).argmin()
    lean = np.arctan2(ahead[nearest], deep[nearest])
    return surface.turned(Rotation.from_euler("y", lean).as_matrix())


def _radius(along: npt.NDArray[np.floating]) -> Floats:
    """Radius, by the diameter, at parts of the length from the calyx."""
    left = 1 - along
    return np.asarray(0.7954 * along**0.25 * np.sqrt(left * (left + BLUNT)))
