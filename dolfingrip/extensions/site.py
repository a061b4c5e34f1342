"""The model under construction, as the hooks of effects receive it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import green_lagrange
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.friction import Friction
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.contact.tangential import Touching
from dolfingrip.mechanics.model.assembly import box, integral
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.inertia import FaceMass
from dolfingrip.mechanics.model.model import Prescribed
from dolfingrip.mechanics.model.state import History
from dolfingrip.mechanics.model.supports import SupportMotion
from dolfingrip.mechanics.model.term import Term
from dolfingrip.mechanics.model.unknowns import GlobalUnknown
from dolfingrip.sections.fixture import Gravity
from dolfingrip.sections.setup import Setup


class Named(Protocol):
    """The effect that a parameter, an unknown or an internal variable belongs to."""

    @classmethod
    def name(cls) -> str:
        """Name of its table in the configuration."""
        ...


@dataclass(slots=True)
class Site:
    """The model under construction.

    Attributes:
        config: everything that the simulation depends on.
        domain: reference configuration.
        u: displacement (mm).
        mu, lmbda: the base material's moduli (MPa).
        history: internal variables; the time and step as constants.
        p: pressure field of a mixed element (MPa); None for another element.
        plate: where one faces the finger.
        obstacle: contact with what stands beside the finger.
        held: regions whose displacement is held at 0, by axis; an effect may take some out
            and put a term of its own in their place.
        parameters: constants of the potential, by name; readings can be derived by them.
        unknowns: what is solved for besides the fields, by name.
        motions: of the clamp, by global unknowns among ``unknowns``.
        pressure: constant: that in the cavity at the load step's end (MPa), where there is one.
        set_point: the pressure that a supply of air is asked for; None without one.
        supplies: constants: pressures (MPa) of cavities with a supply of their own, by name.
        contact: of the skin with itself, where there is any.
        walls: contact of each cavity's walls with themselves, by its name; empty where they cannot
            meet.
        further: terms of Π that are no forms, without plate and contact.
        masses: fixed to the finger's faces.
        geometric: functions that must be called after the mesh has moved.
    """

    config: Setup
    domain: Domain
    u: fem.Function
    mu: fem.Constant
    lmbda: fem.Constant
    history: History
    p: fem.Function | None = None
    plate: RigidPlate | None = None
    obstacle: RigidContact | None = None
    held: dict[int, list[str]] = field(default_factory=dict)
    parameters: dict[str, fem.Constant] = field(default_factory=dict)
    unknowns: dict[str, GlobalUnknown] = field(default_factory=dict)
    motions: list[SupportMotion] = field(default_factory=list)
    pressure: fem.Constant | None = None
    set_point: Prescribed | None = None
    supplies: dict[str, fem.Constant] = field(default_factory=dict)
    contact: BarrierContact | None = None
    walls: dict[str, BarrierContact] = field(default_factory=dict)
    further: list[Term] = field(default_factory=list)
    masses: list[FaceMass] = field(default_factory=list)
    geometric: list[Callable[[], None]] = field(default_factory=list)

    @property
    def strain(self) -> Expr:
        """Green–Lagrange strain at the load step's end, (3, 3)."""
        return green_lagrange(self.u)

    @property
    def step_s(self) -> Expr:
        """Length of the load step (s); 0 if no time passes."""
        return self.history.step_s

    @property
    def time_s(self) -> Expr:
        """Time at the load step's end (s)."""
        return self.history.time_s

    @property
    def cycle(self) -> Expr:
        """Number of the cycle at the load step's end, from 1 on."""
        return self.history.cycle

    def constant(self, effect: Named, key: str) -> fem.Constant:
        """A parameter of ``effect`` as a constant of the potential; a list as a vector."""
        value = np.asarray(getattr(effect, key), dtype=PETSc.ScalarType)
        made = fem.Constant(self.domain.mesh, value)
        self.parameters[f"extensions.{effect.name()}.{key}"] = made
        return made

    def fixed(self, value: float) -> fem.Constant:
        """A constant for a number that depends on the mesh; a literal would recompile the form."""
        return fem.Constant(self.domain.mesh, PETSc.ScalarType(value))

    def unknown(
        self,
        effect: Named,
        name: str,
        number: fem.Constant | float = 0.0,
        *,
        scale: float = 1.0,
        multiplier: bool = False,
    ) -> GlobalUnknown:
        """A global unknown, solved for with the displacement; forms contain its ``constant``.

        Args:
            effect: the effect that it belongs to.
            name: its name, with its unit.
            number: where it starts; or a constant, such as ``plate.offset``, made unknown.
            scale: unit of the name that weighs as much as 1 mm, see
                :class:`~dolfingrip.mechanics.model.unknowns.GlobalUnknown`.
            multiplier: the potential is concave in it.
        """
        return self.own_unknown(f"{effect.name()}.{name}", number, scale, multiplier=multiplier)

    def own_unknown(
        self,
        name: str,
        number: fem.Constant | float,
        scale: float,
        *,
        multiplier: bool = False,
    ) -> GlobalUnknown:
        """A global unknown of no effect; see :meth:`unknown`."""
        if not isinstance(number, fem.Constant):
            number = self.fixed(number)
        made = GlobalUnknown(name, number, scale, multiplier=multiplier)
        self.unknowns[made.name] = made
        return made

    def move_clamp(self, unknown: GlobalUnknown, mode: Callable[[np.ndarray], np.ndarray]) -> None:
        """Let the clamp move with ``unknown``.

        Args:
            unknown: it moves with.
            mode: (3, n) reference coordinates (mm) to (3, n) displacements for each unit of it.
        """
        self.motions.append(SupportMotion(unknown, mode))

    def spring(
        self, effect: Named, force: str, moved: Expr, compliance: Expr, lever_mm: float = 1.0
    ) -> ufl.Form:
        """Potential f s − c f²/2 of a spring of compliance c, its force f an unknown.

        It is stationary in f where s = c f, so that c = 0 holds s at 0 exactly; f is what the
        spring is moved by, −∂Π/∂s of the rest.

        Args:
            effect: the effect that it belongs to.
            force: name of f, with its unit: N, or N mm where ``moved`` is an angle.
            moved: s, mm or rad, of an unknown's constant.
            compliance: c, mm/N or rad/(N mm).
            lever_mm: length by which an angle becomes a displacement of comparable size.
        """
        # 1 N weighs as much as 1 mm, about a soft finger's stiffness
        f = self.unknown(effect, force, scale=lever_mm, multiplier=True).constant
        return self.lumped(f * moved - compliance * f**2 / 2)

    def area_mm2(self, region: str) -> float:
        """Area (mm²) of a region of the whole undeformed solid."""
        part = self.domain.surface(region, quadrature_degree=2)
        return self.domain.copies * integral(self.fixed(1.0) * part)

    def add_friction(
        self, effect: Named, key: str, contact: Touching, slip_mm: float | None = None
    ) -> None:
        """Add friction to ``contact``, its coefficient the parameter ``key`` of ``effect``."""
        mu = self.constant(effect, key)
        self.further.append(Friction(contact, self.u, mu, slip_mm, effect.name()))

    def fix_mass(self, mass_t: Expr, lever_mm: Expr, region: str) -> ufl.Form:
        """Fix a mass to a region of the skin, which it turns with.

        Args:
            mass_t: mass (t) of the whole finger's.
            lever_mm: distance of its centre from the region, outwards.
            region: name of the region.

        Returns:
            The potential of its weight (mJ of the meshed part).
        """
        degree = 2 * self.u.function_space.ufl_element().degree
        part = self.domain.surface(region, quadrature_degree=degree)
        area = self.fixed(1.0) * part
        share = self._measured(lambda: np.array(1 / (self.domain.copies * integral(area))))
        fixed = FaceMass(mass_t * share, lever_mm, part)
        self.masses.append(fixed)
        falls = fem.Constant(self.domain.mesh, self.config.gravity.falls_mm_s2)
        self.parameters[Gravity.FALLS] = falls
        return -fixed.density_t_mm2 * ufl.inner(falls, fixed.moved(self.u)) * part

    def centre(self, region: str) -> fem.Constant:
        """Centroid (mm) of an undeformed region, (3,)."""
        x = ufl.SpatialCoordinate(self.domain.mesh)
        part = self.domain.surface(region, quadrature_degree=2)
        one = self.fixed(1.0)

        moments = [one * x[i] * part for i in range(3)]
        area = one * part

        def centroid() -> np.ndarray:
            return np.array([integral(moment) for moment in moments]) / integral(area)

        return self._measured(centroid)

    def extent(self, axis: int) -> fem.Constant:
        """Least and largest coordinate (mm) of the undeformed solid along an axis, (2,)."""
        mesh = self.domain.mesh

        return self._measured(lambda: box(mesh.comm, mesh.geometry.x)[:, axis].copy())

    def rest_volume(self, cavity: str) -> fem.Constant:
        """Volume (mm³) of a cavity of the whole undeformed finger."""
        x, normal = (kind(self.domain.mesh) for kind in (ufl.SpatialCoordinate, ufl.FacetNormal))
        part = self.domain.surface(cavity, quadrature_degree=3)
        volume = -self.fixed(self.domain.copies / 3) * ufl.inner(x, normal) * part
        return self._measured(lambda: np.array(integral(volume)))

    def size(self, region: str) -> float:
        """Root of a region's area (mm), of the meshed part."""
        area = integral(self.fixed(1.0) * self.domain.surface(region, quadrature_degree=2))
        return float(np.sqrt(area))

    def lumped(self, energy: Expr) -> ufl.Form:
        """An energy (mJ) of the whole finger that is no integral, as a term of the meshed part."""
        clamp = self.domain.surface("clamp", quadrature_degree=1)
        area = self.fixed(1.0) * clamp
        share = self._measured(lambda: np.array(1 / (self.domain.copies * integral(area))))
        return energy * share * clamp

    def _measured(self, measure: Callable[[], np.ndarray]) -> fem.Constant:
        """A constant that is measured on the mesh, and again after each motion of the mesh."""
        made = fem.Constant(self.domain.mesh, measure())

        def update() -> None:
            made.value = measure()

        self.geometric.append(update)
        return made

    def remember(self, effect: Named, name: str, initial: np.ndarray | float) -> fem.Function:
        """A new internal variable at the integration points, which starts as ``initial``."""
        return self.history.variable(f"{effect.name()}.{name}", initial)
