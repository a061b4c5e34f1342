"""All sections of the simple model as one, checked against one another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import model_validator

from dolfingrip.sections.complaint import checked
from dolfingrip.sections.fixture import Gravity, Plate
from dolfingrip.sections.food import Food
from dolfingrip.sections.gripper import Gripper
from dolfingrip.sections.numerics import Contact, Solver
from dolfingrip.sections.procedure import Coupon, Experiment, Protocol
from dolfingrip.sections.section import Section, outside
from dolfingrip.sections.specimen import Cog, Finger, Material, Mesh, Morph


class Setup(Section):
    """All that a simulation of the simple model depends on: every section but the extensions."""

    finger: Finger = Finger()
    material: Material = Material()
    mesh: Mesh = Mesh()
    morph: Morph = Morph()
    cog: Cog = Cog()
    solver: Solver = Solver()
    contact: Contact = Contact()
    plate: Plate = Plate()
    gravity: Gravity = Gravity()
    experiment: Experiment = Experiment()
    protocol: Protocol = Protocol()
    coupon: Coupon = Coupon()
    gripper: Gripper = Gripper()
    food: Food = Food()

    @model_validator(mode="after")
    def _facing(self) -> Setup:
        if self.plate.contact_length_mm > self.finger.length_mm:
            raise outside(
                "plate.contact_length_mm",
                self.plate.contact_length_mm,
                f"allowed: above 0 and up to finger.length_mm = {self.finger.length_mm:g} mm",
            )
        if self.solver.element == "S2" and self.mesh.target_elements is not None:
            raise outside(
                "mesh.target_elements",
                self.mesh.target_elements,
                'a number of tetrahedra; allowed: with solver.element = "P1" or "P2"',
            )
        if self.mesh.half and self.mesh.file is None:
            sideways = self.sideways()
            if sideways is not None:
                raise outside(*sideways, "allowed: no y-part with mesh.half = true")
        return self

    def changed(self, **sections: Mapping[str, Any]) -> Self:
        """A checked copy with other values of some keys, by section.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        data = self.model_dump(exclude_none=True)
        for section, values in sections.items():
            data[section] = {**data[section], **values}
        return checked(type(self), data)

    @property
    def hexahedra(self) -> bool:
        """Whether the finger is to be meshed in hexahedra, where no mesh file is given."""
        if self.solver.element is None:
            return self.mesh.target_elements is None
        return self.solver.element == "S2"

    @property
    def size_mm(self) -> float:
        """Largest element of a mesh made from sizes (mm)."""
        mesh = self.mesh
        sizes = mesh.hexahedra_mm(self.finger) if self.hexahedra else mesh.tetrahedra_mm()
        return sizes[0]

    def sideways(self) -> tuple[str, object] | None:
        """The key and value of a load that a half finger cannot bear, where there is one."""
        if self.plate.normal[1]:
            return "plate.normal", list(self.plate.normal)
        if self.gravity.acceleration_m_s2 and self.gravity.direction[1]:
            return "gravity.direction", list(self.gravity.direction)
        return None
