"""Tests that read the checkout's own sources, of which an installed package has none beside it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).resolve().parents[2]

needs_checkout: Final = pytest.mark.skipif(not (ROOT / "dolfingrip").is_dir(), reason="no checkout")


def sources() -> Iterator[tuple[str, str]]:
    """Names and texts of the package's Python files, in order."""
    for folder in ("dolfingrip", "forms", "meshes"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            yield file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8")
