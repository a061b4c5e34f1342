"""A finger's surroundings: clamp, force sensor's plate, neighbouring bellows, air supply."""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from dolfingrip.channels import PRESSURE, supply_of
from dolfingrip.config import KPA, Config, ConfigError
from dolfingrip.extensions.effect import Stage
from dolfingrip.extensions.site import Site
from dolfingrip.extensions.supply import Supply
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.model.assembly import box
from dolfingrip.mechanics.model.model import Control, Prescribed
from dolfingrip.mechanics.model.supports import MovingSupport
from dolfingrip.sections.fixture import PlateSettings

SKIN = ("skin", "tip")
"""Regions of a finger that may touch something."""

FACING = "facing plate"
"""Region of a finger that the plate may touch."""


def normal_of(plate: PlateSettings) -> np.ndarray:
    """Normal of the tilted plate, towards the finger, (3,).

    Args:
        plate: of the configuration.
    """
    tilt = np.deg2rad(plate.tilt_deg)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    return np.asarray(turn @ np.asarray(plate.normal, dtype=float))


def surround(site: Site, *, plate: bool) -> None:
    """Add to the site the contacts of the skin and the regions that are held.

    Args:
        site: site of a finger.
        plate: whether the force sensor's plate faces the finger. It may touch the new region
            "facing plate" of the site.

    Raises:
        ConfigError: if no element of the mesh is near enough to the tip.
    """
    given, contact = site.config.plate, site.config.contact
    if plate:
        normal, mesh = normal_of(given), site.domain.mesh
        length = box(mesh.comm, mesh.geometry.x)[1, 2]
        # a facet that crosses the plate's end does not face the plate
        start = length - given.contact_length_mm - 1e-6 * length
        site.domain = site.domain.with_region(FACING, SKIN, lambda x: x[2] >= start)
        if not mesh.comm.allreduce(len(site.domain.regions[FACING])):
            raise ConfigError(
                f"plate.contact_length_mm = {given.contact_length_mm}: no element of the "
                "mesh is that near to its tip; allowed: longer than the elements there"
            )
        site.plate = RigidPlate(
            site.u,
            site.domain,
            FACING,
            normal,
            gap_mm=given.gap_mm,
            width_mm=given.barrier_mm,
            stiffness_MPa=given.stiffness_MPa,
        )
    cavities = site.domain.cavities
    may_meet = bool(cavities) and site.config.walls_may_meet(cavities)
    if contact.self_contact:
        skin = site.domain.facets(*SKIN)
        surface = Surface(site.u.function_space, site.domain, skin, contact.spacing_mm)
        site.contact = BarrierContact(surface, contact.barrier_mm, contact.stiffness_MPa)
        if may_meet and surface.interpolated:
            site.further.append(_apart(site, *SKIN))
    if may_meet:  # between nodes of a coarse mesh, a wall that folds may pass through itself
        site.further.append(_apart(site, *SKIN, *site.domain.cavities, separate=True))
    for name in site.domain.cavities if may_meet else ():
        site.walls[name] = _apart(site, name)
        spread = _apart(site, name, spacing_mm=contact.spacing_mm)
        between = [spread] if spread.surface.interpolated else []
        site.further += [site.walls[name], *between]
    # the clamp is held across, and so is the plane of symmetry
    across = ["clamp", "symmetry"] if site.domain.half else ["clamp"]
    site.held |= {0: ["clamp"], 1: across, 2: ["clamp"]}


def _apart(
    site: Site, *regions: str, spacing_mm: float | None = None, separate: bool = False
) -> BarrierContact:
    """Contact of walls with one another, and with their mirror image in half a finger.

    With ``separate`` it is that of a wall's two faces alone, which a finger's skin and its cavities
    are.

    Points that are spread keep walls apart between their nodes; contact of the nodes keeps those
    apart that lie between the points. Walls that are nearer to one another than the barrier at
    rest, as nodes in corners of a fine mesh, get a narrower one. It is as stiff as the largest
    pressure that presses walls on one another.
    """
    domain, contact = site.domain, site.config.contact
    largest_MPa = max(map(abs, site.config.pressures_kPa)) * KPA
    surface = Surface(site.u.function_space, domain, domain.facets(*regions), spacing_mm)
    if domain.half:
        surface = surface.mirrored()

    def barrier(width_mm: float) -> BarrierContact:
        # the image has half of the energy
        stiffness_MPa = max(contact.stiffness_MPa, largest_MPa) / domain.copies
        title = f"the wall of {regions[0]}"
        return BarrierContact(
            surface, width_mm, stiffness_MPa, title=title, crowded=True, separate=separate
        )

    made = barrier(contact.barrier_mm)
    gap_mm = made.gap_mm(np.zeros_like(site.u.x.array), contact.barrier_mm)
    return made if gap_mm > contact.barrier_mm else barrier(gap_mm / 2)


def supply(config: Config, site: Site) -> tuple[dict[str, Prescribed], list[Supply]]:
    """The controls of the pressures by name, and those with stages between regulator and cavity.

    A cavity with a supply of its own has stages of its own, which are like the others.

    Raises:
        ConfigError: if the configuration prescribes the cavity's volume, from the start or later.
    """
    stages = config.extensions.active(Stage)
    if stages and config.experiment.control != "pressure":
        raise ConfigError(
            f'extensions.{stages[0].name()}: allowed: with experiment.control = "pressure" only'
        )
    assert site.pressure is not None
    controls: dict[str, Prescribed] = {PRESSURE.name: site.set_point or Control(site.pressure, KPA)}
    controls |= {supply_of(name).name: Control(p, KPA) for name, p in site.supplies.items()}
    if not stages:
        return dict(controls), []
    behind = {name: Supply(control, stages, name) for name, control in controls.items()}
    return dict(behind), list(behind.values())


def moving_clamp(site: Site, supports: list[fem.DirichletBC]) -> MovingSupport | None:
    """The clamp that an extension lets move; None if it does not move.

    Raises:
        ConfigError: one line, if a tube leads out of the cavity through the clamp.
    """
    if not site.motions:
        return None
    if site.domain.closing_mm3:
        raise ConfigError(
            "extensions: a clamp that moves; allowed: with a cavity that is closed at the clamp, "
            "as with cast.tube = false"
        )
    nodes = fem.locate_dofs_topological(
        site.u.function_space, 2, site.domain.facets("clamp"), remote=True
    )
    return MovingSupport(site.u, supports, nodes, site.motions)
