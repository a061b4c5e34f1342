"""Section of the configuration that tells what is grasped."""

from __future__ import annotations

from pathlib import Path
from typing import Final, Literal, NamedTuple

from pydantic import Field, model_validator

from dolfingrip.sections.section import Section, outside

Kind = Literal[
    "sausage-short", "sausage-long", "potato-small", "potato-large", "cube", "file"
]  # fmt: skip


class Ordinary(NamedTuple):
    """Size and density of a kind where none are given.

    Attributes:
        width_mm: along x.
        length_mm: along y.
        height_mm: along z.
        density_kg_m3: of its flesh.
    """

    width_mm: float
    length_mm: float
    height_mm: float
    density_kg_m3: float


ORDINARY: Final[dict[str, Ordinary]] = {
    "sausage-short": Ordinary(22.2, 50.8, 22.2, 1040.0),
    "sausage-long": Ordinary(22.2, 127.0, 22.2, 1040.0),
    "potato-small": Ordinary(62.0, 80.0, 60.0, 1080.0),
    "potato-large": Ordinary(80.0, 106.0, 77.0, 1080.0),
    "cube": Ordinary(33.0, 33.0, 32.0, 1080.0),
}
"""Ordinary food, as USDA's FoodData Central (SR Legacy) lists portions: the short sausage is a
canned Vienna sausage (7/8 in wide, 2 in long, 16 g), the long one a frankfurter (7/8 in, 5 in,
eight to the pound at most), the potatoes weigh as its small one (170 g) and its large one (369 g,
3 to 4 1/4 in). Potatoes have a specific gravity of 1.06 to 1.10; an emulsion of meat has a density
of 1020 to 1070 kg/m³. The cube is the paper's, cut from a potato (section III.B)."""


class Food(Section):
    """What is grasped: its kind, size, density and friction."""

    kind: Kind = Field("cube", description="its shape; file: that of an STL file")
    file: Path | None = Field(
        None, strict=False, description="closed STL surface in mm, z upwards; with kind = file"
    )
    width_mm: float | None = Field(None, gt=0, le=500, description="along x; default: by kind")
    length_mm: float | None = Field(None, gt=0, le=500, description="along y; default: by kind")
    height_mm: float | None = Field(None, gt=0, le=500, description="along z; default: by kind")
    bend_radius_mm: float | None = Field(
        None, gt=0, le=10_000, description="sausage: of its axis; default: straight"
    )
    bump_mm: float = Field(2.0, ge=0, le=20, description="potato: highest bump, deepest dent")
    seed: int = Field(1, ge=0, description="potato: of its bumps")
    edge_radius_mm: float = Field(1.0, gt=0, le=100, description="cube: of its rounded edges")
    grid_mm: float = Field(
        2.5, gt=0.1, le=20, description="potato, file: spacing of the distance's samples"
    )
    smoothing_mm: float = Field(
        1.0, ge=0, le=20, description="file: standard deviation that rounds its edges off"
    )
    density_kg_m3: float | None = Field(
        None, gt=0, le=20_000, description="default: by kind; 1000 of a file"
    )
    friction: float = Field(0.38, ge=0, le=10, description="of fingers on food (the paper's)")
    table_friction: float = Field(0.3, ge=0, le=10, description="of food on the table")
    turn_deg: float = Field(0.0, ge=-180, le=180, description="about z, where it is put")
    offset_x_mm: float = Field(0.0, ge=-200, le=200, description="from below the gripper's centre")
    offset_y_mm: float = Field(0.0, ge=-200, le=200, description="from below the gripper's centre")

    @property
    def size_mm(self) -> tuple[float, float, float]:
        """Outer width, length and height; of a file those that are given, else 0."""
        ordinary = ORDINARY.get(self.kind, Ordinary(0.0, 0.0, 0.0, 0.0))
        given = (self.width_mm, self.length_mm, self.height_mm)
        found = [o if g is None else g for g, o in zip(given, ordinary, strict=False)]
        return found[0], found[1], found[2]

    @property
    def density(self) -> float:
        """Density (kg/m³)."""
        if self.density_kg_m3 is not None:
            return self.density_kg_m3
        return ORDINARY[self.kind].density_kg_m3 if self.kind in ORDINARY else 1000.0

    @model_validator(mode="after")
    def _possible(self) -> Food:
        if (self.kind == "file") != (self.file is not None):
            allowed = "a path" if self.kind == "file" else 'none but with kind = "file"'
            raise outside("file", self.file or "none", f"allowed: {allowed}")
        width, length, height = self.size_mm
        if self.kind.startswith("sausage"):
            self._sausage(width, length, height)
        if self.kind == "cube" and self.edge_radius_mm > min(self.size_mm) / 2:
            limit = min(self.size_mm) / 2
            raise outside(
                "edge_radius_mm", self.edge_radius_mm, f"allowed: above 0 and up to {limit:g} mm"
            )
        if self.kind.startswith("potato") and self.bump_mm > min(self.size_mm) / 8:
            limit = min(self.size_mm) / 8
            raise outside("bump_mm", self.bump_mm, f"allowed: at least 0 and up to {limit:g} mm")
        if self.kind == "file" and (self.width_mm or self.length_mm or self.height_mm):
            raise outside("kind", "file", "has its own size; allowed: no width, length or height")
        return self

    def _sausage(self, width: float, length: float, height: float) -> None:
        if height != width:
            raise outside("height_mm", height, f"allowed: width_mm = {width:g} mm, it is round")
        if length <= width:
            raise outside("length_mm", length, f"allowed: above width_mm = {width:g} mm")
        # bent further, its ends would meet or its inner side would fold
        least = max(width, (length - width) / 3)
        if self.bend_radius_mm is not None and self.bend_radius_mm < least:
            raise outside(
                "bend_radius_mm", self.bend_radius_mm, f"allowed: at least {least:.4g} mm"
            )
