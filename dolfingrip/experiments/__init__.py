"""Experiments: what is built, controlled and read, and the loop that runs them.

The command lists the experiments without a solver. What needs a solver is loaded at first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dolfingrip.experiments.loop import run
    from dolfingrip.experiments.protocol import pressures_kPa
    from dolfingrip.experiments.result import Result

__all__ = ["Result", "pressures_kPa", "run"]

_HOME = {"Result": "result", "pressures_kPa": "protocol", "run": "loop"}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
