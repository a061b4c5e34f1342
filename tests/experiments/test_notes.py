"""Doubts about regions and about the choice of the element."""

from __future__ import annotations

import pytest

from dolfingrip import config
from dolfingrip.experiments.finger_experiment import notes
from dolfingrip.sections.tables import assignments


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        ([], []),
        (["material.nu=0.465"], []),
        (["material.nu=0.48"], ['"S2": nu = 0.48 is nearly incompressible']),
        (["material.nu=0.48", "mesh.target_elements=3000"], []),
        (["solver.element=P1"], ["linear tetrahedra are too stiff"]),
        (["material.nu=0.499", "solver.element=P2"], ["nu = 0.499 is nearly incompressible"]),
        (
            ["material.bulk_MPa=14650", "solver.element=P2"],
            ["nu = 0.4999 is nearly incompressible"],
        ),
        (["material.nu=0.499", "solver.element=P2-P1"], []),
        (["finger.kind=adopted", "mesh.file=a.msh", "material.nu=0.48"], []),
        (
            ["finger.kind=adopted", "mesh.file=a.msh", "material.nu=0.499"],
            ['"P2": nu = 0.499 is nearly incompressible, where it locks: the finger is too stiff'],
        ),
        (["finger.kind=cast"], ["region film is of the same material as the rest"]),
        (["finger.kind=pneunet"], ["give [material.paper], or a film"]),
        (["finger.kind=cast", "material.film.mu_MPa=30"], []),
        (["finger.kind=pneunet", "film.paper.Et_N_per_mm=50"], []),
        (["cavity.cavity.closed=true"], ["closed = true: no cavity has a supply, so the pressure"]),
        (["cavity.cavity.pressure_ratio=0"], ["pressure_ratio = 0: no cavity has a supply"]),
        (
            [
                "protocol.time_s=[0.0, 1.0]",
                "protocol.pressure_kPa=[0.0, 0.0]",
                "cavity.cavity.pressure_kPa=[0.0, 9.0]",
            ],
            [],
        ),
        (["cavity.cavity.pressure_ratio=-0.2"], []),
        (["mesh.file=a.msh", "cavity.one.closed=true"], ["cavity.one.closed = true: no cavity"]),
        (["mesh.file=a.msh", "cavity.one.closed=true", "cavity.two.pressure_ratio=0.5"], []),
    ],
)
def test_notes(overrides: list[str], said: list[str]) -> None:
    """One line for each doubt, none about the element that suits the material."""
    found = notes(config.load(None, assignments(overrides)))
    assert len(found) == len(said)
    assert all(part in line for part, line in zip(said, found, strict=True))
