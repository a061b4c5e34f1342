"""Experiments: what is built, controlled and read, and the loop that runs them.

The command lists the experiments without a solver. What needs a solver is loaded at first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dolfingrip import loading

if TYPE_CHECKING:
    from dolfingrip.experiments.feedforward import command_for
    from dolfingrip.experiments.loop import run
    from dolfingrip.experiments.protocol import pressures_kPa
    from dolfingrip.experiments.result import Result

__all__ = ["Result", "command_for", "pressures_kPa", "run"]

__getattr__, __dir__ = loading.lazily(
    __name__,
    {"Result": "result", "command_for": "feedforward", "pressures_kPa": "protocol", "run": "loop"},
)
