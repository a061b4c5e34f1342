"""What a person should know before trusting a configuration's figures."""

from __future__ import annotations

from dolfingrip.config import Config

NEARLY_INCOMPRESSIBLE = 0.49
"""Poisson's ratio from which quadratic displacements alone lock, too."""


def notes(config: Config) -> list[str]:
    """One line for each doubt about the choice of the element."""
    element = config.solver.element
    if element == "P1":
        return [
            'solver.element = "P1": linear tetrahedra are too stiff in thin walls (tip '
            'displacement 38 % too small with walls of 1 mm); take "P2"'
        ]
    if element == "P2" and config.material.poisson > NEARLY_INCOMPRESSIBLE:
        return [
            f'solver.element = "P2": nu = {config.material.poisson:.4g} is nearly '
            'incompressible, where it locks and converges slowly; take "P2-P1"'
        ]
    return []
