"""The configuration: one TOML file, checked before anything is computed.

Every model is built from a :class:`Config` alone. Keys carry their unit in their name;
defaults are the reference finger. Units: mm, MPa, N, s; pressure in kPa at every
interface (:data:`KPA` converts once, where a form's constant is set).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from dolfingrip import complaint, tables
from dolfingrip.complaint import ConfigError
from dolfingrip.extensions.index import Extensions
from dolfingrip.procedure import Branch, Coupon, Experiment, Protocol
from dolfingrip.section import Section, Vector, check_up_to
from dolfingrip.section import outside as _outside
from dolfingrip.specimen import Cog, Finger, Material, Mesh, Morph

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
    max_iterations: int = Field(
        30, ge=1, le=1000, description="Newton iterations a step, thrice as many with care"
    )
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
        check_up_to(self, "min_step_kPa", "max_step_kPa", "kPa")
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
