"""CalculiX (https://www.calculix.de): decks of free bending, and how far their tips went."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.calculix import Printed, printed
from support.tip import mean_displacement

from dolfingrip.config import KPA, Config
from dolfingrip.meshes.abaqus import deck
from dolfingrip.meshes.groups import CAVITY, CLAMP, SOLID, SYMMETRY, TIP
from dolfingrip.meshes.solid import SolidMesh


def write_deck(
    path: Path, mesh: SolidMesh, config: Config, longest: float = 1.0, residual: float = 5e-3
) -> None:
    """Write a deck that bends the finger to the configuration's highest pressure.

    Pressure on faces of elements follows them under NLGEOM. The strain energy is that of
    :mod:`benchmarks.split_energy`; the increments are CalculiX' own choice after the first.

    CalculiX ends an increment while the angle is still up to 0.13 % off, whatever residual is asked
    for. Where tips are compared, the increments are to be short.

    Args:
        path: of the deck, ``….inp``.
        mesh: tetrahedra (C3D4 or C3D10) or hexahedra (C3D8 or C3D20R).
        config: moduli (MPa) and pressure (kPa).
        longest: longest increment, a part of the pressure.
        residual: largest residual force over the average force; 5e-3 is CalculiX' default.
    """
    bulk = config.material.lmbda_MPa + 2 / 3 * config.material.mu_MPa
    lines = [
        deck(mesh).rstrip("\n"),
        "*MATERIAL, NAME=rubber",
        "*HYPERELASTIC, NEO HOOKE",
        f"{config.material.mu_MPa / 2:.12g}, {2 / bulk:.12g}",
        f"*SOLID SECTION, ELSET={SOLID}, MATERIAL=rubber",
        "*BOUNDARY",
        f"{CLAMP}, 1, 3",
    ]
    if SYMMETRY in mesh.facets:
        lines.append(f"{SYMMETRY}, 2, 2")
    increments = f"{min(0.1, longest):g}, 1., 1e-5, {longest:g}"
    lines += ["*STEP, NLGEOM, INC=1000", "*CONTROLS, PARAMETERS=FIELD"]
    # largest residual, and largest correction over the largest increment (0.01 by default)
    lines.append(f"{residual:g}, {min(0.01, 100 * residual):g}")
    lines += ["*STATIC", increments]
    lines += ["*DSLOAD", f"{CAVITY}, P, {config.experiment.max_pressure_kPa * KPA:.12g}"]
    lines += [f"*NODE PRINT, NSET={TIP}, FREQUENCY=1", "U", "*END STEP"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_tip(path: Path, mesh: SolidMesh) -> tuple[float, np.ndarray]:
    """The last tip displacement in the ``.dat`` file.

    Returns:
        The part of the pressure that was reached, less than 1 where CalculiX gave up, and
        the tip's mean displacement there (mm), (3,).
    """
    *_, last = Printed("displacements", 0.0, np.empty((0, 4))), *printed(path)
    return last.time_s, mean_displacement(mesh, last.on(mesh))


def iterations(path: Path) -> dict[str, int]:
    """Newton iterations and increments, from the ``.sta`` file; failed attempts count, too."""
    table = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    attempts = [words for words in table if len(words) == 7 and words[0].isdigit()]
    return {
        "iterations": sum(int(words[3]) for words in attempts),
        "load_steps": sum(words[2].isdigit() for words in attempts),
    }
