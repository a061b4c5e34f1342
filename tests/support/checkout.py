"""Tests that read the checkout's own sources, of which an installed package has none beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).resolve().parents[2]

needs_checkout: Final = pytest.mark.skipif(not (ROOT / "dolfingrip").is_dir(), reason="no checkout")
