"""A fitted law as a configuration that every command reads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import tomlkit

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.experiments.material_fit.coupons import CouponSeries, farthest
from dolfingrip.experiments.material_fit.fit import LawFit
from dolfingrip.files import whole


def allowed(fit: LawFit) -> bool:
    """Return whether a configuration may hold the values, whose shear modulus must be above 0.

    Args:
        fit: the fitted law.
    """
    try:
        config.from_dict(fit.law.tables(fit.values))
    except ConfigError:
        return False
    return True


def write(fit: LawFit, data: Sequence[CouponSeries], file: Path) -> None:
    """Write the tables of the fitted law; comments tell the data that it was fitted to.

    Args:
        fit: the fitted law.
        data: the coupons' readings.
        file: TOML to write.

    Raises:
        WriteError: one line.
    """
    document = tomlkit.document()
    names = ", ".join(dict.fromkeys(series.name.partition(" ")[0] for series in data))
    modes = ", ".join(dict.fromkeys(series.mode for series in data))
    for line in (
        f"{fit.law.title}, fitted to {names}: {modes} tension, {fit.count} readings",
        f"to a stretch of {farthest(data):.3g}",
        f"rms {fit.rms_MPa:.3g} MPa, {100 * fit.relative_rms:.2g} % of the readings",
        "90 % intervals: "
        + ", ".join(
            f"{key.rpartition('.')[2]} ± {half:.2g}"
            for key, half in zip(fit.law.keys, fit.half_width, strict=True)
        ),
        "A coupon does not tell how compressible the material is: give material.nu or bulk_MPa.",
    ):
        document.add(tomlkit.comment(line))
    values = [float(f"{value:.{fit.policy.digits}g}") for value in fit.values]
    for name, table in fit.law.tables(values).items():
        document.add(name, table)
    whole.write(file, tomlkit.dumps(document))
