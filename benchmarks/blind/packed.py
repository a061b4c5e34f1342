"""The generator's simulations as small files in the repository, so that none is computed twice.

A file holds what one store of the library (:mod:`library`) had when it was written. The rules are
those of the simulations that come with the package
(:mod:`dolfingrip.diagnosis.simulation.shipped`): a result serves only the very configuration that
it was computed with, those of an effect only while that effect's code is unchanged, and where the
mechanics have changed one simulation has to agree first.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from benchmarks.blind.library import Entry, known
from dolfingrip.diagnosis.simulation import shipped

FOLDER: Final = Path(__file__).with_name("simulated")


def file_of(store: str) -> Path:
    """Where the results of a store are, if they have been written."""
    return FOLDER / f"{store}.npz"


def write(entries: list[Entry], folder: Path, to: Path = FOLDER) -> list[Path]:
    """Write what has been simulated, a file for each store.

    Args:
        entries: of the library, of all histories that are to be kept.
        folder: of the library's stores.
        to: folder of the files.

    Returns:
        Files that were written.
    """
    to.mkdir(parents=True, exist_ok=True)
    found = known(entries, folder)
    files = []
    for store in dict.fromkeys(entry.store for entry in entries):
        jobs = {
            entry.job.key: entry.job
            for entry in entries
            if entry.store == store and entry.job.key in found
        }
        if jobs:
            file = to / file_of(store).name
            shipped.write(file, jobs.values(), [found[key] for key in jobs])
            files.append(file)
    return files
