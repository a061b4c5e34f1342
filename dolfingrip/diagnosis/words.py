"""Probabilities and sections as text, alike on all pages."""

from __future__ import annotations

from collections.abc import Iterable


def chance(p: float) -> str:
    """A probability in two digits."""
    return f"{p:.2f}" if p < 0.995 else "> 0.99"


def section(title: str, lines: Iterable[str]) -> list[str]:
    """Lines below a heading."""
    return ["", f"## {title}", "", *lines]
