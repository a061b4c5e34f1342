"""A body that is stiffer in some places than in others."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, Setup, Site
from dolfingrip.sections.section import FINGERS, Ratio

Mode = Annotated[Ratio, Prior(0.0, 0.15, "engineering guess: a quarter, up to a half, in a place")]
SHOWN = 0.5
"""Part of the largest change from which on a place is told."""


class UnevenStiffness(Effect):
    """A body that is stiffer in some places than in others.

    ln m = Σ_k a_k cos kπs + (1 − 2h) Σ_k b_k cos kπs, s from clamp (0) to tip (1), h from the base
    layer (0) to the top of the bellows (1): m multiplies all moduli. Such are layers that were
    printed too hot or too cold, a stiff ply on a part of the base, or walls that are thicker in
    places. A diagnosis takes its change as linear in a_k and b_k, by their slopes at 0.

    Prior: 0 ± 0.15 each: the stiffness of a place differs by a quarter, and seldom by a half, from
    the mean (engineering guess).
    Fingerprint: with the defaults, stiffer towards the clamp, angle and force rise by nearly one
    factor at all pressures, 1.4 and 2.5 %; a base that is stiffer towards the tip lets the angle
    fall and the force as it is. Loading and unloading agree.
    Confused with: the angle's gain and definition, the base layer's thickness.
    """

    kind: ClassVar = "elastic"
    felt_by: ClassVar = FINGERS
    neutral: ClassVar = dict.fromkeys(("a_1", "a_2", "b_0", "b_1", "b_2"), 0.0)

    a_1: Mode = Field(0.15, ge=-2, le=2, description="above 0 stiffer towards the clamp")
    a_2: Mode = Field(0.0, ge=-2, le=2, description="above 0 softer in the middle of its length")
    b_0: Mode = Field(0.0, ge=-2, le=2, description="above 0 stiffer towards the base layer")
    b_1: Mode = Field(0.0, ge=-2, le=2, description="of the base layer, towards the clamp")
    b_2: Mode = Field(0.0, ge=-2, le=2, description="of the base layer, at clamp and tip")

    def moduli(self, site: Site) -> Expr:
        x = ufl.SpatialCoordinate(site.domain.mesh)
        h, s = (self._part(x[axis], site.extent(axis)) for axis in (0, 2))
        waves = [ufl.cos(k * ufl.pi * s) for k in range(3)]
        c = {key: site.constant(self, key) for key in type(self).model_fields}
        return ufl.exp(_logarithm(c, waves, h))

    @staticmethod
    def _part(x: Expr, extent: Expr) -> Expr:
        return (x - extent[0]) / (extent[1] - extent[0])

    def words(self, config: Setup) -> str:
        """Tell where it is stiffest or softest, and in which part of the section."""
        s = np.linspace(0, 1, 91)
        waves = [np.cos(k * np.pi * s) for k in range(3)]
        c = {key: getattr(self, key) for key in type(self).model_fields}
        sides = {side: _logarithm(c, waves, h) for side, h in (("base", 0.0), ("bellows", 1.0))}
        side, most = max(sides.items(), key=lambda pair: np.abs(pair[1]).max())
        at = int(np.abs(most).argmax())
        if not most[at]:
            return super().words(config)
        places = np.flatnonzero(most / most[at] >= SHOWN)
        runs = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
        (span,) = (run for run in runs if at in run)
        low, high = config.geometry.length_mm * s[span[[0, -1]]]
        other = sides["bellows" if side == "base" else "base"][at] / most[at]
        whose = "the finger" if other >= SHOWN else f"the side of the {side}"
        way = "stiffer" if most[at] > 0 else "softer"
        percent = 100 * math.expm1(abs(float(most[at])))
        return (
            f"{whose} is {way} somewhere between {low:.0f} and {high:.0f} mm from the "
            f"clamp, by up to {percent:.2g} %"
        )


def _logarithm(c: Mapping[str, Any], waves: Sequence[Any], h: Any) -> Any:
    """ln m from the modes' amplitudes and cos kπs."""
    along = sum(c[f"a_{k}"] * waves[k] for k in (1, 2))
    across = sum(c[f"b_{k}"] * waves[k] for k in (0, 1, 2))
    return along + (1 - 2 * h) * across
