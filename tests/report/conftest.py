"""A small bellows finger with an analytic bending field, written as a run would write it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure
from support import synthetic_run


@pytest.fixture(scope="session", params=["P1", "P2", "Q1", "Q2"])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a synthetic run with ``fields.pvd`` and ``result.csv``, half finger."""
    folder = tmp_path_factory.mktemp(f"run_{request.param}")
    cell = "hexahedron" if request.param.startswith("Q") else "tetrahedron"
    synthetic_run.write_run(folder, int(request.param[1]), cell=cell)
    return folder


@pytest.fixture(scope="session")
def quadratic_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a synthetic run with quadratic fields, half finger."""
    folder = tmp_path_factory.mktemp("run_quadratic")
    synthetic_run.write_run(folder, 2)
    return folder


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """Figures saved during a test, to ask for their texts."""
    saved: list[Figure] = []
    save = Figure.savefig

    def spy(self: Figure, *args: Any, **kwargs: Any) -> None:
        save(self, *args, **kwargs)
        saved.append(self)

    monkeypatch.setattr(Figure, "savefig", spy)
    return saved
