"""Angle and force against pressure as a table for the console."""

from __future__ import annotations

from collections import Counter

import numpy as np
from rich.table import Table

from dolfingrip.report.columns import Columns, branches, numbers, required

Key = tuple[float, str, int]

_BENDING = (
    ("angle_deg", "Angle (°)", ".1f"),
    ("chord_angle_deg", "Chord angle (°)", ".1f"),
    ("tip_x_mm", "Tip x (mm)", ".2f"),
    ("tip_z_mm", "Tip z (mm)", ".2f"),
)
_BLOCKED = (("force_N", "Blocked force (N)", ".3f"),)


def tabulate(
    bending: Columns | None = None,
    blocked_force: Columns | None = None,
    *,
    title: str | None = None,
) -> Table:
    """Angle, tip displacement and blocked force against pressure.

    Args:
        bending: Columns ``pressure_kPa`` (kPa) and any of ``angle_deg``, ``chord_angle_deg`` (°),
            ``tip_x_mm``, ``tip_z_mm`` (mm), ``branch``.
        blocked_force: Columns ``pressure_kPa`` (kPa) and ``force_N`` (N), ``branch``.
        title: Set above the table.

    Returns:
        A table with one row per pressure and branch in either result, in their order; a dash where
        one of them has no value. The branch has a column only where pressure also falls.

    Raises:
        ValueError: One line where neither result is given or a result has no ``pressure_kPa``.
    """
    rows: dict[Key, dict[str, str]] = {}
    headings: list[str] = []
    for result, columns in ((bending, _BENDING), (blocked_force, _BLOCKED)):
        if result is None:
            continue
        keys = _keys(result)
        for key in keys:
            rows.setdefault(key, {})
        for name, heading, form in columns:
            values = numbers(result, name)
            if values is None:
                continue
            headings.append(heading)
            for key, value in zip(keys, values, strict=True):
                if np.isfinite(value):
                    rows[key][heading] = _format(float(value), form)
    if not headings:
        raise ValueError("results: no angle and no force to tabulate")
    with_branch = len({branch for _, branch, _ in rows}) > 1
    table = Table(title=title)
    table.add_column("Pressure (kPa)", justify="right")
    if with_branch:
        table.add_column("Branch")
    for heading in headings:
        table.add_column(heading, justify="right")
    for (pressure, branch, _), cells in rows.items():
        lead = [f"{pressure:g}", branch] if with_branch else [f"{pressure:g}"]
        table.add_row(*lead, *(cells.get(heading, "–") for heading in headings))
    return table


def tabulate_coupon(coupon: Columns, *, title: str | None = None) -> Table:
    """Strain, stress and force of a coupon, one row a reading, as in ``result.csv``."""
    table = Table(title=title)
    columns = (
        ("time_s", "Time (s)", ".1f"),
        ("displacement_mm", "Travel (mm)", ".2f"),
        ("nominal_strain", "Nominal strain (–)", ".3f"),
        ("nominal_stress_MPa", "Nominal stress (MPa)", ".3f"),
        ("force_N", "Force (N)", ".2f"),
    )
    table.add_column("Branch")
    for _, heading, _ in columns:
        table.add_column(heading, justify="right")
    values = [required(coupon, name) for name, _, _ in columns]
    for i, branch in enumerate(branches(coupon)):
        cells = (
            _format(float(v[i]), form) for v, (_, _, form) in zip(values, columns, strict=True)
        )
        table.add_row(str(branch), *cells)
    return table


def _format(value: float, form: str) -> str:
    text = format(value, form)
    return text.lstrip("-") if float(text) == 0 else text  # no "-0.00"


def _keys(result: Columns) -> list[Key]:
    """Pressure, branch and how often both were there before: what rows of two results share."""
    seen: Counter[tuple[float, str]] = Counter()
    keys = []
    for pressure, branch in zip(required(result, "pressure_kPa"), branches(result), strict=True):
        pair = (round(float(pressure), 3), str(branch))
        keys.append((*pair, seen[pair]))
        seen[pair] += 1
    return keys
