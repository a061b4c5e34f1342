"""Moduli of hidden causes, which follow the hidden modulus of the material."""

from __future__ import annotations

from dolfingrip.config import Change
from dolfingrip.extensions.index import effect


def stiffened(causes: Change, modulus: float) -> Change:
    """Return the change to causes whose moduli follow the material's factor."""
    changes = {}
    for key, value in causes.items():
        _, name, number = key.split(".")
        by = modulus if effect(name).is_modulus(number) else 1.0
        changes[key] = [by * entry for entry in value] if isinstance(value, list) else by * value
    return changes
