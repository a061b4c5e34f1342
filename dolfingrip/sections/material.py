"""Sections of the configuration for materials: one for each law, and one table for each region.

>>> from pydantic import TypeAdapter
>>> materials = TypeAdapter(AnyMaterials).validate_python({"mu_MPa": 2.0, "film": {"mu_MPa": 30.0}})
>>> materials.of("film").mu_MPa, materials.of("body").mu_MPa, materials.own
(30.0, 2.0, ('film',))

``material.name`` stands in place of a law and its constants; ``materials.toml`` has the names.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, Union

from pydantic import BeforeValidator, ConfigDict, Field, TypeAdapter, create_model

from dolfingrip import plugins
from dolfingrip.channels import Part
from dolfingrip.sections import tables
from dolfingrip.sections.errors import shown
from dolfingrip.sections.laws.index import LAWS
from dolfingrip.sections.laws.law import MaterialLaw
from dolfingrip.sections.section import EVERYWHERE, FINGERS, Entry, Ratio, Refusal, Role, outside

NAME: Final = "name"
"""Key of a material's table that names one of these; the resolved configuration has its law."""

_KEPT: Final = ("nu", "bulk_MPa", "density_kg_m3", "elongation_at_break")
"""Keys that a named material leaves to the configuration, or that may be told otherwise."""


@cache
def named() -> dict[str, dict[str, Any]]:
    """Return the materials by name: law and constants, stretch, elongation, source and licence."""
    text = files("dolfingrip.sections").joinpath("materials.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def _of_name(table: dict[str, Any], defaults: dict[str, Any]) -> dict[str, Any]:
    """Return a material's table with the law and constants of the material that it names.

    Args:
        table: of the configuration; without a name it is returned as it is.
        defaults: values of the keys of all laws where they are not told.

    Raises:
        PydanticCustomError: the name is unknown, or a law or constants are told, too.
    """
    name = table.get(NAME)
    if name is None:
        return table
    if name not in named():
        raise outside(NAME, shown(name), f"allowed: {', '.join(named())}")
    entry = named()[name]
    constants = {**entry["material"], "elongation_at_break": entry["elongation_at_break"]}
    given = {k: v for k, v in table.items() if k != NAME and v != defaults.get(k, name)}
    for key, value in given.items():
        if key in defaults and key not in _KEPT and value != constants.get(key):
            raise outside(key, shown(value), f'allowed: without name = "{name}", which tells it')
    if given.get("bulk_MPa") is not None:
        constants.pop("nu", None)
    return {**constants, **given}


def known_as(material: Material) -> tuple[str, dict[str, Any]] | None:
    """Return the name of the material that has these constants, and what is known of it.

    Args:
        material: as it is resolved, without its name.
    """
    constants = {"law": material.law, **material.constants()}.items()
    return next((row for row in named().items() if constants <= row[1]["material"].items()), None)


OF_RUBBER: Final = 0.499
"""Poisson's ratio of a law that was fitted as if the volume stayed."""

ALWAYS: Final = {"mu_MPa": 2.93, "ogden_mu_MPa": [], "ogden_alpha": []}
"""Keys of laws that count in keys of stored results with any law, where the law does not set them:
results are stored under such keys."""


class Material(MaterialLaw):
    """Hyperelastic solid; give ``nu`` or ``bulk_MPa``. Each law has further keys of its own."""

    role: ClassVar = Role.BODY
    felt_by: ClassVar = FINGERS
    entry: ClassVar = Entry.CONSTANT

    nu: Ratio | None = Field(
        None, gt=0, lt=0.5, description="Poisson's ratio; default 0.45 where no bulk_MPa is given"
    )
    bulk_MPa: float | None = Field(None, gt=0, description="bulk modulus, instead of nu")
    density_kg_m3: float = Field(1190.0, gt=0, description="felt by gravity and by inertia")
    elongation_at_break: Ratio | None = Field(
        None, gt=0, le=100, description="nominal strain at which it breaks; break_share is by it"
    )

    @classmethod
    def entry_of(cls, key: str) -> Entry:
        """Return how a number enters a simulation; the elongation at break does not."""
        return Entry.CHOICE if key == "elongation_at_break" else super().entry_of(key)

    @classmethod
    def is_modulus(cls, key: str) -> bool:
        """Return whether a number is a modulus of the law, or the bulk modulus."""
        return key == "bulk_MPa" or key in cls.moduli

    @classmethod
    def counted(cls, values: Mapping[str, Any], parts: Iterable[Part]) -> dict[str, Any]:
        """Return those values that a result depends on, and those of :data:`ALWAYS`.

        Args:
            values: as plain data.
            parts: of the experiment.
        """
        return super().counted({**ALWAYS, **values}, parts)

    @classmethod
    def made_of(cls, values: Mapping[str, Any]) -> tuple[type, ...]:
        """Return the class of the law that a table names, where there is such a law."""
        law = LAWS.get(values.get("law", next(iter(LAWS))))
        return () if law is None else (law,)

    def constants(self) -> dict[str, Any]:
        """Return the numbers of the law's energy by key; lists for lists."""
        keys = (key for key in type(self).model_fields if key not in Material.model_fields)
        return {key: value for key in keys if (value := getattr(self, key)) is not None}

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the law refuses, and moduli that are none of a solid."""
        yield from super().refusals()
        if self.shear_MPa <= 0:
            why = f"initial shear modulus {self.shear_MPa:g} MPa; allowed: above 0 MPa"
            yield Refusal(self.moduli[0], why)
        if self.nu is not None and self.bulk_MPa is not None:
            yield Refusal("bulk_MPa", f"give either nu or bulk_MPa; nu = {self.nu}")
        if self.bulk_MPa is not None and self.bulk_MPa <= 2 / 3 * self.shear_MPa:
            least = f"2/3 {self.shear_name} = {2 / 3 * self.shear_MPa:g} MPa"
            yield Refusal("bulk_MPa", f"allowed: above {least} (nu above 0)")

    @property
    def lmbda_MPa(self) -> float:
        """First Lamé parameter at small strain."""
        if self.bulk_MPa is not None:
            return self.bulk_MPa - 2 / 3 * self.shear_MPa
        return 2 * self.shear_MPa * self.poisson / (1 - 2 * self.poisson)

    @property
    def poisson(self) -> float:
        """Poisson's ratio at small strain."""
        if self.bulk_MPa is not None:
            three, two = 3 * self.bulk_MPa, 2 * self.shear_MPa
            return (three - two) / (2 * three + two)
        return 0.45 if self.nu is None else self.nu


def _with_law(data: Any) -> Any:
    """Add the default law, or that of a named material, to a table; refuse keys of other laws.

    Files of earlier versions hold those keys with their defaults, which are left out.
    """
    if not isinstance(data, dict):
        return data
    kinds: tuple[type[MaterialLaw], ...] = (Material, *LAWS.values())
    defaults = {key: f.default for kind in kinds for key, f in kind.model_fields.items()}
    data = _of_name(data, {**defaults, "law": next(iter(LAWS))})
    law = data.get("law", next(iter(LAWS)))
    if not isinstance(law, str) or law not in LAWS:
        allowed = f"allowed: {', '.join(sorted(LAWS))}; {plugins.hint(str(law))}"
        raise outside("law", shown(law), allowed)
    table = {"law": law, **data}
    for other, kind in LAWS.items():
        for key in kind.model_fields.keys() - LAWS[law].model_fields.keys() & data.keys():
            default, value = kind.model_fields[key].default, table.pop(key)
            if value != default and value != tables.plain(default):
                why = f'allowed: with another law than "{law}", such as "{other}"'
                raise outside(key, shown(value), why)
    return table


def _of_any_law(base: type[Material]) -> Any:
    """Return the type of a table that holds the keys of ``base`` and of the law that it names."""
    about = f"strain energy: {', '.join(sorted(LAWS))}"
    fields: dict[str, Any] = {
        name: (Literal[name], Field(name, description=about)) for name in LAWS
    }
    kinds = tuple(
        create_model(
            f"{law.__name__}{base.__name__}",
            __base__=(base, law),
            __doc__=base.__doc__,
            __cls_kwargs__={"extra": base.model_config["extra"]},
            law=fields[name],
        )
        for name, law in LAWS.items()
    )
    return Annotated[Union[kinds], Field(discriminator="law"), BeforeValidator(_with_law)]  # noqa: UP007  # of a tuple


if TYPE_CHECKING:  # the laws and their keys are known as it runs only
    AnyMaterial = Material
else:
    AnyMaterial = _of_any_law(Material)


class Materials(Material):
    """Material of all regions that have no table of their own, such as [material.film].

    A region's table is a whole material: keys that it leaves out have their default values.
    """

    felt_by: ClassVar = EVERYWHERE
    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, AnyMaterial]
    entries: ClassVar = AnyMaterial

    def number_at(self, key: str) -> float:
        """Return a number by its key; Poisson's ratio may be absent."""
        region, _, name = key.rpartition(".")
        return self.of(region).poisson if name == "nu" else super().number_at(key)

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the regions with a material of their own."""
        return tuple(self.__pydantic_extra__)

    def of(self, region: str) -> Material:
        """Return the material of a region.

        Args:
            region: name of the region.
        """
        return self.__pydantic_extra__.get(region, self)


if TYPE_CHECKING:
    AnyMaterials = Materials
else:
    AnyMaterials = _of_any_law(Materials)

DEFAULT: Final[Materials] = TypeAdapter(AnyMaterials).validate_python({})
"""Printed NinjaFlex, in all regions."""
