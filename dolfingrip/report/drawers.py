"""The registry of files that draw an experiment's result in place of one finger's shapes."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Final

DRAWERS: Final = {"gripper": "dolfingrip.report.gripper"}
"""Files with ``draw`` and ``strip``, by the ``pictures`` of an experiment."""


def drawer(pictures: str) -> ModuleType | None:
    """Import the file that draws a result, with the libraries that it draws by.

    Args:
        pictures: of the experiment.

    Returns:
        The file; None where shapes of one finger are drawn.
    """
    return importlib.import_module(DRAWERS[pictures]) if pictures in DRAWERS else None
