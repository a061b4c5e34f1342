"""Fingers as they truly are: faults of the body, the rig and the instruments, and their readings.

CalculiX solves a deck of :mod:`dolfingrip.exporting.deck` for each body: half a finger of quadratic
tetrahedra by Gmsh, where the analyser has hexahedra of its own. The law is a polynomial of the
invariants with another volumetric function, the plate is ideally hard, and walls may pass through
one another, which they do not up to the largest pressure.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline
from support.calculix import printed, solve
from support.tip import area_vector

from benchmarks.blind.said import rows
from dolfingrip import config as configuration
from dolfingrip.channels import ANGLE, FORCE, PRESSURE
from dolfingrip.config import Config
from dolfingrip.experiments.rigs.undeformed import elements
from dolfingrip.exporting import deck
from dolfingrip.mechanics.readings.tip import angle_deg
from dolfingrip.meshes.groups import SOLID
from dolfingrip.sections.tables import assignments

PRESSURES_kPa: Final = tuple(12.5 * step for step in range(1, 9))
GAP_mm: Final = 1.0
MU_MPa: Final = 2.93
WALL_mm: Final = 1.6
READINGS: Final = Path(__file__).with_name("readings.csv")
COLUMNS: Final[Mapping[str, str]] = {"bending": ANGLE.name, "blocked_force": FORCE.name}


@dataclass(frozen=True, slots=True)
class Patch:
    """A part of the base layer that is stiffer.

    Attributes:
        along_mm: where it begins and ends along the finger.
        thick_mm: from the base's outside.
        factor: of its moduli.
    """

    along_mm: tuple[float, float]
    thick_mm: float
    factor: float


@dataclass(frozen=True, slots=True)
class Truth:
    """Faults of a finger, of its rig and of its instruments, which are hidden.

    Attributes:
        named: effects or numbers of the rig, of which an answer has to name one; empty where
            nothing is to be named. Of two that act there is a set for each.
        modulus: factor of μ = 2.93 MPa.
        C01_MPa, C20_MPa: of the invariants' polynomial, beside μ.
        walls: factor of their thickness.
        overrides: of the configuration that the deck is of.
        patch: a stiffer part; None where the body is even.
        pressure, angle, force: true pressure by the one that is read, and shown readings by true
            ones.
        numbers: true values by key of the configuration, beside those of modulus and walls.
    """

    named: Sequence[frozenset[str]] = ()
    modulus: float = 1.0
    C01_MPa: float = 0.0
    C20_MPa: float = 0.0
    walls: float = 1.0
    overrides: Sequence[str] = ()
    patch: Patch | None = None
    pressure: float = 1.0
    angle: float = 1.0
    force: float = 1.0
    numbers: Mapping[str, float] = field(default_factory=dict)

    @property
    def true_numbers(self) -> dict[str, float]:
        """True values by key of the configuration."""
        return {
            "material.mu_MPa": self.modulus * MU_MPa, "finger.wall_mm": self.walls * WALL_mm,
            **self.numbers,
        }  # fmt: skip


def _one(*names: str) -> frozenset[str]:
    return frozenset(names)


CASES: Final[Mapping[str, Truth]] = {
    "nothing": Truth(),
    "modulus": Truth(modulus=1.12),
    "walls": Truth(walls=1.06),
    "mooney": Truth(
        [_one("mooney_rivlin")], C01_MPa=1.36, numbers={"extensions.mooney_rivlin.C01_MPa": 1.36},
    ),
    "yeoh": Truth([_one("yeoh")], C20_MPa=1.5, numbers={"extensions.yeoh.C20_MPa": 1.5}),
    "mooney_walls": Truth(
        [_one("mooney_rivlin")], C01_MPa=1.2, walls=1.06,
        numbers={"extensions.mooney_rivlin.C01_MPa": 1.2},
    ),
    "regulator": Truth([_one("pressure_gain")], pressure=1.06,
                       numbers={"extensions.pressure_gain.gain": 1.06}),
    "plate": Truth([_one("plate_gap")], overrides=[f"plate.gap_mm={GAP_mm + 1.2}"],
                   numbers={"extensions.plate_gap.offset_mm": 1.2}),
    "base_layer": Truth([_one("base_layer_offset")], overrides=["finger.base_layer_mm=3.9"],
                        numbers={"extensions.base_layer_offset.offset_mm": 0.4}),
    "weight": Truth([_one("gravity_pitch")], overrides=[
        "gravity.acceleration_m_s2=9.81", "gravity.direction=[0.0, 0.0, 1.0]"]),
    "camera": Truth([_one("angle_gain", "angle_definition")], angle=0.95,
                    numbers={"extensions.angle_gain.gain": 0.95}),
    "load_cell": Truth([_one("force_gain")], force=1.06, modulus=1.1,
                       numbers={"extensions.force_gain.gain": 1.06}),
    "stiff_patch": Truth([_one("uneven_stiffness")], patch=Patch((35.0, 65.0), 3.0, 3.0)),
    "regulator_mooney": Truth(
        [_one("pressure_gain"), _one("mooney_rivlin")], pressure=1.05, C01_MPa=1.36,
        numbers={"extensions.mooney_rivlin.C01_MPa": 1.36, "extensions.pressure_gain.gain": 1.05},
    ),
}  # fmt: skip
"""By name; of each the readings are committed."""


def body(truth: Truth) -> Config:
    """The finger of a deck, at the pressures that truly act.

    Args:
        truth: its faults.
    """
    mu_MPa = truth.modulus * MU_MPa
    told = [
        "solver.element=P2", "material.law=polynomial", f"material.C01_MPa={truth.C01_MPa}",
        f"material.C10_MPa={mu_MPa / 2 - truth.C01_MPa}", f"material.C20_MPa={truth.C20_MPa}",
        f"finger.wall_mm={truth.walls * WALL_mm}", f"plate.gap_mm={GAP_mm}", *truth.overrides,
    ]  # fmt: skip
    stops = [0.0, *(truth.pressure * each for each in PRESSURES_kPa)]
    return configuration.load(None, assignments(told)).changed(
        protocol={"time_s": [float(i) for i in range(len(stops))], PRESSURE.name: stops}
    )


def decks(truth: Truth, folder: Path) -> dict[str, Path]:
    """Write the deck of each experiment.

    Args:
        truth: the faults.
        folder: for the decks.
    """
    folder.mkdir(parents=True, exist_ok=True)
    config = body(truth)
    found = {name: folder / f"{name}.inp" for name in COLUMNS}
    deck.write(config, found["bending"])
    still = config.changed(gravity={"acceleration_m_s2": 0.0})
    deck.write(still, found["blocked_force"], plate=True)
    if config.gravity.acceleration_m_s2:  # the first step of the free finger: it hangs
        first = found["bending"].read_text(encoding="utf-8")
        start = first.index("*STEP")
        hung = first[start : first.index("*END STEP\n") + len("*END STEP\n")]
        text = found["blocked_force"].read_text(encoding="utf-8")
        found["blocked_force"].write_text(text.replace("*STEP", f"{hung}*STEP", 1), "utf-8")
    for file in found.values():
        text = file.read_text(encoding="utf-8").replace("FREQUENCY=4", "FREQUENCY=1")
        file.write_text(_patched(text, config, truth.patch) if truth.patch else text, "utf-8")
    return found


def _patched(text: str, config: Config, patch: Patch) -> str:
    """A deck some of whose elements are of a stiffer material."""
    mesh, material = elements(config), config.material
    x, _, z = mesh.points[mesh.cells].mean(axis=1).T
    low, high = patch.along_mm
    inside = (x - mesh.points[:, 0].min() < patch.thick_mm) & (z > low) & (z < high)
    law = deck.law(material)
    stiffer = material.model_copy(
        update={name: patch.factor * value for name, value in material.constants().items()}
    )
    section = f"*SOLID SECTION, ELSET={SOLID}, MATERIAL={SOLID}\n"
    assert section in text
    assert inside.any()
    sets = ""
    for name, own in (("soft", ~inside), ("stiff", inside)):
        rows = "".join(f"{number}\n" for number in np.flatnonzero(own) + 1)
        sets += f"*ELSET, ELSET={name}\n{rows}"
    assert law in text
    return text.replace(
        section,
        f"*MATERIAL, NAME=stiff\n{deck.law(stiffer)}{sets}"
        f"*SOLID SECTION, ELSET=soft, MATERIAL={SOLID}\n"
        "*SOLID SECTION, ELSET=stiff, MATERIAL=stiff\n",
    )


def readings(truth: Truth, folder: Path) -> dict[str, list[float]]:
    """Simulate angle (deg) and force (N) at each pressure, as the instruments show them.

    Args:
        truth: the faults.
        folder: for decks and results.

    Raises:
        RuntimeError: CalculiX gave up.
    """
    files, mesh = decks(truth, folder), elements(body(truth))
    turned = {0.0: 0.0}
    for block in printed(solve(files["bending"])):
        x, _, z = area_vector(mesh, block.on(mesh))
        turned[block.time_s] = angle_deg(x, z)
    pressed = {
        block.time_s: 2 * float(np.linalg.norm(block.rows[0, 1:]))
        for block in printed(solve(files["blocked_force"])) if block.what == "forces"
    }  # fmt: skip
    # a finger that hangs does so for a second first
    begins_s = float(round(max(turned)) - len(PRESSURES_kPa))
    return {
        ANGLE.name: [truth.angle * each for each in _after(turned, begins_s)],
        FORCE.name: [truth.force * each for each in _after(pressed, begins_s)],
    }


def _after(known: Mapping[float, float], begins_s: float) -> list[float]:
    """Changes from a time on at whole seconds, where increments need not end."""
    time_s, value = (np.array(each) for each in zip(*sorted(known.items()), strict=True))
    curve = CubicSpline(time_s[time_s > begins_s], value[time_s > begins_s])
    at_rest = float(np.interp(begins_s, time_s, value)) if begins_s else 0.0
    whole_s = begins_s + 1 + np.arange(len(PRESSURES_kPa))
    return [float(each) - at_rest for each in curve(whole_s)]


def simulate(names: Sequence[str], folder: Path, table: Path = READINGS) -> None:
    """Simulate cases that a table does not have yet, and add them to it.

    Args:
        names: of the cases.
        folder: for decks and results.
        table: of the readings.
    """
    known = stored(table)
    for name in names:
        if name in known:
            continue
        known[name] = readings(CASES[name], folder / name)
        print(name, known[name], flush=True)
        with table.open("w", encoding="utf-8", newline="") as stream:
            written = csv.writer(stream, lineterminator="\n")
            written.writerow(["case", PRESSURE.name, *COLUMNS.values()])
            for each, own in known.items():
                shown = zip(*(own[column] for column in COLUMNS.values()), strict=True)
                for pressure, values in zip(PRESSURES_kPa, shown, strict=True):
                    written.writerow([each, f"{pressure:g}", *(f"{value:.6g}" for value in values)])


def stored(table: Path = READINGS) -> dict[str, dict[str, list[float]]]:
    """Read readings without noise, by case and column.

    Args:
        table: a file; there are none where it does not exist.
    """
    found: dict[str, dict[str, list[float]]] = {}
    for row in rows(table) if table.exists() else ():
        own = found.setdefault(row["case"], {name: [] for name in COLUMNS.values()})
        for name, values in own.items():
            values.append(float(row[name]))
    return found
