"""Numbers as a reader sees them.

>>> with_error(11.1234, 0.0973, "N"), with_error(1234.0, 56.0), with_error(2.0, 0.0)
('11.123 ± 0.097 N', '1234 ± 56', '2 ± 0')
>>> said(1234.5), said(0.01234), said(-0.0), said(12.3, "°"), said(60.0, "kPa")
('1234', '0.0123', '0', '12.3°', '60 kPa')
"""

from __future__ import annotations

import math


def said(value: float | None, unit: str = "") -> str:
    """Three or four digits with the unit; "–" if it is not a number.

    Args:
        value: number; None: it is not known.
        unit: as printed.

    Returns:
        Text such as ``12.3 kPa``.
    """
    if value is None or not math.isfinite(value):
        return "–"
    size = abs(value)
    if size >= 100:
        text = f"{value:.0f}"
    elif size >= 10:
        text = f"{value:z.1f}".removesuffix(".0")
    else:
        text = f"{value:z.3g}"
    return joined(text, unit)


def with_error(value: float, error: float, unit: str = "") -> str:
    """A number and its error of two digits, both with as many decimals, and the unit.

    Args:
        value: number.
        error: in the same unit.
        unit: as printed.

    Returns:
        Text such as ``11.123 ± 0.097 N``.
    """
    if not (math.isfinite(value) and math.isfinite(error)) or error <= 0:
        return said(value) + f" ± {said(error, unit)}"
    decimals = max(1 - math.floor(math.log10(error)), 0)
    return f"{value:z.{decimals}f} ± " + joined(f"{error:.{decimals}f}", unit)


def joined(text: str, unit: str) -> str:
    """A number with its unit; a degree sign follows it at once."""
    if unit in ("", "–"):
        return text
    return text + unit if unit == "°" else f"{text} {unit}"
