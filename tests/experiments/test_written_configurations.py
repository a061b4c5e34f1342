"""What one command writes, every experiment takes: a part that was adopted, and runs' settings."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from mpi4py import MPI
from support import hollow_bar
from support.command import run_command

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.rigs.undeformed import load_domain
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.sections.geometry.index import GEOMETRIES
from dolfingrip.sections.tables import assignments

every = pytest.mark.parametrize("experiment", EXPERIMENTS.values(), ids=list(EXPERIMENTS))


@pytest.fixture(scope="module")
def adopted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a part that `adopt` took as half a finger, with linear tetrahedra."""
    folder = tmp_path_factory.mktemp("adopted")
    part = hollow_bar.stl(folder / "bar.stl")
    assert run_command("adopt", part, "--out", folder, "--size-mm", "5") == 0
    return folder


def of_part(folder: Path, *settings: str) -> Config:
    """The configuration that `adopt` wrote, with other values."""
    told = assignments(['solver.element="P1"', *settings])
    return config.load(folder / "adopted.toml", told)


@every
@pytest.mark.parametrize("half", [True, False])
def test_a_part_that_was_adopted(adopted: Path, experiment: Experiment, half: bool) -> None:
    """Every experiment builds its model of half a file, and of its mirror image beside it."""
    asked = of_part(adopted, f"mesh.half={str(half).lower()}")
    experiment.prepare(experiment.settings(asked), MPI.COMM_SELF, Profile())


@pytest.mark.parametrize("kind", GEOMETRIES)
def test_settings_of_another_experiment(adopted: Path, kind: str) -> None:
    """The configuration that a run stores has a schedule and a set-up in every experiment."""
    file = {"file": str(adopted / "adopted.msh")} if GEOMETRIES[kind].of_file else {}
    first = config.from_dict({"finger": {"kind": kind}, "mesh": file})
    for one in EXPERIMENTS.values():
        stored = one.settings(first)
        again = config.from_dict(tomllib.loads(config.dumps(stored)))
        assert again == stored
        for other in EXPERIMENTS.values():
            settings = other.settings(again)
            assert other.schedule(settings)
            assert other.described(settings)["experiment"] == other.name


UNEVEN = {
    "one family of threads": (
        "film.thread.fibre_Et_N_per_mm=[5.0]", "film.thread.fibre_deg=[45.0]",
    ),
    "weight": ("gravity.acceleration_m_s2=9.81", "gravity.direction=[0.0, 1.0, 0.0]"),
    "plate": ("plate.normal=[1.0, 1.0, 0.0]",),
    "food beside it": (
        'obstacle.kind="potato-small"', "obstacle.z_mm=40.0",
    ),
}  # fmt: skip


@pytest.mark.parametrize("settings", UNEVEN.values(), ids=list(UNEVEN))
def test_half_a_file_refuses_what_is_no_mirror_image(
    adopted: Path, settings: tuple[str, ...]
) -> None:
    """The whole, its mirror image beside it, takes it."""
    bending = EXPERIMENTS["bending"]
    key = settings[-1].partition(".")[0]
    with pytest.raises(ConfigError, match=rf"^{key}.* mesh\.half = "):
        bending.prepare(of_part(adopted, *settings), MPI.COMM_SELF, Profile())
    whole = of_part(adopted, *settings, "mesh.half=false")
    assert not load_domain(whole, MPI.COMM_SELF).half
