"""What effects are handed as a model is built."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import green_lagrange
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.friction import Friction, SLIP_mm
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.contact.tangential import Touching
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.history import History
from dolfingrip.mechanics.model.term import Term
from dolfingrip.sections.setup import Setup


class Named(Protocol):
    """What a parameter, an unknown or an internal variable belongs to: an effect."""

    @classmethod
    def name(cls) -> str:
        """Name of its table in the configuration."""
        ...


@dataclass(slots=True)
class Site:
    """The model under construction.

    Attributes:
        config: all that the simulation depends on.
        domain: reference configuration.
        u: displacement (mm).
        mu, lmbda: the base material's moduli (MPa).
        history: internal variables; the time and step as constants.
        plate: where one faces the finger.
        held: regions whose displacement is held at 0, by axis; an effect may take some out
            and put a term of its own in their place.
        parameters: constants of the potential by name, that sensitivities are taken to.
        unknowns: constants of the further terms that are solved for, by name.
        pressure: constant: that in the cavity at the load step's end (MPa), where there is one.
        contact: of the skin with itself, where there is any.
        further: terms of Π that are no forms, beside plate and contact.
    """

    config: Setup
    domain: Domain
    u: fem.Function
    mu: fem.Constant
    lmbda: fem.Constant
    history: History
    plate: RigidPlate | None = None
    held: dict[int, list[str]] = field(default_factory=dict)
    parameters: dict[str, fem.Constant] = field(default_factory=dict)
    unknowns: dict[str, fem.Constant] = field(default_factory=dict)
    pressure: fem.Constant | None = None
    contact: BarrierContact | None = None
    further: list[Term] = field(default_factory=list)

    @property
    def strain(self) -> Expr:
        """Green–Lagrange strain at the load step's end, (3, 3)."""
        return green_lagrange(self.u)

    @property
    def step_s(self) -> Expr:
        """Length of the load step (s), 0 where no time passes."""
        return self.history.step_s

    @property
    def time_s(self) -> Expr:
        """Time at the load step's end (s)."""
        return self.history.time_s

    def constant(self, effect: Named, key: str) -> fem.Constant:
        """A parameter of ``effect`` as a constant of the potential; a list as a vector."""
        value = np.asarray(getattr(effect, key), dtype=PETSc.ScalarType)
        made = fem.Constant(self.domain.mesh, value)
        self.parameters[f"extensions.{effect.name()}.{key}"] = made
        return made

    def fixed(self, value: float) -> fem.Constant:
        """A number that depends on the mesh; written into a form it would compile it anew."""
        return fem.Constant(self.domain.mesh, PETSc.ScalarType(value))

    def unknown(self, effect: Named, name: str, number: fem.Constant | float = 0.0) -> Expr:
        """A number (mm or rad) of the further terms that is solved for with the displacement.

        Args:
            effect: whose it is.
            name: its name, with its unit.
            number: where it starts; or a constant, such as ``plate.offset``, made unknown.
        """
        if not isinstance(number, fem.Constant):
            number = self.fixed(number)
        self.unknowns[f"{effect.name()}.{name}"] = number
        return number

    def rub(self, effect: Named, key: str, contact: Touching, slip_mm: float = SLIP_mm) -> None:
        """Add friction to ``contact``, its coefficient the parameter ``key`` of ``effect``."""
        mu = self.constant(effect, key)
        self.further.append(Friction(contact, self.u, mu, slip_mm, effect.name()))

    def centre(self, region: str) -> fem.Constant:
        """Centroid of a region at rest (mm), (3,)."""
        x = ufl.SpatialCoordinate(self.domain.mesh)
        part = self.domain.surface(region, quadrature_degree=2)
        one = self.fixed(1.0)
        moments = np.array([self._integral(one * x[i] * part) for i in range(3)])
        return fem.Constant(self.domain.mesh, moments / self._integral(one * part))

    def _integral(self, form: ufl.Form) -> float:
        """Over the meshed part, on all ranks."""
        return float(self.domain.mesh.comm.allreduce(fem.assemble_scalar(fem.form(form))))

    def lumped(self, energy: Expr) -> ufl.Form:
        """An energy (mJ) of the whole finger that is no integral, as a term of the meshed part."""
        clamp = self.domain.surface("clamp", quadrature_degree=1)
        area = self.domain.copies * self._integral(self.fixed(1.0) * clamp)
        return energy * self.fixed(1 / area) * clamp

    def remember(self, effect: Named, name: str, initial: np.ndarray | float) -> fem.Function:
        """A new internal variable at the integration points, ``initial`` at first."""
        return self.history.variable(f"{effect.name()}.{name}", initial)
