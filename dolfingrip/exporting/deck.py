"""A deck that CalculiX and Abaqus solve as it is: material, clamp, pressure, plate, steps.

Units are mm, N, MPa, t and s. Pressure on faces of elements follows them, as NLGEOM is on.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.channels import PRESSURE
from dolfingrip.config import KPA, Config
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.experiments.rigs.fixture import SKIN, normal_of
from dolfingrip.experiments.rigs.undeformed import REST, parts_of
from dolfingrip.exporting.asked import beside, no_law, plain, supplied, supplies_kPa
from dolfingrip.files import whole
from dolfingrip.meshes import abaqus
from dolfingrip.meshes.groups import CLAMP, SOLID, SYMMETRY, TIP, cavities
from dolfingrip.meshes.solid import Ints, SolidMesh
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.laws.arruda_boyce import ArrudaBoyce
from dolfingrip.sections.laws.neo_hooke import NeoHooke
from dolfingrip.sections.laws.ogden import Ogden
from dolfingrip.sections.laws.polynomial import POWERS, InvariantPolynomial
from dolfingrip.sections.material import Material

KNOWN: Final = "neo-hooke, polynomial, ogden of up to three terms, arruda-boyce"

BETA: Final = 0.25
"""β of the hyperfoam's two terms, whose energy is the nearer to λ/2 (ln J)² the smaller it is."""

ORDER: Final = tuple((n - j, j) for n in (1, 2, 3) for j in range(n + 1))
"""Exponents of Ī₁ − 3 and Ī₂ − 3 in the order of a deck's polynomial."""

PLATE: Final = "plate"
GAP_N_MM: Final = 1e3
"""Stiffness of a closed gap in CalculiX, which does not converge with its own, 1e12 N/mm."""

MM_S2, T_MM3 = 1e3, 1e-12
"""mm/s² per m/s², and t/mm³ per kg/m³."""


def write(config: Config, file: Path, *, plate: bool = False) -> str:
    """Write a deck with a step through the pressures of the experiment, one in a second.

    Args:
        config: of the finger, its plate and the experiment's pressures.
        file: target, ``….inp``.
        plate: whether the force sensor's plate faces the finger.

    Returns:
        What is in it, for a person.

    Raises:
        ConfigError: one line, where the finger has what these programs lack.
        WriteError: one line.
    """
    config = plain(config, file.suffix, one_material=False)
    times_s, pressures = supplies_kPa(config, file.suffix)
    if config.solver.element == "P2-P1":
        raise ConfigError(f'solver.element = "P2-P1": {file.suffix}: allowed: P1, P2, S2')
    if plate and config.gravity.acceleration_m_s2:
        words = f"{file.suffix} with a plate: allowed: 0 m/s²"
        raise ConfigError(f"gravity.acceleration_m_s2: {words}")
    beside(config, file, file.suffix)
    mesh = undeformed.elements(config)
    full = config.integration != "reduced"
    parts = [abaqus.deck(mesh, full=full), *_materials(config, mesh), _supports(mesh)]
    if plate:
        parts.append(_plate(config, mesh))
    whole.write(file, "".join([*parts, *_steps(config, mesh, pressures, plate)]))
    farthest = max((p_kPa for values in pressures.values() for p_kPa in values), key=abs)
    said = f"{len(mesh.cells)} elements, {len(times_s) - 1} s for {farthest:g} kPa"
    if SYMMETRY in mesh.facets:
        said += "; the file has half of the finger, and its forces are half of the finger's"
    return f"{said}; walls may pass through one another"


def _materials(config: Config, mesh: SolidMesh) -> Iterator[str]:
    """Each part's material, and the section that gives it to its elements."""
    parts = parts_of(config, mesh)
    if REST in parts:
        yield f"*ELSET, ELSET={REST}\n{abaqus.data(parts[REST] + 1)}"
    for name in parts or (SOLID,):
        material = config.material.of(name)
        yield f"*MATERIAL, NAME={name}\n*DENSITY\n{T_MM3 * material.density_kg_m3:.12g}\n"
        yield law(material)
        yield f"*SOLID SECTION, ELSET={name}, MATERIAL={name}\n"


def law(material: Material) -> str:
    """Lines of a material's energy.

    Neo-Hooke's law is a hyperfoam of two terms with α = 2, β = ±b, whose energy is
    μ/2 (I₁ − 3) − μ sinh(2b ln J)/(2b) + λ/(4b²) (cosh(2b ln J) − 1): it differs from ours, where
    b → 0, by less than (b ln J)² of itself. Other laws have 1/D (J − 1)² for K/2 (ln J)².

    Args:
        material: of a region.

    Raises:
        ConfigError: one line, if neither program has the law.
    """
    c, d = material.constants(), 2 / (material.lmbda_MPa + 2 / 3 * material.shear_MPa)
    if isinstance(material, NeoHooke):
        big, small = material.lmbda_MPa / (4 * BETA), material.mu_MPa / 2
        poisson = [beta / (1 + 2 * beta) for beta in (BETA, -BETA)]
        return f"*HYPERFOAM, N=2\n{_numbers([small + big, 2, small - big, 2, *poisson])}"
    if isinstance(material, InvariantPolynomial):
        by_power = {POWERS[key]: value for key, value in c.items()}
        terms = max(sum(power) for power in by_power)
        factors = [by_power.get(power, 0.0) for power in ORDER if sum(power) <= terms]
        return _series("POLYNOMIAL", terms, factors, d)
    if isinstance(material, Ogden):
        pairs = zip(material.ogden_mu_MPa, material.ogden_alpha, strict=True)
        terms = len(material.ogden_alpha)
        if terms <= 3:
            return _series("OGDEN", terms, [number for pair in pairs for number in pair], d)
    if isinstance(material, ArrudaBoyce):
        return f"*HYPERELASTIC, ARRUDA-BOYCE\n{_numbers([*c.values(), d])}"
    raise no_law(material, ".inp", KNOWN)


def _series(name: str, terms: int, factors: list[float], d: float) -> str:
    """A law of several terms, of which the first alone resists a change of volume."""
    return f"*HYPERELASTIC, {name}, N={terms}\n{_numbers([*factors, d, *[0.0] * (terms - 1)])}"


def _numbers(values: list[float]) -> str:
    """Lines of at most eight numbers."""
    texts = [f"{value:.10g}" for value in values]
    return "".join(", ".join(texts[i : i + 8]) + "\n" for i in range(0, len(texts), 8))


def _supports(mesh: SolidMesh) -> str:
    across = f"{SYMMETRY}, 2, 2\n" if SYMMETRY in mesh.facets else ""
    return f"*BOUNDARY\n{CLAMP}, 1, 3\n{across}"


def _facing(config: Config, mesh: SolidMesh) -> Ints:
    """Nodes of the skin that may touch the plate: of facets that lie in its length from the tip."""
    length = float(mesh.points[:, 2].max())
    start = length - config.plate.contact_length_mm - 1e-6 * length
    facets = np.vstack([mesh.facets[name] for name in SKIN])
    return np.unique(facets[(mesh.points[facets, 2] >= start).all(axis=1)])


def _plate(config: Config, mesh: SolidMesh) -> str:
    """A rigid plane without friction: a gap element from each node that may touch it to its point.

    The reaction of the point is the plate's force.
    """
    normal, nodes = normal_of(config.plate), _facing(config, mesh)
    if not len(nodes):
        words = f"{config.plate.contact_length_mm:g}: allowed: longer than the elements at the tip"
        raise ConfigError(f"plate.contact_length_mm = {words}")
    along = mesh.points[nodes] @ normal
    place, point, first = along.min() - config.plate.gap_mm, len(mesh.points) + 1, len(mesh.cells)
    lines = [f"*NODE, NSET={PLATE}\n{point}, {', '.join(f'{x:.10g}' for x in place * normal)}\n"]
    for i, (node, away) in enumerate(zip(nodes + 1, along - place, strict=True), first + 1):
        lines.append(f"*ELEMENT, TYPE=GAPUNI, ELSET=gap_{i}\n{i}, {point}, {node}\n")
        direction = ", ".join(f"{x:.10g}" for x in normal)
        lines.append(f"*GAP, ELSET=gap_{i}\n{away:.10g}, {direction}, , {GAP_N_MM:g}, 1e-8\n")
    return "".join([*lines, f"*BOUNDARY\n{PLATE}, 1, 3\n"])


def _steps(
    config: Config, mesh: SolidMesh, pressures: Mapping[str, Sequence[float]], plate: bool
) -> Iterator[str]:
    """A step to rest if there is weight, and one through all pressures, a second for each.

    A step for each would begin without CalculiX' extrapolation, which its iterations need.
    """
    results = [f"*NODE PRINT, NSET={TIP}, FREQUENCY=1\nU\n"]
    if plate:
        results.append(f"*NODE PRINT, NSET={PLATE}, FREQUENCY=1\nRF\n")
    results.append("*NODE FILE, FREQUENCY=4\nU, RF\n*EL FILE, FREQUENCY=4\nS\n*END STEP\n")
    loads: dict[str, str] = dict.fromkeys(pressures, "")
    for name in cavities(mesh.facets):
        supply, part = supplied(config, name)
        loads[supply] += f"{name}, P, {part:.12g}\n"
    for supply, values in pressures.items():
        amplitude = [number for i, p_kPa in enumerate(values) for number in (i, p_kPa * KPA)]
        yield f"*AMPLITUDE, NAME={supply}\n{_numbers(amplitude)}"
    if size := config.gravity.acceleration_m_s2:
        axis = np.asarray(config.gravity.direction) / np.linalg.norm(config.gravity.direction)
        yield f"{_static(1)}*DLOAD\n{SOLID}, GRAV, {_numbers([MM_S2 * size, *axis])}"
        yield "".join(results)
    yield _static(len(pressures[PRESSURE.name]) - 1)
    yield from (f"*DSLOAD, AMPLITUDE={name}\n{load}" for name, load in loads.items() if load)
    yield "".join(results)


def _static(seconds: int) -> str:
    """The head of a step: first, whole, least and largest increment (s)."""
    return f"*STEP, NLGEOM, INC=10000\n*STATIC\n0.25, {seconds}., 1e-5, 0.25\n"
