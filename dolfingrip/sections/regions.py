"""Materials of regions: the section ``material``, and a table below it for each other material.

>>> materials = Materials.model_validate({"mu_MPa": 2.0, "film": {"mu_MPa": 30.0}})
>>> materials.of("film").mu_MPa, materials.of("body").mu_MPa, materials.own
(30.0, 2.0, ('film',))
"""

from __future__ import annotations

from typing import ClassVar

from pydantic import ConfigDict

from dolfingrip.sections.material import Material
from dolfingrip.sections.section import FINGERS


class RegionMaterial(Material):
    """Material of one region."""

    felt_by: ClassVar = FINGERS


class Materials(Material):
    """Material of all regions that have no table of their own, such as [material.film].

    A region's table is a whole material: keys that it leaves out have their default values.
    """

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, RegionMaterial]
    entries: ClassVar = RegionMaterial

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the regions with a material of their own."""
        return tuple(self.__pydantic_extra__)

    def of(self, region: str) -> Material:
        """Material of a region."""
        return self.__pydantic_extra__.get(region, self)
