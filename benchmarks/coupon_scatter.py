"""How well a coupon's force is foretold without a model: by the mean of the other specimens.

    scripts/run python -m benchmarks.coupon_scatter

No model does better on a specimen that was left out, unless its scale is known.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.selection import selected

FILE = Path(__file__).resolve().parents[1] / "examples/coupons/ninjaflex_uniaxial.csv"


def main() -> None:
    """Print root mean squares, as configured for a diagnosis (2 to 50 % strain)."""
    measurement, _ = selected(read([FILE]), Config())
    area_mm2 = measurement.tests[0].setup.applied(Config()).coupon.area_mm2
    rows = measurement.readings.dropna(subset=["force_N"])
    plain, scaled = [], []
    for name in dict.fromkeys(rows["specimen"]):
        own = rows[rows["specimen"] == name]
        others = [
            np.interp(own["displacement_mm"], part["displacement_mm"], part["force_N"])
            for other, part in rows.groupby("specimen")
            if other != name
        ]
        mean_N, force_N = np.mean(others, axis=0), own["force_N"].to_numpy()
        factor = float(mean_N @ force_N) / float(mean_N @ mean_N)
        plain.append(np.mean((mean_N - force_N) ** 2))
        scaled.append(np.mean((factor * mean_N - force_N) ** 2))
    for what, squares in (("mean of the others", plain), ("its scale fitted", scaled)):
        print(f"{what}: {np.sqrt(np.mean(squares)) / area_mm2:.3f} MPa")


if __name__ == "__main__":
    main()
