"""The section of the configuration for the material."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from dolfingrip.sections.section import Section, outside

Terms = Annotated[tuple[float, ...], Field(strict=False)]

POLYNOMIAL = {"C10_MPa": (1, 0), "C01_MPa": (0, 1), "C20_MPa": (2, 0), "C11_MPa": (1, 1),
              "C02_MPa": (0, 2), "C30_MPa": (3, 0)}  # fmt: skip
"""Exponents of Ī₁ − 3 and Ī₂ − 3 by the keys of their factors."""

ALPHA = (0.05, 10.0)
"""Smallest and largest exponent of Ogden's law, of either sign."""


class Material(Section):
    """Hyperelastic solid; give ``nu`` or ``bulk_MPa``.

    The law ``neo-hooke`` has ``mu_MPa``; ``ogden`` has ``ogden_mu_MPa`` and ``ogden_alpha``,
    ``polynomial`` the factors C.
    """

    law: Literal["neo-hooke", "ogden", "polynomial"] = Field(
        "neo-hooke", description="strain energy: neo-hooke, ogden or polynomial"
    )
    mu_MPa: float = Field(2.93, gt=0, description="neo-hooke: shear modulus (printed NinjaFlex)")
    ogden_mu_MPa: Terms = Field((), description="ogden: shear moduli of the terms")
    ogden_alpha: Terms = Field((), description="ogden: exponents of the stretches")
    C10_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)")
    C01_MPa: float | None = Field(None, description="polynomial: of (I2 - 3)")
    C20_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)²")
    C11_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)(I2 - 3)")
    C02_MPa: float | None = Field(None, description="polynomial: of (I2 - 3)²")
    C30_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)³")
    nu: float | None = Field(
        None, gt=0, lt=0.5, description="Poisson's ratio; default 0.45 where no bulk_MPa is given"
    )
    bulk_MPa: float | None = Field(None, gt=0, description="bulk modulus, instead of nu")
    density_kg_m3: float = Field(1190.0, gt=0, description="felt by gravity only")

    @model_validator(mode="after")
    def _of_its_law(self) -> Material:
        for key, value in self._foreign().items():
            raise outside(key, value, f'allowed: with another law than "{self.law}"')
        if self.law == "ogden":
            self._check_ogden()
        if self.law == "polynomial" and not self.coefficients_MPa:
            raise outside("C10_MPa", "none", 'allowed: a number with law = "polynomial"')
        if self.shear_MPa <= 0:
            key = {"ogden": "ogden_mu_MPa", "polynomial": "C10_MPa"}[self.law]
            value = list(self.ogden_mu_MPa) if self.law == "ogden" else self.C10_MPa
            raise outside(
                key, value, f"initial shear modulus {self.shear_MPa:g} MPa; allowed: above 0 MPa"
            )
        return self

    def _foreign(self) -> dict[str, object]:
        """What is given but belongs to another law."""
        owner: dict[str, dict[str, object]] = {
            "neo-hooke": {"mu_MPa": self.mu_MPa},
            "ogden": {"ogden_mu_MPa": self.ogden_mu_MPa, "ogden_alpha": self.ogden_alpha},
            "polynomial": {key: getattr(self, key) for key in POLYNOMIAL},
        }
        return {
            key: list(value) if isinstance(value, tuple) else value
            for law, keys in owner.items()
            for key, value in keys.items()
            if law != self.law and value != type(self).model_fields[key].default
        }

    def _check_ogden(self) -> None:
        count = len(self.ogden_mu_MPa)
        if not count:
            raise outside("ogden_mu_MPa", [], 'allowed: a list of numbers with law = "ogden"')
        alphas = list(self.ogden_alpha)
        if len(alphas) != count:
            raise outside(
                "ogden_alpha", alphas, f"allowed: as many numbers as ogden_mu_MPa has, {count}"
            )
        low, high = ALPHA
        if not all(low <= abs(alpha) <= high for alpha in alphas):
            raise outside(
                "ogden_alpha",
                alphas,
                f"allowed: each from {low:g} to {high:g}, or below 0 likewise",
            )

    @model_validator(mode="after")
    def _one_of(self) -> Material:
        if self.nu is not None and self.bulk_MPa is not None:
            raise outside("bulk_MPa", self.bulk_MPa, f"give either nu or bulk_MPa; nu = {self.nu}")
        if self.bulk_MPa is not None and self.bulk_MPa <= 2 / 3 * self.shear_MPa:
            name = "mu_MPa" if self.law == "neo-hooke" else "the initial shear modulus"
            raise outside(
                "bulk_MPa",
                self.bulk_MPa,
                f"allowed: above 2/3 {name} = {2 / 3 * self.shear_MPa:g} MPa (nu above 0)",
            )
        return self

    @property
    def coefficients_MPa(self) -> dict[tuple[int, int], float]:
        """The polynomial's factors by the exponents of Ī₁ − 3 and Ī₂ − 3; those that are given."""
        found = {powers: getattr(self, key) for key, powers in POLYNOMIAL.items()}
        return {powers: value for powers, value in found.items() if value is not None}

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        if self.law == "ogden":
            return sum(self.ogden_mu_MPa)
        if self.law == "polynomial":
            return 2 * ((self.C10_MPa or 0.0) + (self.C01_MPa or 0.0))
        return self.mu_MPa

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
