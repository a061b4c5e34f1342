"""The library's simulations in small files: written, and entered where they are wanted again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.blind import diagnoses, library, packed
from benchmarks.blind.library import Entry
from dolfingrip.diagnosis.simulation import shipped
from dolfingrip.diagnosis.simulation.job import SHARED, calls
from dolfingrip.diagnosis.workers import StayingWorkers
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import Answer
from dolfingrip.jobs.store import Store


def kept(entries: list[Entry], folder: Path) -> None:
    """Enter made-up forces, so that a simulation would not give the same."""
    for number, entry in enumerate(entries):
        count = len(entry.job.config.protocol.displacement_mm)
        with Store(folder / entry.store, write=True) as store:
            store.add(calls([entry.job]), SHARED)
            curve = {"force_N": [0.25 * (number + 1) * i for i in range(count)]}
            store.record(Answer(entry.job.key, "done", {"curve": curve}, wall_s=1.0, worker="here"))


def test_what_was_written_is_entered_and_not_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = library.entries("pull-up")[:3]
    kept(entries, tmp_path / "first")
    files = packed.write(entries, tmp_path / "first", tmp_path / "files")
    stores = dict.fromkeys(entry.store for entry in entries)
    assert [file.stem for file in files] == list(stores)
    monkeypatch.setattr(library, "entries", lambda history: entries)
    library.compute(
        "pull-up", tmp_path / "again",
        lambda store: StayingWorkers(
            tmp_path, Where(workers=1), computes=False,
            known=shipped.read(tmp_path / "files" / f"{store}.npz"),
        ),
    )  # fmt: skip
    before = library.known(entries, tmp_path / "first")
    after = library.known(entries, tmp_path / "again")
    assert after.keys() == before.keys()
    assert len(after) == len(entries)
    for key, result in after.items():
        np.testing.assert_allclose(result.columns["force_N"], before[key].columns["force_N"])


def test_a_history_that_was_not_simulated_has_no_file(tmp_path: Path) -> None:
    entries = library.entries("pull-up")
    assert packed.write(entries, tmp_path / "none", tmp_path / "files") == []


OF_THE_LIBRARY = sorted(
    file
    for file in diagnoses.PACKED.glob("*.npz")
    if not file.name.startswith(diagnoses.OF_ANALYSER)
)


@pytest.mark.parametrize("file", OF_THE_LIBRARY, ids=lambda file: file.stem)
def test_the_files_of_the_repository_are_of_the_library(file: Path) -> None:
    """Each result is of a simulation that the library wants today."""
    found = shipped.read(file)
    assert found is not None
    wanted = {
        entry.job.key_without_protocol
        for history in library.HISTORIES
        for entry in library.entries(history)
        if entry.store == file.stem
    }
    assert set(found.known) <= wanted
