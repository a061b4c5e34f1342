"""The energy balance of a grasp: work done, energy stored, energy that friction dissipates."""

from __future__ import annotations

from dolfinx import fem
from mpi4py import MPI

from dolfingrip.config import KPA
from dolfingrip.experiments.rigs.gripper import GripperModel
from dolfingrip.mechanics.contact.friction import Friction
from dolfingrip.mechanics.model import jit


class EnergyBook:
    """Adds up the energies of each accepted step of a gripper.

    Stored energies are those of strain, of barriers, of friction that sticks elastically, of
    weights, and of the food's motion. Pressure does the work ∫ p dV and the table ∫ F dz, both by
    the trapezoidal rule. The rest is implicit Euler's damping, the rule's error, and energy that
    friction gains or loses as normal forces change.

    Args:
        gripper: model of the gripper at its start.

    Attributes:
        pressure_mJ: work of the pressure since the first step.
        table_mJ: work of the table on the food.
        friction_mJ: energy that sliding has dissipated; it never decreases.
        error_mJ: increase of the stored energy, less the works, plus the dissipated energy.
    """

    def __init__(self, gripper: GripperModel) -> None:
        self._gripper = gripper
        self._volume = fem.form(gripper.finger.enclosed, jit_options=jit.options())
        self._last: tuple[float, float, float, float, float] | None = None
        self.pressure_mJ = self.table_mJ = self.friction_mJ = self.error_mJ = 0.0

    def book(self) -> None:
        """Add the energies of the converged step at whose end the model is."""
        model, dofs = self._gripper.model, self._gripper.model.u.x.array
        copies = model.domain.copies
        taken = copies * sum(friction.dissipated_mJ(dofs) for friction in self._frictions)
        volume = copies * float(model.comm.allreduce(fem.assemble_scalar(self._volume), MPI.SUM))
        pressure = self._gripper.finger.cavity.value * KPA
        force, height = self._table_N(), model.controls["table_z_mm"].value
        stored = self._stored_mJ(taken) + pressure * volume
        if self._last is not None:
            before, then, pushed, place, was = self._last
            pressing = (pressure + then) / 2 * (volume - before)
            lifting = (force + pushed) / 2 * (height - place)
            self.pressure_mJ += pressing
            self.table_mJ += lifting
            self.error_mJ += stored - was - pressing - lifting + taken
        self.friction_mJ += taken
        self._last = volume, pressure, force, height, stored

    @property
    def _frictions(self) -> tuple[Friction, Friction]:
        return self._gripper.finger_friction, self._gripper.table_friction

    def _table_N(self) -> float:
        """Upward force of the table on the food."""
        return float(self._gripper.table.load_N(self._gripper.model.u.x.array)[2])

    def _stored_mJ(self, taken: float) -> float:
        """Stored energy (mJ): the potential without its pressure's part −p V."""
        gripper, dofs = self._gripper, self._gripper.model.u.x.array
        motion = gripper.motion
        inert = (motion, *self._frictions)
        terms = [term for term in gripper.model.all_terms if not any(term is i for i in inert)]
        copies = gripper.model.domain.copies
        meshed = sum(term.value(dofs) for term in (*terms, *self._frictions))
        height_mJ = -float(motion.weight_N @ gripper.pose.coordinates[:3])
        return copies * meshed - taken + height_mJ + motion.kinetic_mJ()
