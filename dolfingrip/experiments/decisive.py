"""The part of a configuration that results depend on, so that equal results have equal keys."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from dolfingrip.config import ConfigError

EFFORT = ("time_limit_s", "linear", "memory_GB")
"""Keys of the section ``solver`` that say how a solution is found and what that may take."""

LATER_SWITCHES = ("both_sides",)
"""Keys of the section ``mesh`` that are newer than stored results. They count only if they are
switched on, so that older results are still found."""

LATER_SECTIONS = ("adopted", "cavity", "form", "round_bellows")
"""Sections that are newer than stored results. They count only if they are not empty."""


def decisive(config: dict[str, Any], digest: str | None) -> dict[str, Any]:
    """The part of a configuration that a result depends on; its mesh file has this digest."""
    solver = {name: value for name, value in config["solver"].items() if name not in EFFORT}
    mesh = {
        name: value
        for name, value in config["mesh"].items()
        if name not in LATER_SWITCHES or value is not False
    }
    older = {
        name: section for name, section in config.items() if section or name not in LATER_SECTIONS
    }
    return {**older, "mesh": {**mesh, "file": digest}, "solver": solver}


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
