"""Doubts about a configuration that a user should know of."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dolfingrip.config import Config


NEARLY_INCOMPRESSIBLE = {"P2": 0.49, "S2": 0.47}
"""Poisson's ratio above which an element with quadratic displacements and no pressure field is not
enough. Tetrahedra lock; on hexahedra Newton's method takes several times as many iterations."""


def notes(config: Config) -> list[str]:
    """One line for each doubt about the finger's regions and about the element."""
    return [*_unlimited(config), *_element(config)]


def _unlimited(config: Config) -> list[str]:
    """A geometry whose strain-limiting region is of the same material as the rest."""
    region = config.geometry.limiting
    if not region or config.mesh.file or region in config.material.own or config.film.all:
        return []
    return [
        f'finger.kind = "{config.finger.kind}": its region {region} is of the same material as the '
        f"rest, so nothing limits its strain, and the finger may bend the wrong way; give "
        f"[material.{region}], or a film on it, as [film.NAME]"
    ]


def _element(config: Config) -> list[str]:
    """A choice of the element that does not suit the material."""
    element = config.solver.element
    if element == "P1":
        return [
            'solver.element = "P1": linear tetrahedra are too stiff in thin walls (tip '
            'displacement 38 % too small with walls of 1 mm); take "P2"'
        ]
    quadratic = element or ("S2" if config.hexahedra else "P2")
    if config.material.poisson > NEARLY_INCOMPRESSIBLE.get(quadratic, 0.5):
        return [
            f'solver.element = "{quadratic}": nu = {config.material.poisson:.4g} is nearly '
            'incompressible, where it converges slowly; take "P2-P1"'
        ]
    return []
