"""A compliant clamp."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior, Setup, Site
from dolfingrip.sections.section import FINGERS

if TYPE_CHECKING:
    from dolfinx import fem


class ClampCompliance(Effect):
    """A compliant clamp: a rigid base on springs.

    Π += f·s − c |f|²/2 + m φ − c_φ m²/2: the base's shift s in x and z, its small turn φ about y,
    and the springs' force f and moment m are unknowns. The clamped face moves along,
    u = s + φ e_y × (X − X_c). At c = c_φ = 0 the base stands still.

    Prior: c = 0.01 ± 0.01 mm/N and c_φ = (2 ± 2)e-5 rad/(N mm), a printed bracket (engineering
    guess).
    Fingerprint: force lower by the share that the finger's stiffness at its tip has of the clamp's,
    0.4 to 0.6 %; the angle against the plate lower. Free bending of a weightless finger does not
    feel it.
    Confused with: the sensor's compliance, the plate's gap.
    """

    kind: ClassVar = "set-up"
    felt_by: ClassVar = FINGERS
    neutral: ClassVar = {"compliance_mm_per_N": 0.0, "compliance_rad_per_Nmm": 0.0}

    compliance_mm_per_N: Annotated[float, Prior(0.01, 0.01, "engineering guess", positive=True)] = (
        Field(0.01, ge=0, le=100, description="shift of the base by force")
    )
    compliance_rad_per_Nmm: Annotated[
        float, Prior(2e-5, 2e-5, "engineering guess", positive=True)
    ] = Field(2e-5, ge=0, le=0.1, description="turn of the base by moment")

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        centre = site.centre("clamp")
        size = site.size("clamp")
        shift = site.constant(self, "compliance_mm_per_N")
        turn = site.constant(self, "compliance_rad_per_Nmm")
        springs = []
        for axis in (0, 2):
            name = "xyz"[axis]
            moved = site.unknown(self, f"shift_{name}_mm")
            site.move_clamp(moved, partial(_shifted, axis))
            springs.append(site.spring(self, f"force_{name}_N", moved.constant, shift))
        turned = site.unknown(self, "turn_rad", scale=1 / size)
        site.move_clamp(turned, partial(_turned, centre))
        springs.append(site.spring(self, "moment_Nmm", turned.constant, turn, size))
        return springs

    @classmethod
    def felt_in_bending(cls, config: Setup) -> bool:
        """A weightless finger that bends freely pulls at nothing."""
        return bool(config.gravity.acceleration_m_s2)


def _shifted(axis: int, x: np.ndarray) -> np.ndarray:
    """Displacement (mm) of the base for a shift of 1 mm."""
    shift = np.zeros_like(x)
    shift[axis] = 1.0
    return shift


def _turned(centre: fem.Constant, x: np.ndarray) -> np.ndarray:
    """Displacement of the base by a small turn, for each radian: e_y × (X − X_c)."""
    at = centre.value
    return np.array([x[2] - at[2], np.zeros_like(x[0]), at[0] - x[0]])
