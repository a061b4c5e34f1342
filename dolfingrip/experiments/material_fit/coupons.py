"""Measured coupons: nominal stress against stretch, from CSV and TOML."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, get_args

import numpy as np
import pandas as pd

from dolfingrip.channels import DISPLACEMENT, FORCE
from dolfingrip.config import ConfigError
from dolfingrip.experiments.material_fit.first_loading import first_loading, is_hollow, pressed
from dolfingrip.experiments.material_fit.law import EXPONENTS, Mode
from dolfingrip.sections import tables

STRAIN: Final = "strain"
"""Column of nominal strains."""

STRESS: Final = "stress_MPa"
"""Column of nominal stresses."""

STRETCHES: Final = (DISPLACEMENT.name, STRAIN, "stretch")
"""Columns that tell how far a coupon is pulled; a table has one of them."""

STRESSES: Final = (FORCE.name, STRESS)
"""Columns that tell what it resists; a table has one of them."""

MODES: tuple[Mode, ...] = get_args(Mode)

COMPRESSION: Final = "compression"
"""Mode of a table of a press, which is uniaxial; either sign of its travel and its load will do."""


@dataclass(frozen=True, slots=True)
class CouponSeries:
    """One specimen in one mode of tension.

    Attributes:
        name: name of its file and specimen.
        mode: mode of tension.
        stretch: (n,) stretches.
        stress_MPa: (n,) nominal stresses.
        noise_MPa: standard deviation of a reading's stress, with the contribution of the
            displacement's noise; None if the file does not tell any.
        left_out: number of its readings that are not of the first loading.
    """

    name: str
    mode: Mode
    stretch: np.ndarray
    stress_MPa: np.ndarray
    noise_MPa: float | None
    left_out: int = 0


def farthest(data: Iterable[CouponSeries]) -> float:
    """Return the largest principal stretch of some specimens; of a pressed one it is lateral.

    Args:
        data: one series for each specimen.
    """
    return max(float((series.stretch ** EXPONENTS[series.mode][:, None]).max()) for series in data)


def reach(data: Iterable[CouponSeries]) -> str:
    """Return the measured stretches of some specimens in words.

    Args:
        data: one series for each specimen.
    """
    stretch = np.concatenate([series.stretch for series in data])
    pressed_by, pulled_by = 1 - stretch.min(), stretch.max() - 1
    ends = [1 - pressed_by] if pressed_by > 0.1 * pulled_by else []
    ends += [1 + pulled_by] if pulled_by > 0.1 * pressed_by else []
    return f"to a stretch of {' and of '.join(f'{end:.3g}' for end in ends)}"


def read(file: Path, max_stretch: float | None = None) -> list[CouponSeries]:
    """The specimens of a table in the format of measured data.

    The columns are ``displacement_mm`` and ``force_N``, for which the TOML file of the same stem
    gives ``gauge_length_mm`` and ``area_mm2`` (or ``width_mm`` and ``thickness_mm``), at its top or
    in ``[coupon]``. Or they are nominal: ``strain`` or ``stretch``, and ``stress_MPa``. ``mode``
    stands in the TOML file or is a column of the table. A nominal table needs no TOML file. Only
    readings of the first loading are used; where no column ``branch`` tells them, they are found.
    Where no ``mode`` is told, a curve that no rubber has in tension is refused.

    Args:
        file: CSV file.
        max_stretch: readings at larger stretches are left out.

    Raises:
        ConfigError: one line naming the file, what is wrong and what is allowed.
    """
    table = _table(file)
    nominal = DISPLACEMENT.name not in table and FORCE.name not in table
    setup = {} if nominal and not file.with_suffix(".toml").exists() else _setup(file)
    for column, first in (("experiment", "coupon"), ("cycle", 1), ("branch", "loading")):
        if column in table:
            table = table[table[column].isna() | (table[column] == first)]
    length = _number(file, setup, "gauge_length_mm") if DISPLACEMENT.name in table else 1.0
    area = _area_mm2(file, setup) if FORCE.name in table else 1.0
    if DISPLACEMENT.name in table:
        table["stretch"] = 1 + table[DISPLACEMENT.name] / length
    elif STRAIN in table:
        table["stretch"] = 1 + table[STRAIN]
    if FORCE.name in table:
        table[STRESS] = table[FORCE.name] / area
    mode_told = "mode" in table or "mode" in setup
    if "mode" not in table:
        table["mode"] = setup.get("mode", "uniaxial")
    if "specimen" not in table:
        table["specimen"] = ""
    specimens = []
    for (mode, specimen), rows in table.groupby(["mode", "specimen"], sort=False, dropna=False):
        if mode not in (*MODES, COMPRESSION):
            every = ", ".join((*MODES, COMPRESSION))
            raise ConfigError(f"--fit {file}: mode = {mode}: allowed: {every}")
        stretch, stress = rows["stretch"].to_numpy(), rows[STRESS].to_numpy()
        if mode == COMPRESSION:
            mode, stretch, stress = MODES[0], 1 + pressed(stretch - 1), pressed(stress)
        keep = first_loading(
            stretch, stress, labelled="branch" in rows and rows["branch"].notna().any()
        )
        left_out = int((~keep).sum())
        keep &= (stretch > 0) & (stretch <= (max_stretch or np.inf))
        stretch, stress = stretch[keep], stress[keep]
        if not mode_told and stretch.min(initial=1) >= 1 and is_hollow(stretch - 1, stress):
            raise ConfigError(
                f"--fit {file}: its tangent rises from the start, as that of rubber does in "
                f'compression and in no tension; allowed: mode = "{COMPRESSION}" or '
                f'mode = "{MODES[0]}" in {file.stem}.toml'
            )
        noise = _noise(setup, area, length, stretch, stress)
        name = f"{file.stem} {specimen}".strip()
        specimens.append(CouponSeries(name, mode, stretch, stress, noise, left_out))
    specimens = [series for series in specimens if len(series.stretch)]
    if sum(len(series.stretch) for series in specimens) < 3:
        raise ConfigError(f"--fit {file}: allowed: at least 3 readings of the first loading")
    return specimens


def _table(file: Path) -> pd.DataFrame:
    text = tables.text_of(file, "--fit")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    tables.check_separator(f"--fit {file}", "".join(lines[:1]))
    try:
        table = pd.read_csv(io.StringIO(text), comment="#")
    except ValueError as error:
        raise ConfigError(f"--fit {file}: no table: {str(error).splitlines()[0]}") from None
    used = []
    for columns in (STRETCHES, STRESSES):
        present = [column for column in columns if column in table]
        if len(present) != 1:
            has = f"columns {' and '.join(present)}" if present else "missing column"
            raise ConfigError(f"--fit {file}: {has}; allowed: one of {', '.join(columns)}")
        if not pd.api.types.is_numeric_dtype(table[present[0]]):
            raise ConfigError(f"--fit {file}: column {present[0]}: allowed: numbers")
        used += present
    return table.dropna(subset=used)


def _setup(file: Path) -> dict[str, Any]:
    data = tables.whole(file.with_suffix(".toml"), f"--fit {file}:")
    return {**data, **data.get("coupon", {})}


def _area_mm2(file: Path, setup: Mapping[str, Any]) -> float:
    if "area_mm2" in setup:
        return _number(file, setup, "area_mm2")
    return _number(file, setup, "width_mm") * _number(file, setup, "thickness_mm")


def _number(file: Path, setup: Mapping[str, Any], key: str) -> float:
    value = setup.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or value <= 0:
        raise ConfigError(
            f"--fit {file}: {file.stem}.toml: {key} = {value}: allowed: above 0 "
            f"{key.rpartition('_')[2]}"
        )
    return float(value)


def _noise(
    setup: Mapping[str, Any],
    area_mm2: float,
    length_mm: float,
    stretch: np.ndarray,
    stress: np.ndarray,
) -> float | None:
    noise = setup.get("noise", {})
    force_N = [float(noise[column]) for column in STRESSES if column in noise]
    if not force_N:
        return None
    steepness = 0.0
    if len(stretch) > 2 and np.ptp(stretch) > 0:
        steepness = abs(float(np.polyfit(stretch, stress, 1)[0]))
    travels = [float(noise[column]) for column in STRETCHES if column in noise]
    return float(np.hypot(force_N[0] / area_mm2, steepness * sum(travels[:1]) / length_mm))
