"""The energies of films: membranes on surfaces, and layers of elements."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import add

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.config import Config, Film
from dolfingrip.forms import membrane, saint_venant
from dolfingrip.mechanics.model.parts import StrainEnergy
from dolfingrip.mechanics.model.sheet import Sheet

BACK = ufl.as_vector([-1, 0, 0])
"""Normal of a layer, which lies in a plane x = const."""


def film_value(config: Config, name: str, key: str) -> np.ndarray:
    """Value of a film's constant."""
    film = config.film.all[name]
    value = config.film_thickness_mm(film) if key == "thickness_mm" else getattr(film, key)
    return np.asarray(value, dtype=float)


def _constants(
    config: Config, name: str, mesh: dolfinx.mesh.Mesh, known: dict[str, fem.Constant]
) -> Callable[[str], fem.Constant]:
    """Makes each constant of a film once."""

    def constant(key: str) -> fem.Constant:
        full = f"film.{name}.{key}"
        if full not in known:
            known[full] = fem.Constant(mesh, film_value(config, name, key))
        return known[full]

    return constant


def layer_energy(
    config: Config,
    name: str,
    film: Film,
    mesh: dolfinx.mesh.Mesh,
    known: dict[str, fem.Constant],
) -> StrainEnergy:
    """Strain energy of a film of elements, whose modulus is its stiffness by its thickness."""
    constant = _constants(config, name, mesh, known)
    thickness = constant("thickness_mm")

    def energy(strain: Expr) -> Expr:
        young = constant("Et_N_per_mm") / thickness
        solid = saint_venant.energy(strain, young, constant("nu"))
        families = _families(film, strain, BACK, constant)
        return reduce(add, [family / thickness for family in families], solid)

    return energy


def sheets(config: Config, mesh: dolfinx.mesh.Mesh, known: dict[str, fem.Constant]) -> list[Sheet]:
    """Energies of all membranes.

    Args:
        config: configuration with the membranes.
        mesh: mesh of the finger.
        known: constants by name, which those of the membranes are added to.

    Returns:
        One sheet for each membrane, with its energy (mJ/mm²).
    """
    found = []
    for name, film in config.film.membranes.items():
        constant = _constants(config, name, mesh, known)
        found.append(Sheet(name, _membrane_energy(film, constant)))
    return found


def _membrane_energy(
    film: Film, constant: Callable[[str], fem.Constant]
) -> Callable[[Expr, Expr], Expr]:
    def energy(strain: Expr, normal: Expr) -> Expr:
        parts = _families(film, strain, normal, constant)
        if film.Et_N_per_mm:
            stiffness, nu = constant("Et_N_per_mm"), constant("nu")
            share = constant("compression")
            parts.insert(0, membrane.isotropic(strain, stiffness, nu, share))
        return reduce(add, parts)

    return energy


def _families(
    film: Film, strain: Expr, normal: Expr, constant: Callable[[str], fem.Constant]
) -> list[Expr]:
    """Energy per reference area of each family of fibres."""
    found = []
    for i in range(len(film.fibre_deg)):
        angle = constant("fibre_deg")[i] * (ufl.pi / 180)
        along = membrane.direction(angle, normal, ufl.as_vector(film.fibre_axis))
        stiffness = constant("fibre_Et_N_per_mm")[i]
        found.append(membrane.fibres(strain, stiffness, along, constant("compression")))
    return found
