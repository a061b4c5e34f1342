"""The base class of laws of the base material: keys, moduli, strain energy and fits."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from ufl.core.expr import Expr

from dolfingrip.forms import isotropic
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.section import Role, Section


@dataclass(frozen=True, slots=True)
class Fittable:
    """Parameters of a law that a fit to coupons finds, the law's others left out.

    Attributes:
        name: as chosen with ``--law``.
        title: in tables.
        keys: of the parameters in the law's table, entries of lists numbered from 0.
        starts: values that a fit begins with, of a material of this shear modulus (MPa).
        low, high: bounds of each value.
        least: smallest size of each value, which then keeps the sign of its start; 0 where it may
            vanish.
        linear: whether the energy is linear in the values.
        fewer: name of the law that it is without one of its terms; "" where that is none.
    """

    name: str
    title: str
    keys: tuple[str, ...]
    starts: Callable[[float], Sequence[Sequence[float]]]
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()
    least: tuple[float, ...] = ()
    linear: bool = True
    fewer: str = ""

    def bounds(self, start: Sequence[float]) -> tuple[list[float], list[float]]:
        """Lower and upper bounds of the values, from a start."""
        count = len(self.keys)
        low = list(self.low or (-math.inf,) * count)
        high = list(self.high or (math.inf,) * count)
        for i, least in enumerate(self.least):
            if least and start[i] > 0:
                low[i] = max(low[i], least)
            elif least:
                high[i] = min(high[i], -least)
        return low, high


class MaterialLaw(Section):
    """The keys that a law has in ``[material]``, each with a default, and what follows from them.

    The table of such a material also has the keys that all laws share; see
    :mod:`dolfingrip.sections.material`.

    Attributes:
        law: the law's name.
        moduli: keys of its moduli, which the energy is linear in.
        shear_name: how an error names its initial shear modulus.
        fits: what of it is fitted to coupons.
    """

    role: ClassVar = Role.BODY
    law: str
    moduli: ClassVar[tuple[str, ...]]
    shear_name: ClassVar[str] = "the initial shear modulus"
    fits: ClassVar[tuple[Fittable, ...]] = ()

    @classmethod
    def law_name(cls) -> str:
        """Return the law's name in the configuration, which is its file's."""
        return cls.__module__.rpartition(".")[2].replace("_", "-")

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        raise NotImplementedError

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """Energy per reference volume at constant volume (mJ/mm³), with its derivatives.

        It is said once: with UFL's constants and invariants it is the solver's, with numbers a
        fit's.

        Args:
            c: numbers of the energy by key; lists for lists.
            invariants: of the isochoric stretches.
        """
        raise NotImplementedError

    @classmethod
    def of_shape(cls, strain: Expr, c: Mapping[str, Expr]) -> Expr:
        """Strain energy but for the part that :meth:`volumetric` is the stiffness of (mJ/mm³)."""
        return isotropic.energy(strain, lambda invariants: cls.energy(c, invariants))

    @classmethod
    def volumetric(cls, mu: Expr, lmbda: Expr) -> Expr:
        """Factor k of the volumetric energy k/2 (ln J)², by Lamé's parameters (MPa)."""
        return lmbda + 2 / 3 * mu
