"""The dead weight of a finger's materials."""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from dolfingrip.experiments.rigs.regions import REST
from dolfingrip.extensions.site import Site
from dolfingrip.mechanics.model.dead_weight import DeadWeight
from dolfingrip.sections.setup import Setup

KG_M3_M_S2 = 1e-9
"""N/mm³ per kg/m³ · m/s²."""


def name_of(part: str = REST) -> str:
    """Name of a part's constant for its dead weight."""
    return "gravity.weight_N_mm3" if part == REST else f"material.{part}.weight_N_mm3"


def value_of(config: Setup, part: str = REST) -> np.ndarray:
    """(3,) dead weight of a part per reference volume (N/mm³)."""
    gravity, density = config.gravity, config.material.of(part).density_kg_m3
    direction = np.asarray(gravity.direction, dtype=float)
    size = KG_M3_M_S2 * gravity.acceleration_m_s2 * density
    return np.asarray(size * direction / np.linalg.norm(direction))


def dead_weight(site: Site) -> DeadWeight | None:
    """The weight of all parts of a model under construction; None without gravity.

    Its constants are always added to the site's parameters. A film that is a layer has no weight,
    because the reduced rule leaves modes of its elements without energy, and nothing bears a weight
    in these modes at rest.
    """
    config, domain = site.config, site.domain
    own = [part for part in domain.parts if part in config.material.own]
    constants = {part: fem.Constant(domain.mesh, value_of(config, part)) for part in (REST, *own)}
    site.parameters |= {name_of(part): constant for part, constant in constants.items()}
    if not config.gravity.acceleration_m_s2:
        return None
    if not domain.parts:
        return DeadWeight(site.u, domain, {(): constants[REST]})
    layers = {film.region for film in config.film.layers.values()}
    weights: dict[tuple[str, ...], fem.Constant] = {
        (part,): constants.get(part, constants[REST]) for part in domain.parts if part not in layers
    }
    return DeadWeight(site.u, domain, weights)
