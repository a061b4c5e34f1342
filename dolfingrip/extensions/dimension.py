"""The base class of effects on the geometry: a printed dimension differs from the drawn one."""

from __future__ import annotations

from typing import ClassVar

from dolfingrip.extensions.effect import FINGERS, Effect, Setup
from dolfingrip.sections.errors import ConfigError


class DimensionOffset(Effect):
    """An effect that adds an offset to one dimension of the finger, which is then meshed anew.

    Attributes:
        dimension: key of the dimension in the table of the geometry.
        offset_mm: length that is added to the dimension (mm).
    """

    kind: ClassVar = "geometry"
    felt_by: ClassVar = FINGERS
    either: ClassVar = "thicker or thinner"
    dimension: ClassVar[str]
    offset_mm: float

    def adapt[S: Setup](self, config: S) -> S:
        """``config`` with the printed dimension.

        Raises:
            ConfigError: one line, if the finger is a mesh file, which has no dimensions.
        """
        table, allowed = config.geometry_table, ""
        if config.mesh.file is not None:
            allowed = f"from dimensions only; mesh.file has its {self.dimension}"
        elif not hasattr(config.geometry, self.dimension):
            allowed = f"that has a {self.dimension}, which [{table}] has not"
        if allowed:
            key = f"extensions.{self.name()}.offset_mm = {self.offset_mm:g}"
            raise ConfigError(f"{key}: allowed: with a finger {allowed}")
        return config.changed(**{table: config.geometry.offset(self.dimension, self.offset_mm)})
