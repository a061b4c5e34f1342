"""Volume control, which passes limit points: the pressure is the volume's multiplier."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.mechanics.model.assembly import integral, owned_vector, undeformed
from dolfingrip.mechanics.model.model import Control, Model, SetPoint
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.state import Memory
from dolfingrip.mechanics.model.term import Coupling, Term, global_coupling
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient

CONTROL = "cavity_volume_mm3"
"""Name of the volume among a model's controls."""


class VolumeControl(Term, Memory):
    """Adds the constraint V(u) = V* to Π; its multiplier is the cavity's pressure.

    Π contains −p V(u). With + p V* it is stationary in p where V = V*, so that equilibria follow
    one another through a limit point of the pressure (Batoz & Dhatt, Int. J. Numer. Methods Eng.
    14, 1979).

    Args:
        u: displacement (mm).
        pressure: control of the pressure, which becomes a result.
        volume: UFL form of the meshed cavity's volume (mm³).
        copies: number of meshed parts in the whole.

    Attributes:
        control: volume of the whole cavity (mm³) on the reference mesh as it was made, of which the
            ratio to the undeformed one is prescribed; it starts as the present volume.
        unknown: the pressure as an unknown.
    """

    name: ClassVar[str] = "volume"

    def __init__(
        self, u: fem.Function, pressure: Control, volume: ufl.Form, copies: int = 1
    ) -> None:
        space = u.function_space
        self._comm = space.mesh.comm
        self._first = space.dofmap.index_map.local_range[0]
        self._copies = copies
        self._volume = volume
        test = ufl.TestFunction(space)
        self._rate = ufl.derivative(volume, u, test)
        self.control, self._growth = SetPoint(self.volume_mm3()), 1.0
        self._u = u
        self._undeformed = self._undeformed_mm3()
        # 1 MPa for each size of the cavity: a missing volume then counts as much as the forces on
        # the cavity's walls that go with it
        scale = float(np.cbrt(copies / self.control.value))
        self.unknown = GlobalUnknown(
            "cavity_pressure_MPa", pressure.constant, scale, multiplier=True
        )
        self._force_N = self._load_N()

    def volume_mm3(self) -> float:
        """Present volume of the whole cavity."""
        return self._copies * integral(self._volume)

    def _undeformed_mm3(self) -> float:
        """Volume of the whole cavity without any displacement."""
        with undeformed(self._u):
            return self.volume_mm3()

    # -- as a term -------------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """p V* of the meshed part (mJ)."""
        return self.unknown.value * self.given_mm3() / self._copies

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the residual V* − V."""
        gradient.add(self.unknown, (self.given_mm3() - self.volume_mm3()) / self._copies)

    def given_mm3(self) -> float:
        """V* at the present pressure."""
        return self.control.value * self._growth

    def given_slope(self) -> float:
        """Derivative of V* by the pressure (mm³/MPa)."""
        return 0.0

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """−∂V/∂u between pressure and displacement, and what V* changes by with the pressure."""
        rates = owned_vector(self._rate)  # of the meshed volume (mm²)
        within = np.array([[self.given_slope() / self._copies]])
        return [global_coupling([self.unknown], self._first, -rates[None], within)]

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        """Add p ∂V*/∂X, as V* grows with the undeformed cavity."""
        share = self.control.value / self._undeformed
        with undeformed(self._u):
            gradient.add_form(self._volume, self.unknown.value * share)

    def move_reference(self, change: np.ndarray | None) -> None:
        """Let the controlled volume grow with the undeformed cavity."""
        self._growth = self._undeformed_mm3() / self._undeformed

    def accept(self) -> None:
        """Make the pressure's load the scale of the next step's residual.

        An iterate that diverges may have any pressure, and with it any state would pass as an
        equilibrium.
        """
        self._force_N = self._load_N()

    def scale_N(self) -> float:
        """Norm of the pressure's load at the load step's start."""
        return self._force_N

    def _load_N(self) -> float:
        rates = owned_vector(self._rate)
        square = self._comm.allreduce(float(rates @ rates), MPI.SUM)
        return abs(self.unknown.value) * float(np.sqrt(square))


def volume_controlled(model: Model, pressure: Control, volume: ufl.Form) -> Model:
    """A model of the same fields and terms whose control is the cavity's volume.

    Supplies, by which a regulator prescribes pressures, are left out: they would set the pressure
    back. Those of other cavities keep their present pressures.

    Args:
        model: model with ``pressure`` among its controls.
        pressure: control that becomes a result of the new model.
        volume: UFL form of the meshed cavity's volume (mm³).
    """
    term = VolumeControl(model.u, pressure, volume, model.domain.copies)
    return model.without_supplies().with_term(term, [term.unknown], {CONTROL: term.control})
