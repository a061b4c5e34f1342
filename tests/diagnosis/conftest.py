"""What tests of the diagnosis share."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where a module's tests keep their simulations."""
    return tmp_path_factory.mktemp("store")
