"""Probabilities, sections and tables as text, alike on all pages."""

from __future__ import annotations

from collections.abc import Iterable


def chance(p: float) -> str:
    """A probability in two digits."""
    return f"{p:.2f}" if p < 0.995 else "> 0.99"


def section(title: str, lines: Iterable[str]) -> list[str]:
    """Lines below a heading."""
    return ["", f"## {title}", "", *lines]


def table(columns: str, rows: Iterable[str]) -> list[str]:
    """Lines of a table; its columns and each row are told as ``| cell | cell |``."""
    return [columns, "|" + "---|" * (columns.count("|") - 1), *rows]
