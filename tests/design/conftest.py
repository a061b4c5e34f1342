"""A surrogate of the stand-in, trained once."""

from __future__ import annotations

from pathlib import Path

import pytest
from support import stand_in

from dolfingrip.design.surrogate.training import Training, train


@pytest.fixture(scope="session")
def training() -> Training:
    return train(stand_in.table())


@pytest.fixture(scope="session")
def surrogate_folder(training: Training, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("surrogate")
    training.surrogate.save(folder)
    return folder
