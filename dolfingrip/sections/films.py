"""Films that limit strain: paper, silk, fibre sheets, as membranes or as layers of elements.

>>> films = Films.model_validate({"silk": {"Et_N_per_mm": 50.0}})
>>> films.all["silk"].model, films.all["silk"].face
('membrane', 'back')
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field

from dolfingrip.sections.ranges import PURE
from dolfingrip.sections.section import FINGERS, Entry, Ratio, Refusal, Role, Section, Vector

Stiffnesses = Annotated[tuple[Annotated[float, Field(ge=0)], ...], Field(strict=False)]
Angles = Annotated[tuple[Annotated[float, Field(ge=-180, le=180)], ...], Field(strict=False)]
Pair = Annotated[tuple[str, str], Field(strict=False)]


class Film(Section):
    """A thin strain-limiting film; its stiffness is given, and its thickness for its weight."""

    role: ClassVar = Role.BODY
    felt_by: ClassVar = FINGERS
    later: ClassVar = {"fibre_axis": [0.0, 0.0, 1.0]}
    entry: ClassVar = dict.fromkeys(
        ("Et_N_per_mm", "nu", "fibre_Et_N_per_mm", "fibre_deg", "compression", "thickness_mm"),
        Entry.CONSTANT,
    )

    model: Literal["membrane", "layer"] = Field(
        "membrane", description="a membrane on a surface, or the elements of a whole region"
    )
    region: str = Field(
        "", description="the layer's, or that whose back or front the membrane is on; default: all"
    )
    face: Literal["back", "front"] = Field(
        "back", description="membrane: on the region's lowest or highest plane x = const"
    )
    group: str | None = Field(
        None, description="membrane: on a surface group of the mesh, such as skin, instead"
    )
    between: Pair | None = Field(
        None, description="membrane: on the faces between two regions, instead"
    )
    Et_N_per_mm: float = Field(
        1.0, ge=0, description="Young's modulus times thickness, the same in all directions"
    )
    nu: Ratio = Field(0.3, ge=0, lt=0.5, description="Poisson's ratio in the film's plane")
    fibre_Et_N_per_mm: Stiffnesses = Field(
        (), description="of each family of fibres, besides Et_N_per_mm"
    )
    fibre_deg: Angles = Field(
        (), description="of each family, from fibre_axis, anticlockwise seen from outside"
    )
    fibre_axis: Annotated[Vector, PURE] = Field(
        (0.0, 0.0, 1.0), description="axis whose part in the surface is fibre_deg = 0"
    )
    compression: Ratio = Field(
        1.0, ge=0, le=1, description="stiffness of fibres in compression, relative to tension"
    )
    thickness_mm: float | None = Field(
        None, gt=0, le=100, description="layer: of the region, where the geometry has no such key"
    )

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        places = [key for key in ("group", "between") if getattr(self, key) is not None]
        if self.model == "layer":
            if places:
                yield Refusal(places[0], 'of a membrane; allowed: model = "membrane"')
            if not self.region:
                yield Refusal("region", "a layer's; allowed: the name of a region", '""')
        elif len(places) > 1:
            yield Refusal("group", "allowed: either group or between")
        yield from self.as_many("fibre_deg", "fibre_Et_N_per_mm")
        yield from self.directed("fibre_axis")
        if self.model == "layer" and not any(self.fibre_axis[1:]):
            yield Refusal("fibre_axis", "allowed for a layer, x = const: any but along x")
        if not self.Et_N_per_mm and not any(self.fibre_Et_N_per_mm):
            yield Refusal("Et_N_per_mm", "allowed: above 0, or with fibres")
        if self.model == "layer" and not self.Et_N_per_mm:
            yield Refusal("Et_N_per_mm", "of a layer; allowed: above 0 N/mm")

    @classmethod
    def is_modulus(cls, key: str) -> bool:
        """Return whether a number is a stiffness."""
        return key in ("Et_N_per_mm", "fibre_Et_N_per_mm")

    @property
    def regions(self) -> tuple[tuple[str, str], ...]:
        """Key and value of each region that is named; "" is the whole finger."""
        if self.between is not None:
            return tuple(("between", region) for region in self.between)
        return () if self.group is not None else (("region", self.region),)

    @property
    def symmetric(self) -> bool:
        """True if fibres are their own mirror image in the plane y = 0."""
        x, y, z = self.fibre_axis
        if y and (x or z) and self.fibre_deg:
            return False
        families: dict[float, float] = {}
        for degrees, stiffness in zip(self.fibre_deg, self.fibre_Et_N_per_mm, strict=True):
            at = round(degrees % 180.0, 9)
            families[at] = families.get(at, 0.0) + stiffness
        return all(
            families.get(round(-at % 180.0, 9), 0.0) == stiffness
            for at, stiffness in families.items()
        )


class Films(Section):
    """Films by name, as [film.silk] is one."""

    role: ClassVar = Role.BODY
    felt_by: ClassVar = FINGERS
    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Film]
    entries: ClassVar = Film

    @property
    def all(self) -> Mapping[str, Film]:
        """All films by name."""
        return self.__pydantic_extra__

    @property
    def layers(self) -> Mapping[str, Film]:
        """Films that are layers of elements, by name."""
        return {name: film for name, film in self.all.items() if film.model == "layer"}

    @property
    def membranes(self) -> Mapping[str, Film]:
        """Films that are membranes, by name."""
        return {name: film for name, film in self.all.items() if film.model == "membrane"}
