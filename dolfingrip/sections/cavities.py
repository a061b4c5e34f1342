"""The cavities of a mesh file and the pressure in each, by the name of its surface group.

>>> cavities = Cavities.model_validate({"cavity_2": {"pressure_ratio": 0.5}})
>>> cavities.ratio("cavity"), cavities.ratio("cavity_2")
(1.0, 0.5)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import ConfigDict, Field

from dolfingrip.sections.section import FINGERS, Role, Section


class Cavity(Section):
    """One of several cavities."""

    role: ClassVar = Role.PROCEDURE
    felt_by: ClassVar = FINGERS

    pressure_ratio: float = Field(
        1.0, ge=-10, le=10, description="the cavity's pressure by the experiment's; 0: vented"
    )


class Cavities(Section):
    """Cavities by the group of a mesh file, as [cavity.cavity_2] is one."""

    role: ClassVar = Role.PROCEDURE
    felt_by: ClassVar = FINGERS
    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Cavity]
    entries: ClassVar = Cavity

    @property
    def all(self) -> Mapping[str, Cavity]:
        """The cavities that are named."""
        return self.__pydantic_extra__

    def ratio(self, name: str) -> float:
        """A cavity's pressure by the experiment's; 1 where it is not named."""
        found = self.__pydantic_extra__.get(name)
        return 1.0 if found is None else found.pressure_ratio
