"""Many looks at the same data: p-values corrected for their number."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dolfingrip.diagnosis.inference.arrays import Vector


def holm(p_values: npt.ArrayLike) -> Vector:
    """Corrected p-values: P(any is below α by chance) ≤ α, however the looks depend on another.

    Holm 1979, Scand. J. Stat. 6:65.
    """
    p = np.asarray(p_values, dtype=float)
    order = np.argsort(p)
    corrected = np.empty_like(p)
    corrected[order] = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    return np.minimum(corrected, 1.0)
