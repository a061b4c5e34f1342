"""At what strength, and in what shapes, each effect of the catalogue is tried.

An effect has an amplitude, the parameters that are ``neutral`` somewhere, and other parameters that
give its fingerprint a shape. The ordinary strength is the prior's mean; where that is neutral, one
spread away. Shape parameters go over the middle of their prior and :data:`APART` spreads to either
side, one parameter at a time.

Tangents at the neutral value mislead, since the fingerprint of a strong effect is another than that
of a weak one; hence changes at an ordinary strength, one more simulation each.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.parameter import bounds_of
from dolfingrip.parameter.priors import scaled_priors

APART: Final = 1.5
"""Spreads of a prior (of its logarithm where it is positive) from the middle to either side."""


@dataclass(frozen=True, slots=True)
class TriedShape:
    """One simulation of an effect.

    Attributes:
        label: values of its parameters, for people.
        overrides: the same as with ``--set``.
        part: strength by the ordinary one, which the change is divided by; below 0 on the other
            side.
        tilt_deg: turn of gravity in the plane of bending, from the direction that each test has.
    """

    label: str
    overrides: tuple[str, ...]
    part: float = 1.0
    tilt_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class TriedEffect:
    """What is tried of an effect.

    Attributes:
        effect: its name.
        kind: as in the catalogue; ``numerical`` ones are choices of the model.
        shapes: simulations.
        spread: root mean square of the strength under the prior, by the ordinary strength.
        one_sided: whether the amplitude cannot lie on the neutral value's other side.
    """

    effect: str
    kind: str
    shapes: tuple[TriedShape, ...]
    spread: float
    one_sided: bool


def ordinary(config: Config) -> list[TriedEffect]:
    """What is tried beside ``config``: the catalogue's effects that are not on there."""
    on = {effect.name() for effect in config.extensions.active()}
    found = []
    for effect in EFFECTS:
        if effect.name() in on or not effect.tried:
            continue
        tilt_deg = effect.tilt_deg(config)
        if effect.kind == "numerical":
            found.append(_choice(effect, config))
        elif tilt_deg is not None:
            found.append(_tilted(effect, tilt_deg))
        else:
            found.append(_by_prior(effect, config.material.shear_MPa))
    return found


def _by_prior(effect: type[Effect], shear_MPa: float) -> TriedEffect:
    priors = scaled_priors(effect, shear_MPa)
    amplitudes = [key for key in effect.neutral if key in priors]
    steps = {key: _step(effect, key, priors[key]) for key in amplitudes}
    middle = {key: _neutral(effect, key) + step for key, step in steps.items()}
    free = [key for key in priors if key not in amplitudes and key not in effect.shapeless]
    held = {
        key: priors[key].at(0.0) if key in free else priors[key].mean
        for key in priors
        if key not in amplitudes
    }
    shapes = [_shape(effect, {**middle, **held})]
    for key in free:
        if key in effect.alike:
            continue
        shapes += [
            _shape(effect, {**middle, **held, key: priors[key].at(way * APART)}) for way in (-1, 1)
        ]
    if len(amplitudes) > 1:  # each by itself, too
        neutral = {key: _neutral(effect, key) for key in amplitudes}
        shapes += [_shape(effect, {**neutral, **held, key: middle[key]}) for key in amplitudes]
    if effect.curved:
        (key,) = amplitudes
        for way in (-1, 1):
            value = priors[key].at(way * APART)
            part = (value - _neutral(effect, key)) / steps[key]
            shapes.append(_shape(effect, {**held, key: value}, part))
    if effect.lopsided:
        for part in (-1.0, 2.0, -2.0):
            there = {key: _neutral(effect, key) + part * steps[key] for key in amplitudes}
            shapes.append(_shape(effect, {**there, **held}, part))
    spread = max(
        math.hypot(priors[key].mean - _neutral(effect, key), priors[key].spread) / abs(steps[key])
        for key in amplitudes
    )
    sides = all(_one_sided(effect, key) for key in amplitudes)
    return TriedEffect(effect.name(), effect.kind, tuple(shapes), spread, sides)


def _choice(effect: type[Effect], config: Config) -> TriedEffect:
    """The other choice: where the configuration has made it already, its reversal."""
    name = effect.name()
    (key,) = effect.neutral
    made = (f"extensions.{name}.{key}=true", f"{key} = true")
    override, label = effect.reversal(config) or made
    return TriedEffect(name, effect.kind, (TriedShape(label, (override,)),), 1.0, True)


def _tilted(effect: type[Effect], tilt_deg: float) -> TriedEffect:
    """A turn of gravity, which needs no other configuration."""
    shape = TriedShape(f"pitch {tilt_deg:+g} deg", (), tilt_deg=tilt_deg)
    return TriedEffect(effect.name(), effect.kind, (shape,), 1.0, False)


def _shape(effect: type[Effect], values: Mapping[str, float], part: float = 1.0) -> TriedShape:
    label = ", ".join(f"{key} = {value:.4g}" for key, value in values.items())
    overrides = tuple(
        f"extensions.{effect.name()}.{key}={_toml(effect, key, value)}"
        for key, value in values.items()
    )
    return TriedShape(label, overrides, part)


def _toml(effect: type[Effect], key: str, value: float) -> str:
    text = repr(float(f"{value:.6g}"))
    return f"[{text}]" if isinstance(effect.model_fields[key].default, tuple) else text


def _neutral(effect: type[Effect], key: str) -> float:
    value: Any = effect.neutral[key]
    return float(value[0] if isinstance(value, Sequence) else value)


def _step(effect: type[Effect], key: str, prior: Prior) -> float:
    """From the neutral value to the ordinary one."""
    step = prior.mean - _neutral(effect, key)
    return step if abs(step) > 1e-9 * prior.spread else prior.spread


def _one_sided(effect: type[Effect], key: str) -> bool:
    """Whether a bound of a parameter is its neutral value."""
    low, high = bounds_of(effect, key)
    return bool(np.isclose([low, high], _neutral(effect, key), rtol=0, atol=1e-12).any())
