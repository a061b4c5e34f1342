"""Where CHOLMOD is looked for, and what a machine without it computes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from support import small

from dolfingrip.experiments import run
from dolfingrip.mechanics.newton import cholmod

SINGLE = "    #define CHOLMOD_SINGLE 4\n"


def test_the_first_header_with_single_precision_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A header of before SuiteSparse 7.4 is passed over; its CHOLMOD_SINGLE is 1."""
    places = [str(tmp_path / name) for name in ("none", "old", "conda", "system")]
    for place, text in zip(places[1:], (SINGLE.replace("4", "1"), SINGLE, SINGLE), strict=True):
        folder = Path(place, "include", "suitesparse")
        folder.mkdir(parents=True)
        (folder / "cholmod.h").write_text(text, encoding="utf-8")
    monkeypatch.setattr(cholmod, "PLACES", places)
    found = cholmod.header.__wrapped__()
    assert found == tmp_path / "conda" / "include" / "suitesparse" / "cholmod.h"
    monkeypatch.setattr(cholmod, "PLACES", ["", *places[:2]])
    assert cholmod.header.__wrapped__() is None


@pytest.mark.parametrize("control", ["pressure", "volume"])
def test_mumps_takes_its_place(control: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Readings with and without CHOLMOD differ by less than Newton's tolerance leaves."""
    settings = small.short(f"experiment.control={control}", "experiment.max_volume_ratio=1.02")
    with_it = run("bending", settings, comm=MPI.COMM_SELF)
    monkeypatch.setattr(cholmod, "available", lambda: False)
    without = run("bending", settings, comm=MPI.COMM_SELF)
    assert without.facts.newton.factors == "MUMPS"
    angles, others = with_it.column("angle_deg"), without.column("angle_deg")
    assert np.allclose(angles, others, rtol=1e-6, atol=0)
    assert angles[-1] > 1
