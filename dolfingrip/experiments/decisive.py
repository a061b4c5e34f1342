"""The part of a configuration that results depend on, so that equal results have equal keys."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from dolfingrip.config import ConfigError

TIME_LIMIT = "time_limit_s"
"""Of the section ``solver``; it may differ from call to call of a campaign."""

LATER_SWITCHES = ("both_sides",)
"""Of the section ``mesh``, newer than stored results: they count where they are on, so that results
from before are still found."""


def decisive(config: dict[str, Any], digest: str | None) -> dict[str, Any]:
    """What a finished result depends on of a configuration, whose mesh file has this digest."""
    # not on the time that it was allowed
    solver = {name: value for name, value in config["solver"].items() if name != TIME_LIMIT}
    mesh = {
        name: value
        for name, value in config["mesh"].items()
        if name not in LATER_SWITCHES or value is not False
    }
    return {**config, "mesh": {**mesh, "file": digest}, "solver": solver}


def digest_of(file: Path | None) -> str | None:
    """A mesh file counts by its content, wherever it lies.

    Raises:
        ConfigError: one line, where it cannot be read.
    """
    if file is None:
        return None
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise ConfigError(f"mesh.file = {file}: {error.strerror}") from None
