"""What is read off a finger at one state."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.experiments.bellows import BellowsGaps, smallest_mm
from dolfingrip.experiments.finger import FingerModel
from dolfingrip.forms import tip_face
from dolfingrip.mechanics.model import jit


class Observation:
    """Readings of a finger model, in the columns of the result table.

    ``angle_deg`` is the rotation of the tip face's area vector about y from the unpressurised
    pose, positive towards the base layer (−x), continuous beyond 180°; ``chord_angle_deg`` that
    of the line from the clamp's centre to the tip's. The tip's displacement is from the mesh,
    so that under gravity it shows the sag which the angles do not. Volume and force are the
    whole finger's.

    Attributes:
        gaps_mm: distance between neighbouring parts by their names (mm) at the last reading.
    """

    def __init__(self, finger: FingerModel) -> None:
        self._finger = finger
        model = finger.model
        mesh, u = model.domain.mesh, model.u
        self._comm = mesh.comm
        degree = u.function_space.ufl_element().degree
        tip = model.domain.surface("tip", quadrature_degree=2 * degree)
        clamp = model.domain.surface("clamp", quadrature_degree=1)
        x = ufl.SpatialCoordinate(mesh)

        def form(integral: ufl.Form) -> fem.Form:
            return fem.form(integral, jit_options=jit.options())

        one = fem.Constant(mesh, 1.0)
        self._moved = [form(u[i] * tip) for i in range(3)]
        self._area_vector = [form(tip_face.area_vector(u, mesh)[i] * tip) for i in range(3)]
        self._volume = form(finger.enclosed)
        self._tip_area = self._integrate(form(one * tip))
        tip_centre = [self._integrate(form(x[i] * tip)) / self._tip_area for i in (0, 2)]
        clamp_area = self._integrate(form(one * clamp))
        clamp_centre = [self._integrate(form(x[i] * clamp)) / clamp_area for i in (0, 2)]
        self._arm = np.subtract(tip_centre, clamp_centre)
        self.tare()
        self._clamped = _clamped_rows(finger)
        self._gaps = BellowsGaps(finger)
        self.gaps_mm: dict[str, float] = {}

    def _integrate(self, form: fem.Form) -> float:
        return float(self._comm.allreduce(fem.assemble_scalar(form), MPI.SUM))

    def _tip_displacement(self) -> np.ndarray:
        return np.array([self._integrate(form) for form in self._moved]) / self._tip_area

    def _face_angle(self) -> float:
        x, _, z = (self._integrate(form) for form in self._area_vector)
        return float(np.degrees(np.arctan2(-x, z)))

    def _chord_angle(self, moved: np.ndarray) -> float:
        x, z = self._arm + moved[[0, 2]]
        return float(np.degrees(np.arctan2(-x, z)))

    def tare(self) -> None:
        """Take the present pose as the one from which angles are measured."""
        self._rest_angle = self._face_angle()
        self._rest_chord = self._chord_angle(self._tip_displacement())
        self._last = {"angle": 0.0, "chord": 0.0}

    def _unwrap(self, name: str, angle_deg: float) -> float:
        """The branch of the angle that is nearest to the last reading."""
        last = self._last[name]
        self._last[name] = angle_deg + 360 * round((last - angle_deg) / 360)
        return self._last[name]

    def clamp_force_N(self) -> np.ndarray:
        """(3,) force of the clamp on the whole finger."""
        model = self._finger.model
        local = model.reactions()[self._clamped].sum(axis=0)
        return model.domain.copies * np.asarray(self._comm.allreduce(local, MPI.SUM))

    def read(self) -> dict[str, float]:
        """Readings by column; forces of the blocked finger only where there is a plate."""
        model, plate = self._finger.model, self._finger.plate
        moved = self._tip_displacement()
        self.gaps_mm = self._gaps.all_mm()
        row = {
            "time_s": model.time_s,
            "pressure_kPa": model.controls["pressure_kPa"].value,
            "angle_deg": self._unwrap("angle", self._face_angle() - self._rest_angle),
            "tip_x_mm": float(moved[0]),
            "tip_z_mm": float(moved[2]),
            "chord_angle_deg": self._unwrap("chord", self._chord_angle(moved) - self._rest_chord),
            "cavity_pressure_kPa": self._finger.cavity.value,
            "cavity_volume_mm3": model.domain.copies * self._integrate(self._volume),
            "contact_gap_mm": smallest_mm(self.gaps_mm),
        }
        if plate is not None:
            row["force_N"] = plate.force_N()
            row["plate_gap_mm"] = plate.gap_mm()
        return row


def _clamped_rows(finger: FingerModel) -> np.ndarray:
    """Owned displacement nodes on the clamp."""
    space = finger.model.u.function_space
    nodes = fem.locate_dofs_topological(space, 2, finger.model.domain.facets("clamp"))
    return nodes[nodes < space.dofmap.index_map.size_local]
