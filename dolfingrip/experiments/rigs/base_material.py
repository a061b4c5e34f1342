"""The base material's energy, by the law that the configuration chooses."""

from __future__ import annotations

from dataclasses import dataclass

import dolfinx
import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.forms import (
    bulk_modulus,
    mixed_bulk_modulus,
    mixed_neo_hookean,
    neo_hookean,
    ogden_terms,
    polynomial,
)
from dolfingrip.sections.material import POLYNOMIAL, Material

TABLE = "material"
"""Table of the configuration with the material of all regions that have none of their own."""


@dataclass(frozen=True, slots=True)
class BaseMaterial:
    """Constants of the base material's energy on a mesh.

    Attributes:
        material: as configured.
        mu, lmbda: moduli at small strain (MPa).
        constants: all of them by name, that sensitivities are taken to.
        table: of the configuration, which these names begin with.
    """

    material: Material
    mu: fem.Constant
    lmbda: fem.Constant
    constants: dict[str, fem.Constant]
    table: str = TABLE

    @classmethod
    def on(cls, mesh: dolfinx.mesh.Mesh, material: Material, table: str = TABLE) -> BaseMaterial:
        """The material's constants on ``mesh``."""
        made = {
            name: fem.Constant(mesh, np.asarray(value, dtype=PETSc.ScalarType))
            for name, value in values(material, table).items()
        }
        return cls(material, made[f"{table}.mu_MPa"], made[f"{table}.lmbda_MPa"], made, table)

    def energy(self, strain: Expr, p: fem.Function | None = None) -> Expr:
        """Energy per reference volume (mJ/mm³), mixed where there is a pressure field p."""
        if p is None:
            return self.of_shape(strain) + self.of_volume(strain)
        if self.material.law == "neo-hooke":
            return mixed_neo_hookean.energy(strain, p, self.mu, self.lmbda)
        return self.of_shape(strain) + mixed_bulk_modulus.energy(strain, p, self._bulk)

    def of_shape(self, strain: Expr) -> Expr:
        """That part of the energy that is not :meth:`of_volume`."""
        if self.material.law == "neo-hooke":
            return neo_hookean.energy(strain, self.mu, 0.0)
        return self._isochoric(strain)

    def of_volume(self, strain: Expr) -> Expr:
        """The part that a change of volume alone decides, stiff where ν is near 0.5."""
        stiffness = self.lmbda if self.material.law == "neo-hooke" else self._bulk
        return bulk_modulus.energy(strain, stiffness)

    @property
    def _bulk(self) -> Expr:
        return self.lmbda + 2 / 3 * self.mu

    def _isochoric(self, strain: Expr) -> Expr:
        if self.material.law == "ogden":
            mu, alpha = (self.constants[f"{self.table}.ogden_{key}"] for key in ("mu_MPa", "alpha"))
            terms = range(len(self.material.ogden_alpha))
            return ogden_terms.energy(strain, [mu[k] for k in terms], [alpha[k] for k in terms])
        given = {
            powers: self.constants[f"{self.table}.{key}"]
            for key, powers in POLYNOMIAL.items()
            if getattr(self.material, key) is not None
        }
        return polynomial.energy(strain, given)


def values(material: Material, table: str = TABLE) -> dict[str, np.ndarray | float]:
    """Values of the constants by name, which begins with the configuration's ``table``."""
    found: dict[str, np.ndarray | float] = {
        f"{table}.mu_MPa": material.shear_MPa,
        f"{table}.lmbda_MPa": material.lmbda_MPa,
    }
    if material.law == "ogden":
        for key in ("ogden_mu_MPa", "ogden_alpha"):
            found[f"{table}.{key}"] = np.array(getattr(material, key), dtype=float)
    if material.law == "polynomial":
        for key in POLYNOMIAL:
            if getattr(material, key) is not None:
                found[f"{table}.{key}"] = getattr(material, key)
    return found
