"""The base class of effects on the geometry: a printed dimension differs from the drawn one."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from dolfingrip.extensions.effect import Effect
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.section import FINGERS

if TYPE_CHECKING:
    from dolfingrip.sections.setup import Setup


class DimensionOffset(Effect):
    """An effect that adds an offset to one dimension of the finger, which is then meshed anew.

    Attributes:
        dimension: key of the dimension in the table of the geometry.
        offset_mm: length that is added to the dimension (mm).
    """

    felt_by: ClassVar = FINGERS
    dimension: ClassVar[str]
    offset_mm: float

    def adapt[S: Setup](self, config: S) -> S:
        """``config`` with the printed dimension.

        Raises:
            ConfigError: one line, if the finger is a mesh file, which has no dimensions.
        """
        if config.mesh.file is not None:
            raise ConfigError(
                f"extensions.{self.name()}.offset_mm = {self.offset_mm:g}: allowed: with a finger "
                f"from dimensions only; mesh.file has its {self.dimension}"
            )
        table = config.geometry_table
        if not hasattr(config.geometry, self.dimension):
            raise ConfigError(
                f"extensions.{self.name()}.offset_mm = {self.offset_mm:g}: allowed: with a finger "
                f"that has a {self.dimension}, which [{table}] has not"
            )
        printed = getattr(config.geometry, self.dimension) + self.offset_mm
        return config.changed(**{table: {self.dimension: printed}})
