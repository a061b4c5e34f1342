"""Priors of an effect for a material of any stiffness."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from dolfingrip.extensions.effect import Effect, Prior

PRINTED_MPa: Final = 2.93
"""Shear modulus of printed NinjaFlex; the effects' priors of moduli are valid for it."""


def scaled_priors(effect: type[Effect], shear_MPa: float) -> dict[str, Prior]:
    """Prior of each parameter that has one; priors of moduli are in proportion to the material's.

    Args:
        effect: an effect of the index.
        shear_MPa: the material's initial shear modulus.
    """
    factor = shear_MPa / PRINTED_MPa
    return {
        key: replace(prior, mean=factor * prior.mean, spread=factor * prior.spread)
        if effect.is_modulus(key)
        else prior
        for key, prior in effect.priors().items()
    }
