"""``extended.toml``: the configuration with the cause at its fitted parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.evidence import INTERVAL
from dolfingrip.diagnosis.inference.laplace import Estimate
from dolfingrip.diagnosis.model import SCALE
from dolfingrip.diagnosis.simulation.nuisances import WALL, modulus_keys
from dolfingrip.parameter import find, scaled


def extended(config: Config, fit: Hypothesis) -> Config:
    """The configuration at a fit: modulus and the effects' parameters.

    The laboratory's set-up (gap, weight, coupon) stays out: it is no property of the finger. The
    contacts' stiffness, which a change of the modulus carries with it, is as configured.
    """
    factor = fit.by_key.get(SCALE, 1.0)
    own = [text for text in fit.overrides if text.startswith("extensions.") or text in CHOICES]
    return config.overridden([*scaled(config, factor), *own])


CHOICES = ("contact.self_contact=true", 'solver.element="P2"')
"""Overrides of a reversed choice of the model, which is no extension."""


def parameters(
    config: Config, fit: Hypothesis, estimates: Sequence[Estimate], area_spread: float = 0.0
) -> list[tuple[str, Estimate]]:
    """Fitted numbers by key of the configuration, moduli at the fitted modulus; no walls.

    The walls are a nuisance of one print.

    Args:
        config: that was diagnosed.
        fit: whose numbers these are.
        estimates: of its parameters.
        area_spread: relative standard deviation of the cross-section where coupons alone tell the
            modulus; it widens that one's interval.
    """
    factor = fit.by_key.get(SCALE, 1.0)
    found = []
    for parameter, estimate in zip(fit.parameters, estimates, strict=True):
        if parameter.key == SCALE:
            wider = _widened(estimate, area_spread)
            # a film's stiffness goes along, but the modulus' interval is none of its own
            keys = [key for key in modulus_keys(config) if key.startswith("material.")]
            own = find(config, keys)
            found += [(each.key, _times(wider, each.value(config))) for each in own]
        elif parameter.key != WALL:
            found.append((parameter.key, _times(estimate, factor if parameter.is_modulus else 1)))
    return found


def write(
    file: Path,
    config: Config,
    fit: Hypothesis,
    numbers: Sequence[tuple[str, Estimate]],
    verdict: str,
) -> None:
    """Write the configuration, the verdict and the intervals as comments before it."""
    lines = [f"# dolfingrip diagnose: {verdict}", "# fitted, with 90 % intervals:"]
    for key, estimate in numbers:
        lines.append(f"# {key} = {estimate.value:.4g} ({estimate.low:.4g} to {estimate.high:.4g})")
    text = "\n".join(lines) + "\n" + configuration.dumps(extended(config, fit))
    partial = file.with_suffix(".part")
    partial.write_text(text, encoding="utf-8")
    partial.replace(file)


def _times(estimate: Estimate, factor: float) -> Estimate:
    return Estimate(
        estimate.value * factor, estimate.low * factor, estimate.high * factor,
        estimate.std_by_prior,
    )  # fmt: skip


def _widened(estimate: Estimate, spread: float) -> Estimate:
    """With a factor of this relative standard deviation that the readings do not tell."""
    if not spread:
        return estimate
    low, high = (
        math.exp(way * math.hypot(math.log(end / estimate.value), INTERVAL * spread))
        for way, end in ((-1, estimate.low), (1, estimate.high))
    )
    return Estimate(
        estimate.value, estimate.value * low, estimate.value * high, estimate.std_by_prior
    )
