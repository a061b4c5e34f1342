"""The sections of the configuration that tell what is grasped, and what stands in the way."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from dolfingrip import plugins
from dolfingrip.channels import Part
from dolfingrip.foods.index import KINDS, SHAPES
from dolfingrip.foods.kind import FoodKind, Portion
from dolfingrip.sections.section import PLUGGED, Entry, Ratio, Role, Section, outside, with_keys_of

if TYPE_CHECKING:  # the kinds and their keys are known as it runs only

    class FoodKeys(Section):
        kind: str = ""
else:
    FoodKeys = with_keys_of(
        "FoodKeys",
        SHAPES,
        kind=(
            Literal[tuple(KINDS)],
            Field("cube", description="its shape; file: an STL file's", json_schema_extra=PLUGGED),
        ),
    )


class FoodShape(FoodKeys):
    """The kind of a food, with its size."""

    role: ClassVar = Role.SETUP

    width_mm: float | None = Field(None, gt=0, le=500, description="along x; default: by kind")
    length_mm: float | None = Field(None, gt=0, le=500, description="along y; default: by kind")
    height_mm: float | None = Field(None, gt=0, le=500, description="along z; default: by kind")

    @classmethod
    def made_of(cls, values: Mapping[str, Any]) -> tuple[type, ...]:
        """Return the class of the kind that a table names, where there is such a kind."""
        shape = KINDS.get(values.get("kind", "cube"))
        return () if shape is None else (shape,)

    @classmethod
    def counted(cls, values: Mapping[str, Any], parts: Iterable[Part]) -> dict[str, Any]:
        """Return the values that a result depends on, which keys of other plugins' kinds are not.

        Args:
            values: as plain data.
            parts: of the experiment.
        """
        used = cls.made_of(values)
        others = [shape for shape in SHAPES if plugins.digests(shape) and shape not in used]
        left = {key for shape in others for key in shape.model_fields}
        left -= {key for shape in SHAPES if shape not in others for key in shape.model_fields}
        return super().counted({k: v for k, v in values.items() if k not in left}, parts)

    @property
    def unused(self) -> Collection[str]:
        """Keys of other kinds' shapes."""
        used = KINDS[self.kind].model_fields
        return [key for shape in SHAPES for key in shape.model_fields if key not in used]

    @property
    def shape(self) -> FoodKind:
        """The shape, with its keys."""
        shape = KINDS[self.kind]
        return shape.model_construct(**{key: getattr(self, key) for key in shape.model_fields})

    @property
    def _portion(self) -> Portion:
        return KINDS[self.kind].portions[self.kind]

    @property
    def size_mm(self) -> tuple[float, float, float]:
        """Outer width, length and height; of a file those that are given, else 0."""
        given = (self.width_mm, self.length_mm, self.height_mm)
        usual = self._portion[:3]
        sizes_mm = [other if mm is None else mm for mm, other in zip(given, usual, strict=True)]
        return sizes_mm[0], sizes_mm[1], sizes_mm[2]

    @model_validator(mode="after")
    def _possible(self) -> Self:
        for other in SHAPES:
            for key in other.exclusive:
                value = getattr(self, key)
                if self.kind not in other.portions and value is not None:
                    kinds = " or ".join(f'"{kind}"' for kind in other.portions)
                    raise outside(key, value, f"allowed: none but with kind = {kinds}")
        self.shape.check(self.size_mm)
        return self


class Food(FoodShape):
    """The food that is grasped: kind, size, density and friction."""

    felt_by: ClassVar = ("gripper",)

    density_kg_m3: float | None = Field(
        None, gt=0, le=20_000, description="default: by kind; 1000 of a file"
    )
    friction: Ratio = Field(0.38, ge=0, le=10, description="of fingers on food (the paper's)")
    table_friction: Ratio = Field(0.3, ge=0, le=10, description="of food on the table")
    turn_deg: float = Field(0.0, ge=-180, le=180, description="about z, where it is put")
    offset_x_mm: float = Field(0.0, ge=-200, le=200, description="from below the gripper's centre")
    offset_y_mm: float = Field(0.0, ge=-200, le=200, description="from below the gripper's centre")

    @property
    def density(self) -> float:
        """Density (kg/m³)."""
        if self.density_kg_m3 is not None:
            return self.density_kg_m3
        return self._portion.density_kg_m3


class Obstacle(FoodShape):
    """A rigid body that stands beside a finger's back, without friction; round food lies across."""

    felt_by: ClassVar = ("finger",)
    later: ClassVar = {"friction": 0.38}
    entry: ClassVar = dict.fromkeys(("gap_mm", "z_mm"), Entry.CONSTANT)

    gap_mm: float = Field(
        1.0, ge=0, le=200, description="from the back at rest to where it is felt"
    )
    z_mm: float = Field(
        60.0, ge=-500, le=1500, description="of its centre of gravity, from the clamp"
    )
    friction: Ratio = Field(
        0.38, ge=0, le=10, description="that obstacle_lift_N counts with; the contact has none"
    )
    barrier_mm: float = Field(0.4, gt=0, le=10, description="distance at which it is felt")
    stiffness_MPa: float = Field(0.05, gt=0, description="of that barrier")
