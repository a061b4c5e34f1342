"""The registry of files that draw an experiment's result in place of one finger's shapes."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Final, NamedTuple

from dolfingrip.channels import Colour

DRAWERS: Final = {"gripper": "dolfingrip.report.gripper"}
"""Files with ``draw`` and ``strip``, by the ``pictures`` of an experiment."""


class WantedPictures(NamedTuple):
    """How pictures and the film of a result are asked for.

    Attributes:
        colour_by: field of the colours, or none; None: the usual one.
        cut: whether bodies are cut open along their mid plane.
        video: whether a film is drawn.
        seconds: length of the film; None: the usual one.
        turn_deg: angle by which the film's camera turns.
    """

    colour_by: Colour | None = None
    cut: bool = False
    video: bool = True
    seconds: float | None = None
    turn_deg: float = 30.0


def drawer(pictures: str) -> ModuleType | None:
    """Import the file that draws a result, with the libraries that it draws by.

    Args:
        pictures: of the experiment.

    Returns:
        The file; None where shapes of one finger are drawn.
    """
    return importlib.import_module(DRAWERS[pictures]) if pictures in DRAWERS else None
