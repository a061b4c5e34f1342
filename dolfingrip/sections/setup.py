"""All sections of the simple model, checked against one another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

from pydantic import create_model, model_validator

from dolfingrip.channels import VACUUM_KPA
from dolfingrip.plugins import PluginError
from dolfingrip.sections.base_motion import BaseMotion
from dolfingrip.sections.curve import CurveTarget
from dolfingrip.sections.errors import bare, checked
from dolfingrip.sections.films import Film, Films
from dolfingrip.sections.fixture import Camera, Gravity, PlateSettings
from dolfingrip.sections.form import Form
from dolfingrip.sections.geometry.geometry import Geometry, Integration
from dolfingrip.sections.geometry.index import GEOMETRIES
from dolfingrip.sections.gripper import Gripper
from dolfingrip.sections.making import Inlet, Mould
from dolfingrip.sections.material import DEFAULT, AnyMaterials
from dolfingrip.sections.numerics import Contact, Solver
from dolfingrip.sections.procedure import (
    NO_VACUUM,
    Cavities,
    CouponSettings,
    ExperimentSettings,
    Protocol,
)
from dolfingrip.sections.release import Release
from dolfingrip.sections.section import Refusal, Section
from dolfingrip.sections.specimen import Cog, Finger, Mesh, ThicknessMorph
from dolfingrip.sections.supply import AirLine

IN_TIME: Final = ("supply", "protocol", "release", "base")
"""Tables that say what happens in time."""
KINDS: Final = {name: kind for name, kind in GEOMETRIES.items() if kind.table() == name}
"""Kinds of geometry with a table of their own; bellows have their dimensions in ``finger``."""


class Sections(Section):
    """The sections that every kind of geometry has, and their checks against one another."""

    extensible: ClassVar = True

    finger: Finger = Finger()
    material: AnyMaterials = DEFAULT
    mesh: Mesh = Mesh()
    morph: ThicknessMorph = ThicknessMorph()
    cog: Cog = Cog()
    solver: Solver = Solver()
    contact: Contact = Contact()
    plate: PlateSettings = PlateSettings()
    gravity: Gravity = Gravity()
    experiment: ExperimentSettings = ExperimentSettings()
    protocol: Protocol = Protocol()
    release: Release = Release()
    base: BaseMotion = BaseMotion()
    coupon: CouponSettings = CouponSettings()
    gripper: Gripper = Gripper()
    film: Films = Films()
    cavity: Cavities = Cavities()
    supply: AirLine | None = None
    camera: Camera = Camera()
    mould: Mould = Mould()
    inlet: Inlet | None = None
    form: Form | None = None
    curve: CurveTarget | None = None

    @model_validator(mode="before")
    @classmethod
    def _of_kind(cls, data: Any) -> Any:
        """Add the table of the kind of geometry with its defaults if it is not given."""
        finger = data.get("finger") if isinstance(data, dict) else None
        kind = finger.get("kind") if isinstance(finger, dict) else getattr(finger, "kind", None)
        if isinstance(kind, str) and kind in KINDS and data.get(kind) is None:
            return {**data, kind: {}}
        return data

    def walls_may_meet(self, cavities: Iterable[str]) -> bool:
        """Return whether walls of a cavity may come to touch one another.

        They may under suction, and where a neighbour has another pressure.

        Args:
            cavities: names of the mesh's cavities.
        """
        names = list(cavities)
        driven = {self.cavity.own.get(name, self.cavity.ratio(name)) for name in names}
        lowest = min(min(self._in_cavity_kPa(name)) for name in names)
        return lowest < 0 or (self.contact.self_contact and len(driven) > 1)

    @property
    def pressures_kPa(self) -> tuple[float, ...]:
        """Lowest and highest pressure of all supplies."""
        supplied_kPa = (p for pressures in self.cavity.own.values() for p in pressures)
        all_kPa = (*self.of_experiment_kPa, *supplied_kPa)
        return min(all_kPa), max(all_kPa)

    @property
    def of_experiment_kPa(self) -> tuple[float, float]:
        """Lowest and highest pressure of the supply that cavities share."""
        if self.protocol.time_s and not self.protocol.volume_ml:
            pressures: Sequence[float] = self.protocol.pressure_kPa
        else:
            pressures = (self.experiment.min_pressure_kPa, self.experiment.max_pressure_kPa)
        return min(pressures, default=0.0), max(pressures, default=0.0)

    def _in_cavity_kPa(self, name: str) -> Sequence[float]:
        """Pressures that a supply gives a cavity, its lowest and highest among them."""
        ratio = self.cavity.ratio(name)
        return self.cavity.own.get(name) or [end * ratio for end in self.of_experiment_kPa]

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the sections do not allow one another."""
        yield from self._kind_refused()
        yield from self._regions_refused()
        yield from self._form_refused()
        yield from self._cavities_refused()
        yield from self._supply_refused()
        yield from self._loads_refused()

        if self.release.acts and not self.experiment.dynamic:
            yield Refusal(f"release.{self.release.key}", "allowed: with experiment.dynamic = true")
        if self.base.time_s and not self.experiment.dynamic:
            yield Refusal("base.time_s", "allowed: with experiment.dynamic = true")

    def _kind_refused(self) -> Iterator[Refusal]:
        kind = self.finger.kind
        for name in KINDS:
            if name != kind and getattr(self, name) is not None:
                yield Refusal("finger.kind", f'allowed: "{name}" with a table [{name}]')
        if kind not in KINDS:
            return
        for key in self.finger.model_dump(exclude_defaults=True, exclude={"kind"}):
            words = f'of bellows; allowed: keys of [{kind}] with kind = "{kind}"'
            yield Refusal(f"finger.{key}", words)
        if self.mesh.file is not None:
            return
        if KINDS[kind].of_file:
            words = "a mesh file; allowed: with mesh.file, as adopt writes it"
            yield Refusal("finger.kind", words)
        if not (KINDS[kind].hexahedra if self.hexahedra else KINDS[kind].tetrahedra):
            cells, element = ("tetrahedra", "P2") if self.hexahedra else ("hexahedra", "S2")
            words = f'made of {cells}; allowed: with solver.element = "{element}"'
            yield Refusal("finger.kind", words)

    def _regions_refused(self) -> Iterator[Refusal]:
        for name in self.material.own:
            yield from self._region_refused(f"material.{name}", name)
        layers: dict[str, str] = {}
        for name, film in self.film.all.items():
            for key, region in film.regions:
                if region:
                    yield from self._region_refused(f"film.{name}.{key}", region)
            if film.model == "layer":
                if film.region in self.material.own or film.region in layers:
                    other = layers.get(film.region, f"material.{film.region}")
                    words = f"has {other} already; allowed: one of them"
                    yield Refusal(f"film.{name}.region", words, film.region)
                layers[film.region] = f"film.{name}"
                if film.thickness_mm is None and self._thickness_mm(film.region) is None:
                    yield Refusal(f"film.{name}.thickness_mm", "allowed: above 0 mm", "none")

    def _region_refused(self, key: str, region: str) -> Iterator[Refusal]:
        """Refuse a region that the geometry has not; those of a mesh file are not known yet."""
        regions = self.geometry.regions
        if self.mesh.file is None and region not in regions:
            allowed = ", ".join(regions) or "none with this kind of geometry"
            yield Refusal(key, f"no such region; allowed: {allowed}", f'"{region}"')

    def _thickness_mm(self, region: str) -> float | None:
        """Thickness (mm) of a region that the geometry makes a film; None for another region."""
        return None if self.mesh.file else self.geometry.thickness_mm(region)

    def _form_refused(self) -> Iterator[Refusal]:
        if self.form is None:
            return
        if self.mesh.file is not None or self.geometry.of_file:
            yield Refusal("form", "allowed: with a finger that is made from dimensions", "a table")
        boxes = self.geometry.boxes()
        if boxes is None:
            yield Refusal("form", "allowed: with a finger that is made of boxes", "a table")
            return
        words = f"allowed: {self.form.count(boxes)} for this finger"
        if (given := len(self.form.offsets_mm)) != self.form.count(boxes):
            yield Refusal("form.offsets_mm", words, f"{given} numbers")

    def film_thickness_mm(self, film: Film) -> float:
        """Thickness of a layer."""
        thickness = film.thickness_mm or self._thickness_mm(film.region)
        assert thickness is not None  # the validator sees to it
        return thickness

    def _cavities_refused(self) -> Iterator[Refusal]:
        for name in self.cavity.all:
            cavities = self.geometry.cavities()
            if self.mesh.file is None and name not in cavities:
                allowed = f"allowed: {', '.join(cavities)}, or with mesh.file"
                yield Refusal(f"cavity.{name}", allowed, "a table")
            pressures, lowest = self.cavity.own.get(name, ()), min(self._in_cavity_kPa(name))
            if pressures and len(pressures) != (count := len(self.protocol.time_s)):
                words = f"allowed: one for each time of the protocol, {count}"
                yield Refusal(f"cavity.{name}.pressure_kPa", words, f"{len(pressures)} values")
            if lowest < VACUUM_KPA:
                words = f"{lowest:g} kPa in it, {NO_VACUUM}"
                key, shown = (
                    ("pressure_kPa", list(pressures)) if pressures else ("pressure_ratio", None)
                )
                yield Refusal(f"cavity.{name}.{key}", words, shown or self.cavity.ratio(name))
        cavities = () if self.mesh.file else self.geometry.cavities()
        ratios = [self.cavity.ratio(name) for name in {*self.cavity.all, *cavities}] or [1.0]
        if self.experiment.control != "pressure" and (min(ratios) < 0 or max(ratios) == 0):
            words = 'allowed: "pressure" where a pressure_ratio is negative, or all are 0'
            yield Refusal("experiment.control", words)

    def _supply_refused(self) -> Iterator[Refusal]:
        if self.supply is None:
            return
        source, highest = self.supply.source, self.pressures_kPa[1]
        wanted = "volume" if source == "syringe" else "pressure"
        if self.experiment.control != wanted:
            words = f'allowed with supply.source = "{source}": "{wanted}"'
            yield Refusal("experiment.control", words, f'"{self.experiment.control}"')
        if wanted == "pressure" and highest > (most := self.supply.most_kPa):
            words = f"its source never has the {highest:g} kPa that are asked for"
            key = "tank_kPa" if source == "tank" else "pump_kPa"
            yield Refusal(
                f"supply.{key}", f"{words}; allowed: from {highest:g} kPa on", f"{most:g}"
            )
        for name, cavity in self.cavity.all.items():
            if cavity.pressure_kPa or cavity.pressure_ratio not in (0, 1):
                words = "allowed with [supply], which all cavities share: 1, or 0 for a vented one"
                yield Refusal(f"cavity.{name}.pressure_ratio", words)

    def _loads_refused(self) -> Iterator[Refusal]:
        length_mm = self.geometry.length_mm
        if self.plate.contact_length_mm > length_mm:
            words = f"{self.geometry_table}.length_mm = {length_mm:g} mm"
            yield Refusal("plate.contact_length_mm", f"allowed: above 0 and up to {words}")
        if self.solver.element == "S2" and self.mesh.target_elements is not None:
            words = 'a number of tetrahedra; allowed: with solver.element = "P1" or "P2"'
            yield Refusal("mesh.target_elements", words)
        if self.mesh.both_sides and not self.hexahedra:
            yield Refusal("mesh.both_sides", 'allowed: with hexahedra, solver.element = "S2"')
        if self.mesh.file is not None and self.geometry.differ:
            table = self.geometry_table
            words = f"allowed: without [{table}.override] and [{table}.along]"
            yield Refusal("mesh.file", words, str(self.mesh.file))
        for key in ("size_mm", "edge_size_mm", "target_elements", "both_sides"):
            if self.mesh.file is not None and getattr(self.mesh, key):
                words = "of elements that are made; allowed: without mesh.file, or mesh.refine"
                yield Refusal(f"mesh.{key}", words)
        if self.mesh.half and self.mesh.file is None:  # a file's mesh may be whole
            yield from self.uneven()

    @classmethod
    def classes(cls) -> dict[str, type[Section]]:
        """Return the class of each section, those of all kinds of geometry included."""
        return {name: bare(info.annotation) for name, info in cls.model_fields.items()}

    @property
    def tables(self) -> dict[str, Section]:
        """The sections by name, without those of other kinds of geometry."""
        sections = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: section for name, section in sections.items() if section is not None}

    def changed(self, **sections: Mapping[str, Any]) -> Self:
        """A checked copy with other values of some keys, by section.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        data = self.opened(sections)
        for section, values in sections.items():
            data[section] = {**data.get(section, {}), **values}
        return checked(type(self), data)

    def at_rest(self) -> Self:
        """A checked copy without what lies in time: supply, protocol, release, motion, inertia.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        data = self.opened(["experiment"])
        data["experiment"] |= {"dynamic": False, "control": "pressure", "cycles": 1,
                               "unload": False, "hold_s": 0.0, "rest_s": 0.0}  # fmt: skip
        kept = {name: table for name, table in data.items() if name not in IN_TIME}
        return checked(type(self), kept)

    def opened(self, sections: Iterable[object]) -> dict[str, Any]:
        """Return the sections by name, some of them as plain data that may be changed.

        The others are checked already, so that a check of the whole takes them as they are.

        Args:
            sections: names of those that become plain data.
        """
        tables: dict[str, Any] = self.tables
        opened = {name: tables[name] for name in sections if name in tables}
        return tables | {n: section.model_dump(exclude_none=True) for n, section in opened.items()}

    @property
    def geometry_table(self) -> str:
        """Name of the table with the dimensions."""
        return GEOMETRIES[self.finger.kind].table()

    @property
    def geometry(self) -> Geometry:
        """The table with the dimensions of the meshed solid, if no mesh file is given."""
        geometry = getattr(self, self.geometry_table)
        assert isinstance(geometry, Geometry)  # the validators see to it
        return geometry

    def drawn(self) -> dict[str, dict[str, Any]]:
        """The tables of dimensions for a measurement's TOML file."""
        tables = {"finger": self.finger.model_dump(exclude_defaults=True)}
        if self.geometry_table != "finger":
            tables[self.geometry_table] = self.geometry.model_dump(exclude_none=True)
        return tables

    @property
    def hexahedra(self) -> bool:
        """True if the finger is meshed in hexahedra, where no mesh file is given."""
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

    def uneven(self) -> Iterator[Refusal]:
        """Yield what differs from its mirror image in y = 0, which half a finger cannot have."""
        for name, film in self.film.all.items():
            if not film.symmetric:
                words = "families at 0, 90 or in pairs of opposite sign"
                yield Refusal(f"film.{name}.fibre_deg", f"allowed with mesh.half = true: {words}")
        if self.plate.normal[1]:
            yield Refusal("plate.normal", "allowed: no y-part with mesh.half = true")
        if self.gravity.acceleration_m_s2 and self.gravity.direction[1]:
            yield Refusal("gravity.direction", "allowed: no y-part with mesh.half = true")


if TYPE_CHECKING:  # its further tables are known as it runs only
    Setup = Sections
else:
    for _name in KINDS.keys() & Sections.model_fields.keys():
        raise PluginError(f"--plugin {_name}.py: [{_name}] is a section; allowed: another name")
    Setup = create_model(
        "Setup",
        __base__=Sections,
        __doc__="All that the simple model depends on: every section but the extensions.",
        **{name: (kind | None, None) for name, kind in KINDS.items()},
    )
