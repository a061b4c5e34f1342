"""The section of the configuration for the material."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field, model_validator

from dolfingrip.sections.laws.index import LAWS
from dolfingrip.sections.laws.law import MaterialLaw
from dolfingrip.sections.section import Entry, Role, Section, outside, with_keys_of

if TYPE_CHECKING:  # the laws and their keys are known as it runs only

    class LawKeys(Section):
        law: str = ""
else:
    names = tuple(sorted(LAWS))
    LawKeys = with_keys_of(
        "LawKeys",
        LAWS.values(),
        law=(
            Literal[names],
            Field(next(iter(LAWS)), description=f"strain energy: {', '.join(names)}"),
        ),
    )


class Material(LawKeys):
    """Hyperelastic solid; give ``nu`` or ``bulk_MPa``.

    Each law has keys of its own: ``neo-hooke`` has ``mu_MPa``, ``ogden`` has ``ogden_mu_MPa`` and
    ``ogden_alpha``, ``polynomial`` the factors C.
    """

    role: ClassVar = Role.BODY
    entry: ClassVar = Entry.CONSTANT

    nu: float | None = Field(
        None, gt=0, lt=0.5, description="Poisson's ratio; default 0.45 where no bulk_MPa is given"
    )
    bulk_MPa: float | None = Field(None, gt=0, description="bulk modulus, instead of nu")
    density_kg_m3: float = Field(1190.0, gt=0, description="felt by gravity only")

    @classmethod
    def is_modulus(cls, key: str) -> bool:
        """Return whether a number is a modulus of a law, or the bulk modulus."""
        return key == "bulk_MPa" or any(key in law.moduli for law in LAWS.values())

    def movable(self, key: str) -> bool:
        """Return whether the law has this key."""
        return key not in self.foreign

    @property
    def chosen(self) -> MaterialLaw:
        """The law, with its keys."""
        law = LAWS[self.law]
        return law.model_construct(**{key: getattr(self, key) for key in law.model_fields})

    @property
    def foreign(self) -> tuple[str, ...]:
        """Keys of the other laws."""
        own = LAWS[self.law].model_fields
        return tuple(key for law in LAWS.values() for key in law.model_fields if key not in own)

    @model_validator(mode="after")
    def _of_its_law(self) -> Material:
        for key in self.foreign:
            value = getattr(self, key)
            if value != type(self).model_fields[key].default:
                raise outside(key, _listed(value), f'allowed: with another law than "{self.law}"')
        law = self.chosen
        law.check()
        if law.shear_MPa <= 0:
            key = law.moduli[0]
            raise outside(
                key,
                _listed(getattr(self, key)),
                f"initial shear modulus {law.shear_MPa:g} MPa; allowed: above 0 MPa",
            )
        return self

    @model_validator(mode="after")
    def _one_of(self) -> Material:
        if self.nu is not None and self.bulk_MPa is not None:
            raise outside("bulk_MPa", self.bulk_MPa, f"give either nu or bulk_MPa; nu = {self.nu}")
        if self.bulk_MPa is not None and self.bulk_MPa <= 2 / 3 * self.shear_MPa:
            raise outside(
                "bulk_MPa",
                self.bulk_MPa,
                f"allowed: above 2/3 {self.chosen.shear_name} = {2 / 3 * self.shear_MPa:g} MPa "
                "(nu above 0)",
            )
        return self

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return self.chosen.shear_MPa

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


def _listed(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value
