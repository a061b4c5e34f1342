"""How a finger is held: its clamp, at rest or moving with numbers."""

from __future__ import annotations

import ufl
from dolfinx import fem

from dolfingrip.config import ConfigError
from dolfingrip.extensions.site import Site
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.moving_support import MovingSupport


def held_regions(domain: Domain) -> dict[int, list[str]]:
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
