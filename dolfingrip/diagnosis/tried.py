"""Which effects may be named as causes."""

from __future__ import annotations

from collections.abc import Sequence

from dolfingrip.config import ConfigError
from dolfingrip.extensions.index import NAMES, effect


def tried(names: Sequence[str] | None) -> list[str]:
    """Names of the effects that are tried: the catalogue, or these, without nuisances."""
    every = NAMES if names is None else names
    return [name for name in every if not effect(name).nuisance]


def check_effects(names: Sequence[str] | None) -> None:
    """Refuse names that are of no effect that may be named.

    Raises:
        ConfigError: one line with the name and what is allowed.
    """
    for name in names or ():
        if name not in tried(None):
            raise ConfigError(f"--effects {name}: allowed: {', '.join(tried(None))}")
