"""The base class of effects that add an energy of the strain to the base model's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Site, StrainEnergy


class Elastic(Effect):
    """An effect whose energy is added to the base model's; it has no memory."""

    kind: ClassVar = "elastic"

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        """Return the energy per reference volume (mJ/mm³).

        Args:
            strain: Green–Lagrange strain, (3, 3).
            mu: shear modulus of the base material (MPa).
            c: the effect's parameters by key, as constants of the form.
        """
        raise NotImplementedError

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        c = {key: site.constant(self, key) for key in type(self).model_fields}
        return lambda strain: base(strain) + self.added(strain, site.mu, c)
