"""All sections of the simple model, checked against one another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, Self

from pydantic import create_model, model_validator

from dolfingrip.sections.camera import Camera
from dolfingrip.sections.cavities import Cavities
from dolfingrip.sections.errors import bare, checked
from dolfingrip.sections.films import Film, Films
from dolfingrip.sections.fixture import Gravity, Plate
from dolfingrip.sections.form import Form
from dolfingrip.sections.geometry.geometry import Geometry, Integration
from dolfingrip.sections.geometry.index import GEOMETRIES
from dolfingrip.sections.gripper import Gripper
from dolfingrip.sections.numerics import Contact, Solver
from dolfingrip.sections.procedure import Coupon, Experiment, Protocol
from dolfingrip.sections.regions import Materials
from dolfingrip.sections.section import Section, outside
from dolfingrip.sections.specimen import Cog, Finger, Mesh, Morph

KINDS: Final = {name: kind for name, kind in GEOMETRIES.items() if kind.table() == name}
"""Kinds of geometry with a table of their own; bellows have their dimensions in ``finger``."""


class Sections(Section):
    """The sections that every kind of geometry has, and their checks against one another."""

    finger: Finger = Finger()
    material: Materials = Materials()
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
    film: Films = Films()
    cavity: Cavities = Cavities()
    camera: Camera = Camera()
    form: Form | None = None

    @model_validator(mode="before")
    @classmethod
    def _of_kind(cls, data: Any) -> Any:
        """Add the table of the kind of geometry with its defaults if it is not given."""
        finger = data.get("finger") if isinstance(data, dict) else None
        kind = finger.get("kind") if isinstance(finger, dict) else getattr(finger, "kind", None)
        if isinstance(kind, str) and kind in KINDS and data.get(kind) is None:
            return {**data, kind: {}}
        return data

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        kind = self.finger.kind
        for name in KINDS:
            if name != kind and getattr(self, name) is not None:
                raise outside("finger.kind", kind, f'allowed: "{name}" with a table [{name}]')
        if kind in KINDS:
            own = self.finger.model_dump(exclude_defaults=True, exclude={"kind"})
            for key, value in own.items():
                raise outside(
                    f"finger.{key}",
                    value,
                    f'of bellows; allowed: keys of [{kind}] with kind = "{kind}"',
                )
            if KINDS[kind].of_file and self.mesh.file is None:
                raise outside(
                    "finger.kind", kind, "a mesh file; allowed: with mesh.file, as adopt writes it"
                )
            tetrahedra = KINDS[kind].tetrahedra
            if self.mesh.file is None and not self.hexahedra and not tetrahedra:
                raise outside(
                    "finger.kind", kind, 'made of hexahedra; allowed: with solver.element = "S2"'
                )
            if self.mesh.file is None and self.hexahedra and not KINDS[kind].hexahedra:
                raise outside(
                    "finger.kind", kind, 'made of tetrahedra; allowed: with solver.element = "P2"'
                )
        return self

    @model_validator(mode="after")
    def _known_regions(self) -> Self:
        for name in self.material.own:
            self._check_region(f"material.{name}", name)
        layers: dict[str, str] = {}
        for name, film in self.film.all.items():
            for key, region in film.regions:
                if region:
                    self._check_region(f"film.{name}.{key}", region)
            if film.model == "layer":
                if film.region in self.material.own or film.region in layers:
                    other = layers.get(film.region, f"material.{film.region}")
                    raise outside(
                        f"film.{name}.region",
                        film.region,
                        f"has {other} already; allowed: one of them",
                    )
                layers[film.region] = f"film.{name}"
                if film.thickness_mm is None and self._thickness_mm(film.region) is None:
                    raise outside(f"film.{name}.thickness_mm", "none", "allowed: above 0 mm")
            if self.mesh.half and self.mesh.file is None and not film.symmetric:
                raise outside(
                    f"film.{name}.fibre_deg",
                    list(film.fibre_deg),
                    "allowed with mesh.half = true: families at 0, 90 or in pairs of opposite sign",
                )
        return self

    def _check_region(self, key: str, region: str) -> None:
        """Refuse a region that the geometry has not; those of a mesh file are not known yet."""
        known = self.geometry.regions
        if self.mesh.file is None and region not in known:
            allowed = ", ".join(known) or "none with this kind of geometry"
            raise outside(key, f'"{region}"', f"no such region; allowed: {allowed}")

    def _thickness_mm(self, region: str) -> float | None:
        """Thickness (mm) of a region that the geometry makes a film; None for another region."""
        return None if self.mesh.file else self.geometry.thickness_mm(region)

    @model_validator(mode="after")
    def _form_of_planes(self) -> Self:
        if self.form is None:
            return self
        if self.mesh.file is not None or self.geometry.of_file:
            raise outside("form", "a table", "allowed: with a finger that is made from dimensions")
        boxes = self.geometry.boxes()
        if boxes is None:
            raise outside("form", "a table", "allowed: with a finger that is made of boxes")
        expected = self.form.count(boxes)
        given = len(self.form.offsets_mm)
        if given != expected:
            raise outside(
                "form.offsets_mm", f"{given} numbers", f"allowed: {expected} for this finger"
            )
        return self

    def film_thickness_mm(self, film: Film) -> float:
        """Thickness of a layer."""
        found = film.thickness_mm or self._thickness_mm(film.region)
        assert found is not None  # the validator sees to it
        return found

    @model_validator(mode="after")
    def _known_cavities(self) -> Self:
        for name in self.cavity.all:
            known = self.geometry.cavities()
            if self.mesh.file is None and name not in known:
                allowed = f"allowed: {', '.join(known)}, or with mesh.file"
                raise outside(f"cavity.{name}", "a table", allowed)
        ratios = {self.cavity.ratio(name) for name in self.cavity.all} | {1.0}
        if len(ratios) > 1 and self.experiment.control != "pressure":
            raise outside(
                "experiment.control",
                self.experiment.control,
                'allowed: "pressure" where a cavity has a pressure_ratio other than 1',
            )
        return self

    @model_validator(mode="after")
    def _facing(self) -> Self:
        length_mm = self.geometry.length_mm
        if self.plate.contact_length_mm > length_mm:
            raise outside(
                "plate.contact_length_mm",
                self.plate.contact_length_mm,
                f"allowed: above 0 and up to {self.geometry_table}.length_mm = {length_mm:g} mm",
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

    @classmethod
    def classes(cls) -> dict[str, type[Section]]:
        """Return the class of each section, those of all kinds of geometry included."""
        return {name: bare(info.annotation) for name, info in cls.model_fields.items()}

    @property
    def tables(self) -> dict[str, Section]:
        """The sections by name, without those of other kinds of geometry."""
        found = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: section for name, section in found.items() if section is not None}

    def changed(self, **sections: Mapping[str, Any]) -> Self:
        """A checked copy with other values of some keys, by section.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        data = self.model_dump(exclude_none=True)
        for section, values in sections.items():
            data[section] = {**data.get(section, {}), **values}
        return checked(type(self), data)

    @property
    def geometry_table(self) -> str:
        """Name of the table with the dimensions."""
        return GEOMETRIES[self.finger.kind].table()

    @property
    def geometry(self) -> Geometry:
        """The table with the dimensions of the meshed solid, if no mesh file is given."""
        found = getattr(self, self.geometry_table)
        assert isinstance(found, Geometry)  # the validators see to it
        return found

    def drawn(self) -> dict[str, dict[str, Any]]:
        """The tables of dimensions for a measurement's TOML file."""
        found = {"finger": self.finger.model_dump(exclude_defaults=True)}
        if self.geometry_table != "finger":
            found[self.geometry_table] = self.geometry.model_dump(exclude_none=True)
        return found

    @property
    def hexahedra(self) -> bool:
        """Whether the finger is meshed in hexahedra, if no mesh file is given."""
        if self.solver.element is None:
            kind = GEOMETRIES[self.finger.kind]
            return kind.hexahedra and self.mesh.target_elements is None
        return self.solver.element == "S2"

    @property
    def integration(self) -> Integration:
        """How hexahedra are integrated."""
        if self.solver.integration is not None:
            return self.solver.integration
        return "reduced" if self.mesh.file is not None else self.geometry.integration

    @property
    def size_mm(self) -> float:
        """Largest element of a mesh made from sizes (mm)."""
        mesh = self.mesh
        sizes = mesh.hexahedra_mm(self.geometry) if self.hexahedra else mesh.tetrahedra_mm()
        return sizes[0]

    def sideways(self) -> tuple[str, object] | None:
        """The key and value of a load that a half finger cannot bear; None if there is none."""
        if self.plate.normal[1]:
            return "plate.normal", list(self.plate.normal)
        if self.gravity.acceleration_m_s2 and self.gravity.direction[1]:
            return "gravity.direction", list(self.gravity.direction)
        return None


if TYPE_CHECKING:  # its further tables are known as it runs only
    Setup = Sections
else:
    Setup = create_model(
        "Setup",
        __base__=Sections,
        __doc__="All that the simple model depends on: every section but the extensions.",
        **{name: (kind | None, None) for name, kind in KINDS.items()},
    )
