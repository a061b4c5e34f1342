"""The registry of files that draw an experiment's result in place of one finger's shapes."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Final

from dolfingrip.report import gripper

DRAWERS: Final[Mapping[str, ModuleType]] = {"gripper": gripper}
"""Files with ``draw`` and ``strip``, by the ``pictures`` of an experiment."""
