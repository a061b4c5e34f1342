"""The uncertainty that a fit to measurements left: equally good parameters, unexplained scatter.

>>> posterior = Posterior.model_validate(
...     {"model_kPa": 0.5, "fit": [{"set": {"film.silk.Et_N_per_mm": 3.0}}, {"weight": 3.0}]}
... )
>>> [float(share) for share in posterior.shares]
[0.25, 0.75]
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from dolfingrip.channels import ANGLE, CHORD_ANGLE, readings
from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError, checked
from dolfingrip.sections.section import Numbers, Refusal, Section

Fits = Annotated[tuple["WeightedFit", ...], Field(strict=False, min_length=1)]


class WeightedFit(Section):
    """One set of parameters that agrees with the measurements.

    The error of its material law is a factor on the pressure that depends on the growth of the
    cavity, because chambers of one size that have grown alike are stretched alike.
    """

    weight: float = Field(1.0, ge=1e-30, description="probability, relative to the other fits'")
    set: Mapping[str, Any] = Field({}, description="values by key of the configuration")
    growth: Numbers = Field((), description="cavity's volume by that at rest, rising")
    factor: Numbers = Field((), description="measured pressure by the simulated one there")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if len(self.factor) != len(self.growth) or list(self.growth) != sorted(self.growth):
            yield Refusal("growth", "allowed: rising, as many numbers as factor has")

    def correction(self, growth: np.ndarray) -> np.ndarray:
        """Factor on the pressure, (n,), extrapolated beyond the table from its last rows."""
        if not self.growth:
            return np.ones_like(growth)
        factor = np.interp(growth, self.growth, self.factor)
        if len(self.growth) > 1:
            rise = (self.factor[-1] - self.factor[-2]) / (self.growth[-1] - self.growth[-2])
            factor = factor + max(rise, 0.0) * np.maximum(growth - self.growth[-1], 0.0)
        return np.asarray(factor)


class PosteriorTable(Section):
    """Fits, and the deviations from the best fit as pressures at an equal angle."""

    reading: str = Field(CHORD_ANGLE.name, description="that was fitted, and is predicted")
    model_kPa: float = Field(0.0, ge=0, description="what fits leave: pressure at an equal angle")
    specimen: float = Field(0.0, ge=0, le=1, description="one specimen's pressure from another's")
    angle: float = Field(0.0, ge=0, le=1, description="what fits leave: relative, of the angle")
    reading_deg: float = Field(0.0, ge=0, description="noise of the reading")
    fit: Fits = Field(description="fits")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        angles = [reading.name for reading in readings("finger") if reading.unit == ANGLE.unit]
        if self.reading not in angles:
            yield Refusal("reading", f"allowed: {', '.join(angles)}")

    @property
    def shares(self) -> np.ndarray:
        """Probability of each fit, (fits,)."""
        weights = np.array([fit.weight for fit in self.fit])
        return np.asarray(weights / weights.sum())


def read(file: Path) -> PosteriorTable:
    """Read the table ``posterior`` of a TOML file.

    Args:
        file: TOML.

    Raises:
        ConfigError: one line, if there is no such file or table, or a value is not allowed.
    """
    data = tables.whole(file, "--from")
    if tables.POSTERIOR not in data:
        raise ConfigError(f"--from {file}: no table [posterior]; allowed: one with the fits")
    return checked(PosteriorTable, data[tables.POSTERIOR])
