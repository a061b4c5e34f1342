"""The part of a configuration that results depend on, so that equal results have equal keys."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from dolfingrip.config import ConfigError

EFFORT = ("time_limit_s", "linear", "memory_GB")
"""Keys of the section ``solver`` that say how a solution is found and what that may take."""

LATER_SWITCHES = {"mesh": {"both_sides": False}, "experiment": {"snaps": True}}
"""Keys that are newer than stored results, by section. They count only where they differ from these
values, so that older results are still found."""

LATER_SECTIONS = ("adopted", "cavity", "form", "round_bellows")
"""Sections that are newer than stored results. They count only if they are not empty."""


def decisive(config: dict[str, Any], digest: str | None) -> dict[str, Any]:
    """The part of a configuration that a result depends on; its mesh file has this digest."""
    solver = {name: value for name, value in config["solver"].items() if name not in EFFORT}
    older = {
        name: section for name, section in config.items() if section or name not in LATER_SECTIONS
    }
    for name, switches in LATER_SWITCHES.items():
        older[name] = {
            key: value
            for key, value in config[name].items()
            if key not in switches or value != switches[key]
        }
    older["mesh"]["file"] = digest
    return {**older, "solver": solver}


def digest_of(file: Path | None) -> str | None:
    """Digest of a mesh file's content, which its place does not change.

    Raises:
        ConfigError: one line, if the file cannot be read.
    """
    if file is None:
        return None
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise ConfigError(f"mesh.file = {file}: {error.strerror}") from None
