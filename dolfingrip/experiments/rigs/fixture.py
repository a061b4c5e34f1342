"""What surrounds a finger: the clamp, the force sensor's plate, other bellows, the air supply."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.config import Config, ConfigError, Plate
from dolfingrip.extensions.site import Site
from dolfingrip.extensions.supply import Supply
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.model import Control
from dolfingrip.mechanics.model.moving_support import MovingSupport


def facing_plate(config: Config, domain: Domain) -> Domain:
    """``domain`` with the region "facing plate", which the plate may touch.

    Raises:
        ConfigError: no element of the mesh is near enough to the tip.
    """
    ends = domain.mesh.geometry.x[:, 2].max(initial=-np.inf)
    length = domain.mesh.comm.allreduce(ends, MPI.MAX)
    # a facet that straddles the plate's end does not face it
    start = length - config.plate.contact_length_mm - 1e-6 * length
    facing = domain.with_region("facing plate", ("skin", "tip"), lambda x: x[2] >= start)
    if not domain.mesh.comm.allreduce(len(facing.facets("facing plate"))):
        raise ConfigError(
            f"plate.contact_length_mm = {config.plate.contact_length_mm}: no element of the "
            "mesh is that near to its tip; allowed: longer than the elements there"
        )
    return facing


def normal_of(plate: Plate) -> np.ndarray:
    """(3,) normal of the tilted plate, towards the finger."""
    tilt = np.deg2rad(plate.tilt_deg)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    return np.asarray(turn @ np.asarray(plate.normal, dtype=float))


def rigid_plate(config: Config, domain: Domain, u: fem.Function) -> RigidPlate:
    """The force sensor's plate, with which the region "facing plate" is in contact."""
    plate = config.plate
    return RigidPlate(
        u,
        domain,
        "facing plate",
        normal_of(plate),
        gap_mm=plate.gap_mm,
        width_mm=plate.barrier_mm,
        stiffness_MPa=plate.stiffness_MPa,
    )


def self_contact(config: Config, domain: Domain, u: fem.Function) -> BarrierContact:
    """Contact of the skin with itself."""
    surface = Surface(
        u.function_space, domain, domain.facets("skin", "tip"), config.contact.spacing_mm
    )
    return BarrierContact(surface, config.contact.barrier_mm, config.contact.stiffness_MPa)


def supply(config: Config, cavity: Control) -> Supply | None:
    """The stages between regulator and cavity, where there are any.

    Raises:
        ConfigError: the configuration prescribes the cavity's volume, if only from some state on.
    """
    stages = config.extensions.active("outlet_kPa")
    if stages and config.experiment.control != "pressure":
        raise ConfigError(
            f'extensions.{stages[0].name()}: allowed: with experiment.control = "pressure" only'
        )
    return Supply(cavity, stages) if stages else None


def fixed_regions(domain: Domain) -> dict[int, list[str]]:
    """Regions without displacement along each axis: the clamp; across it the symmetry plane."""
    held = {0: ["clamp"], 1: ["clamp"], 2: ["clamp"]}
    if domain.half:
        held[1].append("symmetry")
    return held


def moving_clamp(site: Site, supports: list[fem.DirichletBC]) -> MovingSupport | None:
    """The clamp, where an extension lets it move.

    Raises:
        ConfigError: one line, where a tube leads out of the cavity there.
    """
    if not site.motions:
        return None
    if _opens_at_clamp(site):
        raise ConfigError(
            "extensions: a clamp that moves; allowed: with a cavity that is closed at the clamp, "
            "as with cast.tube = false"
        )
    nodes = fem.locate_dofs_topological(
        site.u.function_space, 2, site.domain.facets("clamp"), remote=True
    )
    return MovingSupport(site.u, supports, nodes, site.motions)


def _opens_at_clamp(site: Site) -> bool:
    """Whether a tube leads out of the cavity through the clamped plane.

    The opening's area along z is what the cavity's surface lacks of being closed.
    """
    normal = ufl.FacetNormal(site.domain.mesh)
    lacking = site.fixed(1.0) * normal[2] * site.domain.surface("cavity", quadrature_degree=1)
    area = site.domain.mesh.comm.allreduce(fem.assemble_scalar(fem.form(lacking)))
    return abs(area) > 1e-6 * site.area_mm2("clamp")
