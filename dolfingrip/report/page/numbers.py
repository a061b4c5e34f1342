"""Numbers as a reader sees them.

>>> said(1234.5), said(0.01234), said(-0.0), said(12.3, "°"), said(12.3, "kPa")
('1234', '0.0123', '0', '12.3°', '12.3 kPa')
"""

from __future__ import annotations

import math


def said(value: float | None, unit: str = "") -> str:
    """Three or four digits with the unit; "–" if it is not a number."""
    if value is None or not math.isfinite(value):
        return "–"
    size = abs(value)
    if size >= 100:
        text = f"{value:.0f}"
    elif size >= 10:
        text = f"{value:z.1f}"
    else:
        text = f"{value:z.3g}"
    if unit in ("", "–"):
        return text
    return text + unit if unit == "°" else f"{text} {unit}"
