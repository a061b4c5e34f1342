"""The configuration: one TOML file, checked before anything is computed.

Every model is built from a :class:`Config` alone. Keys carry their unit in their name;
defaults are the reference finger. Units: mm, MPa, N, s; pressure in kPa at every
interface (:data:`KPA` converts once, where a form's constant is set).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from dolfingrip import complaint, tables
from dolfingrip.complaint import ConfigError
from dolfingrip.extensions.index import Extensions
from dolfingrip.section import Section, Vector
from dolfingrip.section import outside as _outside

__all__ = [
    "KPA",
    "Branch",
    "Cog",
    "Config",
    "ConfigError",
    "Contact",
    "Coupon",
    "Experiment",
    "Finger",
    "Gravity",
    "Material",
    "Mesh",
    "Morph",
    "Plate",
    "Protocol",
    "Solver",
    "dumps",
    "from_dict",
    "load",
]

KPA = 1e-3
"""MPa per kPa."""

Branch = Literal["loading", "unloading", "hold"]
Times = Annotated[tuple[Annotated[float, Field(ge=0)], ...], Field(strict=False)]
Values = Annotated[tuple[float, ...], Field(strict=False)]
Cycles = Annotated[tuple[Annotated[int, Field(ge=1)], ...], Field(strict=False)]
Branches = Annotated[tuple[Branch, ...], Field(strict=False)]


class Finger(Section):
    """Bellows finger: a base layer at x = 0, clamped at z = 0, bellows towards +x."""

    length_mm: float = Field(90.0, gt=0, le=1000, description="clamp to tip, along z")
    width_mm: float = Field(20.0, gt=0, le=500, description="along y")
    depth_mm: float = Field(16.0, gt=0, le=500, description="back of base layer to bellows' crown")
    base_layer_mm: float = Field(3.5, gt=0, description="strain-limiting layer")
    wall_mm: float = Field(1.6, gt=0, description="walls of bellows and channel")
    bellows: int = Field(8, ge=1, le=60, description="number of bellows")
    gap_mm: float = Field(2.0, gt=0, description="clear distance between neighbouring bellows")
    channel_mm: float = Field(2.5, gt=0, description="height of the air channel")
    channel_width_mm: float | None = Field(
        None, gt=0, description="width of the air channel; default: as wide as the chambers"
    )
    base_block_mm: float = Field(12.0, gt=0, description="solid block at the clamp")
    tip_mm: float = Field(6.0, gt=0, description="solid tip")

    @property
    def pitch_mm(self) -> float:
        """Distance from one bellows to the next."""
        return (self.length_mm - self.base_block_mm - self.tip_mm) / self.bellows

    @property
    def bellows_mm(self) -> float:
        """Outer length of one bellows along z."""
        return self.pitch_mm - self.gap_mm

    @property
    def chamber_width_mm(self) -> float:
        """Inner width of a bellows along y."""
        return self.width_mm - 2 * self.wall_mm

    @property
    def channel_width(self) -> float:
        """Width of the air channel (mm), the chambers' where none is given."""
        return self.chamber_width_mm if self.channel_width_mm is None else self.channel_width_mm

    @model_validator(mode="after")
    def _possible(self) -> Finger:
        if self.tip_mm >= self.length_mm:
            raise _outside(
                "tip_mm",
                self.tip_mm,
                f"allowed: above 0 and below length_mm = {self.length_mm:g} mm",
            )
        if self.pitch_mm <= 0:
            limit = self.length_mm - self.tip_mm
            raise _outside(
                "base_block_mm",
                self.base_block_mm,
                f"leaves no room for bellows; allowed: above 0 and below {limit:g} mm",
            )
        if self.bellows_mm <= 0:
            raise _outside(
                "gap_mm",
                self.gap_mm,
                f"leaves no bellows; allowed: above 0 and below the pitch, {self.pitch_mm:g} mm",
            )
        half = min(self.bellows_mm, self.width_mm, self.depth_mm) / 2
        if self.wall_mm >= half:
            raise _outside(
                "wall_mm",
                self.wall_mm,
                f"thicker than half a bellows; allowed: above 0 and below {half:g} mm",
            )
        room = self.depth_mm - self.base_layer_mm - 2 * self.wall_mm
        if room <= 0:
            limit = self.depth_mm - 2 * self.wall_mm
            raise _outside(
                "base_layer_mm",
                self.base_layer_mm,
                "leaves no room for a bellows above the channel; "
                f"allowed: above 0 and below {limit:g} mm",
            )
        highest = self.depth_mm - self.base_layer_mm - self.wall_mm
        if self.channel_mm >= highest:
            raise _outside(
                "channel_mm",
                self.channel_mm,
                f"cavity not closed; allowed: above 0 and below {highest:g} mm",
            )
        if self.channel_width > self.chamber_width_mm:
            raise _outside(
                "channel_width_mm",
                self.channel_width,
                f"cavity not closed; allowed: above 0 and up to {self.chamber_width_mm:g} mm",
            )
        return self


class Material(Section):
    """Compressible neo-Hookean solid; give ``nu`` or ``bulk_MPa``."""

    mu_MPa: float = Field(2.93, gt=0, description="shear modulus (printed NinjaFlex)")
    nu: float | None = Field(
        None, gt=0, lt=0.5, description="Poisson's ratio; default 0.45 where no bulk_MPa is given"
    )
    bulk_MPa: float | None = Field(None, gt=0, description="bulk modulus, instead of nu")
    density_kg_m3: float = Field(1190.0, gt=0, description="felt by gravity only")

    @model_validator(mode="after")
    def _one_of(self) -> Material:
        if self.nu is not None and self.bulk_MPa is not None:
            raise _outside("bulk_MPa", self.bulk_MPa, f"give either nu or bulk_MPa; nu = {self.nu}")
        if self.bulk_MPa is not None and self.bulk_MPa <= 2 / 3 * self.mu_MPa:
            raise _outside(
                "bulk_MPa",
                self.bulk_MPa,
                f"allowed: above 2/3 mu_MPa = {2 / 3 * self.mu_MPa:g} MPa (nu above 0)",
            )
        return self

    @property
    def lmbda_MPa(self) -> float:
        """First Lamé parameter."""
        if self.bulk_MPa is not None:
            return self.bulk_MPa - 2 / 3 * self.mu_MPa
        return 2 * self.mu_MPa * self.poisson / (1 - 2 * self.poisson)

    @property
    def poisson(self) -> float:
        """Poisson's ratio."""
        if self.bulk_MPa is not None:
            three, two = 3 * self.bulk_MPa, 2 * self.mu_MPa
            return (three - two) / (2 * three + two)
        return 0.45 if self.nu is None else self.nu


HEXAHEDRON_MM, TETRAHEDRON_MM = 7.0, 2.8
"""Largest element where ``mesh.size_mm`` is not given, by the shape of the cells."""

EDGE_WALLS = 1 / 8
"""Hexahedra at concave edges in walls, where ``mesh.edge_size_mm`` is not given."""


class Mesh(Section):
    """Resolution of the mesh, or a mesh file of one's own."""

    file: Path | None = Field(
        None,
        strict=False,
        description="a .msh or Abaqus .inp with the groups cavity, clamp, skin, tip, symmetry",
    )
    half: bool = Field(True, description="half finger with the symmetry plane y = 0")
    order: Literal[1, 2] = Field(1, description="order of the elements written to files")
    size_mm: float | None = Field(
        None,
        gt=0,
        le=100,
        description=f"largest element; default: {HEXAHEDRON_MM:g} for hexahedra, "
        f"{TETRAHEDRON_MM:g} for tetrahedra",
    )
    edge_size_mm: float | None = Field(
        None,
        gt=0,
        le=100,
        description="element size at concave edges; default: an eighth of the wall for "
        "hexahedra, size_mm for tetrahedra",
    )
    refine: int = Field(
        1, ge=1, le=16, description="hexahedra alone: each is divided so often along each axis"
    )
    target_elements: int | None = Field(
        None, ge=100, le=5_000_000, description="scale both sizes to this number of tetrahedra"
    )

    def hexahedra_mm(self, finger: Finger) -> tuple[float, float]:
        """Largest hexahedron and that at concave edges (mm)."""
        size = HEXAHEDRON_MM if self.size_mm is None else self.size_mm
        if self.edge_size_mm is None:
            return size, min(size, EDGE_WALLS * finger.wall_mm)
        return size, self.edge_size_mm

    def tetrahedra_mm(self) -> tuple[float, float]:
        """Largest tetrahedron and that at concave edges (mm)."""
        size = TETRAHEDRON_MM if self.size_mm is None else self.size_mm
        return size, self.edge_size_mm or size

    @model_validator(mode="after")
    def _sizes(self) -> Mesh:
        if self.edge_size_mm is None or self.size_mm is None:
            return self
        if self.edge_size_mm > self.size_mm:
            raise _outside(
                "edge_size_mm",
                self.edge_size_mm,
                f"allowed: above 0 and up to size_mm = {self.size_mm:g} mm",
            )
        return self


class Morph(Section):
    """Thickness of the meshed finger's regions: x below d_mm (A, strain-limiting) and above (B)."""

    xi1: float = Field(0.0, ge=-0.2, le=1, description="relative change of region A's thickness")
    xi2: float = Field(0.0, ge=-0.5, le=1, description="relative change of region B's thickness")
    d_mm: float = Field(9.5, gt=0, description="plane between the regions, before the morph")


class Cog(Section):
    """Where the centre of gravity's offset of the unpressurised finger is measured from."""

    x_ref_mm: float = Field(4.68, description="the offset is the centroid's x less this")


class Solver(Section):
    """Discretisation and Newton's method."""

    element: Literal["P1", "P2", "P2-P1", "S2"] | None = Field(
        None,
        description="displacement: P1 or P2 on tetrahedra, P2-P1 with a linear pressure for nu "
        "near 0.5, S2 on hexahedra (20 nodes, 8 integration points); default: S2, or P2 on "
        "tetrahedra of a file or by number",
    )
    rtol: float = Field(1e-6, gt=0, lt=1, description="residual, relative to the step's first")
    atol_N: float = Field(1e-9, gt=0, description="residual, absolute (N)")
    max_iterations: int = Field(30, ge=1, le=1000, description="Newton iterations a step")
    max_step_kPa: float = Field(25.0, gt=0, description="largest pressure step")
    max_step_s: float | None = Field(
        None, gt=0, description="largest step in time; default: as long as the pressure's allows"
    )
    min_step_kPa: float = Field(0.1, gt=0, description="smallest step before a failure is called")
    time_limit_s: float | None = Field(
        None, gt=0, description="of a load path, which then ends at its last good pressure"
    )
    mixed_integration_point: bool = Field(
        True, description="carry the stress as an independent field (fewer iterations)"
    )

    @model_validator(mode="after")
    def _steps(self) -> Solver:
        if self.min_step_kPa > self.max_step_kPa:
            raise _outside(
                "min_step_kPa",
                self.min_step_kPa,
                f"allowed: above 0 and up to max_step_kPa = {self.max_step_kPa:g} kPa",
            )
        return self


class Contact(Section):
    """Barrier contact (incremental potential contact) of the outer skin with itself."""

    self_contact: bool = Field(True, description="bellows cannot pass through one another")
    barrier_mm: float = Field(0.2, gt=0, le=10, description="distance at which contact is felt")
    stiffness_MPa: float = Field(0.005, gt=0, description="of the barrier")
    spacing_mm: float = Field(
        2.0, gt=0, le=100, description="hexahedra: largest distance of contact points"
    )


class Plate(Section):
    """The force sensor: a rigid plane facing the base layer's back near the tip."""

    gap_mm: float = Field(0.0, ge=0, description="skin to plate, unpressurised")
    tilt_deg: float = Field(0.0, gt=-80, lt=80, description="rotation of the plate about y")
    normal: Vector = Field((1.0, 0.0, 0.0), description="of the untilted plate, towards the finger")
    contact_length_mm: float = Field(10.0, gt=0, description="length of finger facing it, from tip")
    barrier_mm: float = Field(0.1, gt=0, le=10, description="distance at which contact is felt")
    stiffness_MPa: float = Field(0.1, gt=0, description="of the barrier")

    @model_validator(mode="after")
    def _direction(self) -> Plate:
        if not any(self.normal):
            raise _outside("normal", list(self.normal), "allowed: any vector but zero")
        return self


class Gravity(Section):
    """Dead weight of the finger; off by default, as in the paper."""

    acceleration_m_s2: float = Field(0.0, ge=0, le=1000, description="9.81 switches gravity on")
    direction: Vector = Field((0.0, 0.0, 1.0), description="z is from clamp to tip")

    @model_validator(mode="after")
    def _direction(self) -> Gravity:
        if not any(self.direction):
            raise _outside("direction", list(self.direction), "allowed: any vector but zero")
        return self


class Experiment(Section):
    """Readings to take, in order: from rest to the maximum, and back where asked."""

    control: Literal["pressure", "volume"] = Field(
        "pressure", description="what is led; led by volume, the cavity passes limit points"
    )
    max_pressure_kPa: float = Field(250.0, gt=0, le=10_000, description="highest pressure")
    step_kPa: float = Field(25.0, gt=0, description="a reading every so much")
    max_volume_ratio: float = Field(
        2.0, gt=1, le=100, description="led by volume: largest cavity, relative to rest"
    )
    step_volume_ratio: float = Field(
        0.1, gt=0, le=10, description="led by volume: a reading every so much"
    )
    unload: bool = Field(False, description="go back to rest in the same steps")
    rate_kPa_per_s: float = Field(25.0, gt=0, description="ramp; felt by models with a clock only")
    cycles: int = Field(1, ge=1, le=10_000, description="how often; more than one unloads, too")
    hold_s: float = Field(0.0, ge=0, description="wait at the maximum of each cycle")
    rest_s: float = Field(0.0, ge=0, description="wait unpressurised after each cycle")
    hold_readings: int = Field(4, ge=1, le=1000, description="readings of a wait, ever sparser")

    @model_validator(mode="after")
    def _steps(self) -> Experiment:
        if self.step_kPa > self.max_pressure_kPa:
            raise _outside(
                "step_kPa",
                self.step_kPa,
                f"allowed: above 0 and up to max_pressure_kPa = {self.max_pressure_kPa:g} kPa",
            )
        return self


class Protocol(Section):
    """Readings at given times, instead of the experiment's ramps; made by --protocol."""

    time_s: Times = Field((), description="of each reading, none earlier than the one before")
    pressure_kPa: Values = Field((), description="of each reading (finger)")
    displacement_mm: Values = Field((), description="of each reading (coupon)")
    cycle: Cycles = Field((), description="of each reading; default: 1")
    branch: Branches = Field((), description="of each reading; default: from its neighbour")

    @model_validator(mode="after")
    def _table(self) -> Protocol:
        count = len(self.time_s)
        led = "displacement_mm" if self.displacement_mm else "pressure_kPa"
        for key in (led, "cycle", "branch"):
            values = getattr(self, key)
            if len(values) != count and (values or key == led):
                raise _outside(
                    key, f"{len(values)} values", f"allowed: as many as time_s has, {count}"
                )
        late = [b for a, b in pairwise(self.time_s) if b < a]
        if late:
            raise _outside("time_s", f"… {late[0]:g}", "allowed: no earlier than the one before")
        return self


class Coupon(Section):
    """Uniaxial tension of a bar: its gauge length, moved at one end."""

    gauge_length_mm: float = Field(33.0, gt=0, le=1000, description="length that is stretched")
    width_mm: float = Field(3.0, gt=0, le=500, description="of the cross-section")
    thickness_mm: float = Field(3.0, gt=0, le=500, description="of the cross-section")
    grip: Literal["sliding", "clamped"] = Field(
        "sliding", description="ends free to narrow (uniform stretch) or held fast"
    )
    max_strain: float = Field(0.5, gt=0, le=10, description="largest nominal strain")
    step_strain: float = Field(0.05, gt=0, le=10, description="a reading every so much")
    rate_mm_per_s: float = Field(2.5, gt=0, description="crosshead; felt by models with a clock")

    @model_validator(mode="after")
    def _steps(self) -> Coupon:
        if self.step_strain > self.max_strain:
            raise _outside(
                "step_strain",
                self.step_strain,
                f"allowed: above 0 and up to max_strain = {self.max_strain:g}",
            )
        return self

    @property
    def area_mm2(self) -> float:
        """Cross-section at rest."""
        return self.width_mm * self.thickness_mm


class Config(Section):
    """All that a simulation depends on."""

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
    extensions: Extensions = Extensions()

    @model_validator(mode="after")
    def _facing(self) -> Config:
        if self.plate.contact_length_mm > self.finger.length_mm:
            raise _outside(
                "plate.contact_length_mm",
                self.plate.contact_length_mm,
                f"allowed: above 0 and up to finger.length_mm = {self.finger.length_mm:g} mm",
            )
        if self.solver.element == "S2" and self.mesh.target_elements is not None:
            raise _outside(
                "mesh.target_elements",
                self.mesh.target_elements,
                'a number of tetrahedra; allowed: with solver.element = "P1" or "P2"',
            )
        if self.mesh.half and self.mesh.file is None:
            sideways = self.sideways()
            if sideways is not None:
                raise _outside(*sideways, "allowed: no y-part with mesh.half = true")
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

    def overridden(self, assignments: Sequence[str]) -> Self:
        """A checked copy with ``section.key=value`` strings applied in order.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        data = self.model_dump(exclude_none=True)
        for assignment in assignments:
            tables.override(data, assignment)
        return checked(type(self), data)

    def adapted(self) -> Self:
        """The configuration that is meshed and solved: with extensions of geometry applied."""
        done = self
        for effect in self.extensions.active("adapt"):
            done = effect.adapt(done)
        return done.model_copy(update={"extensions": done.extensions.without("adapt")})

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


def load(
    file: Path | None = None, overrides: Sequence[str] = (), defaults: Sequence[str] = ()
) -> Config:
    """Read, override and check the configuration.

    Args:
        file: TOML file, or the ``run.json`` of an earlier run; the reference finger where None.
            A mesh file in it is sought from its folder.
        overrides: ``section.key=value`` strings, applied in order; a mesh file is sought from
            the working folder.
        defaults: likewise, where a command's differ from the reference finger's; the file
            and the overrides go before them.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    data: dict[str, Any] = {}
    if file is not None:
        data = tables.read(file)
        tables.anchor(data, file.parent)
    for assignment in defaults:
        tables.override(data, assignment, replace=False)
    for assignment in overrides:
        tables.override(data, assignment)
    tables.anchor(data, Path())
    return from_dict(data)


def from_dict(data: dict[str, Any]) -> Config:
    """A checked configuration from nested dictionaries, as in ``run.json``.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    return checked(Config, data)


def checked[S: Section](root: type[S], data: dict[str, Any]) -> S:
    """``data`` as a ``root``.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    try:
        return root.model_validate(data)
    except ValidationError as error:
        raise ConfigError(complaint.one_line(error, root, data)) from None


def dumps(config: Config) -> str:
    """The resolved configuration as TOML, each key with its meaning as a comment."""
    return tables.dumps(config)
