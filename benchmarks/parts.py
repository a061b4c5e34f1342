"""The parts of the benchmark: which runs each consists of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dolfingrip.sections.specimen import HEXAHEDRON_MM

Spec = dict[str, Any]

FREE = ["contact.self_contact=false"]
"""The finger as the peers compute it; the bellows of a free finger do not touch."""

PAPER = [
    "solver.element=P1", "mesh.half=false", "mesh.target_elements=35140", "mesh.size_mm=1.457",
]  # fmt: skip
"""The paper's mesh: linear tetrahedra, whole finger; the size gives that number."""

REFERENCE = ["mesh.target_elements=4953", "experiment.max_pressure_kPa=100"]
"""The quadratic half finger by which machines are compared, and how far it is bent."""

REFERENCE_NODES = 10_159
"""Its nodes: a third of its dofs."""

LONG = ["experiment.step_kPa=50", "solver.max_step_kPa=50"]
"""Load steps that converge on a linear mesh: 15 iterations instead of 20."""

FELUPE_STEPS = 40
"""Equal steps to 250 kPa: FElupe's plain Newton diverges with longer ones on the finer meshes."""

CLOSE = 1e-4
"""CalculiX' loosest residual, of 4e-3, 3e-3, 2e-3, 1e-3, 3e-4, 2e-4 and this, with which the tip is
within 0.5 % of the converged one; 0.7 % off with its default of 5e-3."""

CALCULIX_SHORT = 0.02
"""Longest increment, a part of 100 kPa, where tips are compared: CalculiX ends an increment while
the angle is still up to 0.13 % off, whatever residual is asked for."""

CALCULIX_STEP = 0.04
"""CalculiX' longest increment, a part of 250 kPa. With any tried it gives up at 120 to 130 kPa:
its residual stagnates, however short the increment."""

UNIFORM_MM = {
    "P2": (4.0, 2.8, 2.0, 1.5),
    "P1": (2.8, 2.0, 1.5, 1.2),
    "P2-P1": (4.0, 2.8, 2.0),
}
GRADED_MM = ((2.8, 1.4), (2.8, 0.7))
"""Element sizes of the convergence table, and pairs of these and sizes at concave edges."""

UNGRADED_MM = HEXAHEDRON_MM
"""Size at concave edges that leaves a mesh of hexahedra without any grading."""

REFINED = (1, 2)
UNGRADED_REFINED = (1, 2, 3)
HEXAHEDRA_EDGE_MM = (0.8, 0.4, 0.1)
"""Divisions of the default mesh of hexahedra and of the ungraded one; sizes at concave edges."""

GROWTH_MM = {"P2": (6.0, 4.0, 2.8, 2.0, 1.5, 1.2, 0.95), "P1": (2.0, 1.2, 0.9, 0.7, 0.55, 0.46)}
GROWTH_REFINED = (1, 2, 3, 4)
"""Element sizes, and divisions of ungraded hexahedra, that give 10,000 to 300,000 dofs."""

RANKS = {
    "S2, default mesh divided by 2": ["mesh.refine=2"],
    "S2, ungraded mesh divided by 3": ["mesh.refine=3", f"mesh.edge_size_mm={UNGRADED_MM}"],
    "P2, elements of 1.5 mm": ["solver.element=P2", "mesh.size_mm=1.5"],
}
"""Meshes of more than 100,000 dofs, by what they are."""

COOK_CELLS = (4, 8, 16)
COOK_NU = 0.4999
FINGER_NU = 0.499
FINGER_MM = (6.0, 4.0, 2.8)
FINEST = {"cook": 32, "finger": 2.0}
"""Meshes of the mixed element that errors refer to."""


@dataclass(frozen=True, slots=True)
class Part:
    """Runs that belong together.

    Attributes:
        title: what is measured.
        specs: of the runs, by label; ``work = "calculix"`` is CalculiX.
        repeats: most repetitions that make sense, 1 where no time is read off.
    """

    title: str
    specs: dict[str, Spec]
    repeats: int = 99


def _run(kind: str, *overrides: str) -> Spec:
    return {"work": "experiment", "kind": kind, "overrides": list(overrides)}


def _peer(work: str, *overrides: str, **more: Any) -> Spec:
    return {"work": work, "overrides": [*FREE, *overrides], **more}


def _convergence() -> dict[str, Spec]:
    sizes = [
        (f"{element} {size:g}", [f"solver.element={element}", f"mesh.size_mm={size}"])
        for element, uniform in UNIFORM_MM.items()
        for size in uniform
    ]
    sizes += [
        (
            f"P2 {size:g}/{edge:g}",
            ["solver.element=P2", f"mesh.size_mm={size}", f"mesh.edge_size_mm={edge}"],
        )
        for size, edge in GRADED_MM
    ]
    sizes += [(f"S2 {number}", [f"mesh.refine={number}"]) for number in REFINED]
    sizes += [
        (f"S2 {number}/{edge:g}", [f"mesh.edge_size_mm={edge}", f"mesh.refine={number}"])
        for number, edge in [
            *((number, UNGRADED_MM) for number in UNGRADED_REFINED),
            *((1, edge) for edge in HEXAHEDRA_EDGE_MM),
        ]
    ]
    return {
        f"{kind} {name}": _run(kind, *overrides)
        for name, overrides in sizes
        for kind in ("bending", "blocked_force")
    }


def _growth() -> dict[str, Spec]:
    meshes = {
        f"{element} {size:g}": [f"solver.element={element}", f"mesh.size_mm={size}"]
        for element, sizes in GROWTH_MM.items()
        for size in sizes
    } | {
        f"S2 {number}": [f"mesh.edge_size_mm={UNGRADED_MM}", f"mesh.refine={number}"]
        for number in GROWTH_REFINED
    }
    return {
        label: _run("bending", *FREE, *overrides, "experiment.max_pressure_kPa=50")
        for label, overrides in meshes.items()
    }


def _incompressible() -> dict[str, Spec]:
    elements = ("P1", "P2", "P2-P1")
    cook = [(element, cells) for element in elements for cells in COOK_CELLS]
    finger = [(element, size) for element in elements for size in FINGER_MM]
    cook.append(("P2-P1", FINEST["cook"]))
    finger.append(("P2-P1", FINEST["finger"]))
    return {
        f"cook {element} {cells}": {
            "work": "cook", "element": element, "cells": cells, "nu": COOK_NU,
            "overrides": [f"solver.element={element}"],
        }
        for element, cells in cook
    } | {
        f"finger {element} {size:g}": _run(
            "bending",
            *FREE,
            f"solver.element={element}",
            f"mesh.size_mm={size}",
            f"material.nu={FINGER_NU}",
            "experiment.max_pressure_kPa=25",
        )
        for element, size in finger
    }  # fmt: skip


def _ranks() -> dict[str, Spec]:
    return {
        f"{mesh}, {ranks}": {
            **_run("bending", *FREE, *overrides, "experiment.max_pressure_kPa=50"),
            "ranks": ranks,
        }
        for mesh, overrides in RANKS.items()
        for ranks in (1, 2)
    }


PARTS: dict[str, Part] = {
    "machine": Part(
        f"half finger of {REFERENCE_NODES:,} quadratic nodes, free, to 100 kPa",
        {
            "calculix": _peer("calculix", *REFERENCE),
            "calculix close": _peer(
                "calculix", *REFERENCE, controls={"residual": CLOSE}, once=True
            ),
            "calculix tight": _peer(
                "calculix", *REFERENCE, controls={"residual": 1e-5}, once=True
            ),
            "calculix short": _peer(
                "calculix",
                *REFERENCE,
                controls={"residual": 1e-5, "longest": CALCULIX_SHORT},
                once=True,
            ),
            "dolfingrip": _peer("bending", *REFERENCE, energy="split"),
        },
    ),
    "blocked": Part(
        "blocked force to 250 kPa, half finger, self-contact",
        {
            "dolfingrip": _run("blocked_force"),
            "P2": {**_run("blocked_force", "solver.element=P2"), "once": True},
        },
    ),
    "paper": Part(
        "blocked force to 250 kPa, 35,140 linear tetrahedra, whole finger, self-contact",
        {"dolfingrip": _run("blocked_force", *PAPER)},
    ),
    "linear": Part(
        "free bending to 250 kPa in steps of 50 kPa, 35,140 linear tetrahedra, whole finger",
        {
            "dolfingrip": _run("bending", *FREE, *PAPER, *LONG),
            "steps of 25 kPa": {**_run("bending", *FREE, *PAPER), "once": True},
            "with self-contact": {**_run("bending", *PAPER), "once": True},
        },
    ),
    "calculix": Part(
        "free bending to 250 kPa, P2 and C3D10 on one mesh, same energy",
        {
            "calculix": _peer(
                "calculix", "solver.element=P2", controls={"longest": CALCULIX_STEP}, once=True
            ),
            "dolfingrip": _peer("bending", "solver.element=P2", energy="split"),
        },
    ),
    "felupe": Part(
        "free bending to 250 kPa, linear half finger, same energy",
        {
            "felupe": _peer(
                "felupe",
                "solver.element=P1",
                "mesh.size_mm=2.2",
                steps=FELUPE_STEPS,
                ordering="MMD_AT_PLUS_A",
            ),
            "dolfingrip": _peer("bending", "solver.element=P1", "mesh.size_mm=2.2"),
        },
    ),
    "felupe-paper": Part(
        "free bending to 250 kPa, 35,140 linear tetrahedra, whole finger, same energy",
        {
            "felupe": _peer("felupe", *PAPER, steps=FELUPE_STEPS, ordering="MMD_AT_PLUS_A"),
            "dolfingrip": _peer("bending", *PAPER),
        },
        repeats=1,
    ),
    "convergence": Part("angle and force at 250 kPa against mesh size", _convergence(), repeats=1),
    "growth": Part("free bending to 50 kPa against dofs", _growth(), repeats=1),
    "incompressible": Part(
        f"Cook's membrane, nu = {COOK_NU}, and free bending to 25 kPa, nu = {FINGER_NU}",
        _incompressible(),
        repeats=1,
    ),
    "ranks": Part("free bending to 50 kPa, 1 and 2 ranks", _ranks()),
}  # fmt: skip
"""By name, in the order of running."""
