"""What the significance table says, in sentences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from dolfingrip.channels import CHANNELS
from dolfingrip.sections.units import unit

LEVEL = 0.05
"""Corrected p below which a difference is said to be there."""

WAYS = {"loading": "on loading", "unloading": "on unloading", "hold": "on hold"}
"""Branches in the order in which they are told."""


@dataclass(frozen=True)
class Deviation:
    """How far the simulation is off in one group: 1 high, −1 low, 0 right within its error."""

    sign: int
    percent: float
    percent_error: float
    amount: float
    amount_error: float
    count: int


def name_of(channel: str) -> str:
    """A channel in words."""
    return CHANNELS[channel].title.lower()


def sentences(table: pd.DataFrame, level: float = LEVEL, band_unit: str = "kPa") -> list[str]:
    """What is high, low or right, channel by channel.

    Args:
        table: as :func:`~dolfingrip.diagnosis.inference.significance.significance_table` gives it.
        level: corrected p below which something is said to be off.
        band_unit: of the bands, "mm of travel" where these are of a coupon's.

    Returns:
        Sentences by pressure and branch, then those by cycle, rate and specimen where these differ.
    """
    found: list[str] = []
    for channel in dict.fromkeys(table["channel"]):
        rows = table[table["channel"] == channel]
        found += _by_pressure(channel, rows, level, band_unit)
        for by, words in (
            ("cycle", "in cycle {:g}"),
            ("rate_kPa_per_s", "at {:g} kPa/s"),
            ("specimen", "on specimen {}"),
        ):
            found += _by_group(channel, rows[rows["by"] == by], by, words, level)
    return found


def _by_pressure(channel: str, rows: pd.DataFrame, level: float, band_unit: str) -> list[str]:
    """One sentence for each stretch of pressure over which the picture is the same."""
    bands = rows[rows["by"] == "pressure and branch"]
    if bands.empty:
        rows = rows[rows["by"] == "all"]
        states = [_deviation(row, level) for _, row in rows.iterrows()]
        return [f"the simulated {name_of(channel)} is {_words(states[0], channel)}"]
    stretches: list[tuple[float, float, dict[str, Deviation]]] = []
    for (low, high), band in bands.groupby(["low_kPa", "high_kPa"], sort=True):
        state = {row["branch"]: _deviation(row, level) for _, row in band.iterrows()}
        if stretches and _alike(stretches[-1][2], state):
            start, _, before = stretches.pop()
            low, state = start, {name: _pooled(before[name], state[name]) for name in state}
        stretches.append((float(low), float(high), state))
    if len(stretches) == 1:
        return [f"the simulated {name_of(channel)} is {_across(stretches[0][2], channel)}"]
    return [
        f"{_stretch(low, high, stretches, band_unit)} the simulated {name_of(channel)} is "
        f"{_across(state, channel)}"
        for low, high, state in stretches
    ]


def _by_group(channel: str, rows: pd.DataFrame, by: str, words: str, level: float) -> list[str]:
    states = [(row[by], _deviation(row, level)) for _, row in rows.iterrows()]
    if len({state.sign for _, state in states}) < 2:
        return []  # they do not differ, or only in size
    parts = [f"{_words(state, channel)} {words.format(value)}" for value, state in states]
    return [f"the simulated {name_of(channel)} is {_joined(parts)}"]


def _deviation(row: pd.Series, level: float) -> Deviation:
    off = row["p_corrected"] < level
    amount = float(row["simulated_minus_measured"])
    return Deviation(
        sign=(1 if amount > 0 else -1) if off else 0,
        percent=float(row["percent"]),
        percent_error=float(row["percent_error"]),
        amount=amount,
        amount_error=float(row["std_error"]),
        count=int(row["count"]),
    )


def _alike(one: dict[str, Deviation], other: dict[str, Deviation]) -> bool:
    return one.keys() == other.keys() and all(one[k].sign == other[k].sign for k in one)


def _pooled(one: Deviation, other: Deviation) -> Deviation:
    """Both stretches together; errors as if they had them in common."""
    total = one.count + other.count
    a, b = one.count / total, other.count / total
    return Deviation(
        sign=one.sign,
        percent=a * one.percent + b * other.percent,
        percent_error=a * one.percent_error + b * other.percent_error,
        amount=a * one.amount + b * other.amount,
        amount_error=a * one.amount_error + b * other.amount_error,
        count=total,
    )


def _across(state: dict[str, Deviation], channel: str) -> str:
    """All branches of one stretch."""
    ordered = sorted(state, key=lambda name: list(WAYS).index(name) if name in WAYS else 99)
    if len(ordered) == 1 or (
        len({state[k].sign for k in ordered}) == 1 and not state[ordered[0]].sign
    ):
        pooled = state[ordered[0]]
        for name in ordered[1:]:
            pooled = _pooled(pooled, state[name])
        return _words(pooled, channel)
    return _joined([f"{_words(state[k], channel)} {WAYS.get(k, f'on {k}')}" for k in ordered])


def _words(state: Deviation, channel: str) -> str:
    known = math.isfinite(state.percent)
    suffix = f" {unit(channel)}".rstrip() if unit(channel) != "deg" else "°"
    if state.sign == 0:
        error = (
            f"{2 * state.percent_error:.2g} %" if known else f"{2 * state.amount_error:.2g}{suffix}"
        )
        return f"right (within {error})"
    size = f"{abs(state.percent):.2g} %" if known else f"{abs(state.amount):.2g}{suffix}"
    return f"{size} {'high' if state.sign > 0 else 'low'}"


def _stretch(
    low: float,
    high: float,
    stretches: Sequence[tuple[float, float, dict[str, Deviation]]],
    band_unit: str,
) -> str:
    if low == stretches[0][0]:
        return f"up to {high:g} {band_unit}"
    if high == stretches[-1][1]:
        return f"above {low:g} {band_unit}"
    return f"from {low:g} to {high:g} {band_unit}"


def _joined(parts: Sequence[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
