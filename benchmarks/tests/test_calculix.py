"""CalculiX solves decks of :mod:`dolfingrip.meshes.abaqus`, and bends as far as we do."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from support.small import SHORT

from benchmarks import bending, calculix, measure
from dolfingrip import config
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.sections.tables import assignments


@pytest.mark.skipif(shutil.which("ccx") is None, reason="no CalculiX here")
@pytest.mark.parametrize(
    ("element", "kind", "tolerance"),
    [
        ("P2", "C3D10", 2e-3),  # what CalculiX' own tolerance leaves
        ("default", "C3D20R", 2e-2),  # which has fewer integration points than ours
    ],
)
def test_calculix_bends_our_deck_as_far(
    element: str, kind: str, tolerance: float, tmp_path: Path
) -> None:
    """The reference is CalculiX 2.20 with the same energy, fixed and loaded by our groups."""
    settings = config.load(
        None,
        assignments(
            [
                *SHORT, "mesh.order=2", "contact.self_contact=false",
                "experiment.max_pressure_kPa=20", "experiment.step_kPa=20",
                *([f"solver.element={element}"] if element != "default" else []),
            ]
        ),
    )  # fmt: skip
    mesh, deck = solid(settings), tmp_path / "finger.inp"
    calculix.write_deck(deck, mesh, settings, longest=0.25)
    assert f"*ELEMENT, TYPE={kind}\n" in deck.read_text(encoding="utf-8")
    measure.run_calculix("ccx", deck)
    reached, theirs = calculix.read_tip(deck.with_suffix(".dat"), mesh)
    ours = bending.bend(settings, "split")["rows"][-1]
    assert reached == 1.0
    length = float((theirs**2).sum() ** 0.5)
    assert length > 0.5  # mm
    assert [ours["tip_x_mm"], ours["tip_z_mm"]] == pytest.approx(
        [theirs[0], theirs[2]], abs=tolerance * length
    )
