"""What is not known: a number with its prior, as a standard normal one, θ = θ(ζ), and its role.

An unknown is a number of the model or its rig, which every hypothesis fits, as the factor of all
moduli or a regulator's zero; or it is a number of a cause that may be named. Some numbers of the
rig are causes, too, where they are implausible by their priors.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np

from dolfingrip.config import Change, Config, ConfigError
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.extensions.effect import Displaying, Effect, Prior
from dolfingrip.extensions.index import NAMES, effect
from dolfingrip.parameter import bounds_of
from dolfingrip.parameter.search import scaled_priors
from dolfingrip.sections.units import NOTHING, unit

MODULUS: Final = "modulus"
"""Key of the factor of all moduli, and what it is called."""


def check_effects(names: Sequence[str] | None) -> None:
    """Refuse names that are of no effect that may be named.

    Args:
        names: of effects; None for the whole catalogue.

    Raises:
        ConfigError: one line with the name and what is allowed.
    """
    for name in names or ():
        if name not in NAMES:
            raise ConfigError(f"--effects {name}: allowed: {', '.join(NAMES)}")


@dataclass(frozen=True, slots=True)
class Unknown:
    """A number that readings may tell.

    Attributes:
        key: of the configuration, without entry numbers; ``modulus`` for the factor of all moduli.
        prior: of the number, for the material's stiffness.
        low, high: range of ζ, by the number's bounds and the emulator's reach.
        bounds: of the number itself.
        amplitude: whether the effect vanishes at a value of it.
        listed: whether the configuration has a list with this one entry.
        modulus: whether it is in proportion to the stiffness of the material.
        role: fitted in every hypothesis, and told among the fitted numbers; fitted, too, but never
            far from what was told; or of a cause that may be named.
        names: causes that it stands for where it is implausible by its prior; one that has no name
            is not tried so.
        unit: of a number that is no key of the configuration; empty where it is relative.
        tail: standard deviation of the wide part of its prior by that of the ordinary part; 1 where
            it has no tail.
        told: key of ``[nuisance]`` by which a laboratory tells it; empty where it is its key.
    """

    key: str
    prior: Prior
    low: float
    high: float
    bounds: tuple[float, float] = (-np.inf, np.inf)
    amplitude: bool = True
    listed: bool = False
    modulus: bool = False
    role: Literal["always", "marginal", "candidate"] = "candidate"
    names: tuple[str, ...] = ()
    tail: float = 1.0
    unit: str = ""
    told: str = ""

    @property
    def told_as(self) -> str:
        """Key of ``[nuisance]`` by which a laboratory tells it."""
        return self.told or self.key

    @classmethod
    def marginal(cls, key: str, std: float, unit: str, mean: float = 0.0) -> Unknown:
        """Make a number that is never far from what was told, from its deviation in a unit."""
        prior = Prior(mean, std, "as reported")
        return cls(key, prior, -np.inf, np.inf, role="marginal", unit=unit)

    def implausible(self) -> Unknown:
        """Make a number of a cause of it, where it is implausible by its prior."""
        spread = self.prior.wide * self.prior.spread
        prior = replace(self.prior, spread=spread, source="implausible by the prior")
        return replace(self, prior=prior, role="candidate", tail=1.0)

    def at(self, zeta: float | np.ndarray) -> np.ndarray:
        """Values, of the shape of ``zeta``; rounding leads beyond no bound, and not close to 0."""
        values = np.clip(_at_each(self.prior.at, zeta), *self.bounds)
        return np.where(np.abs(values) < NOTHING, 0.0, values)[()]

    def slope(self, zeta: float | np.ndarray) -> np.ndarray:
        """Derivatives of the values by ζ, of its shape."""
        return _at_each(self.prior.slope, zeta)[()]

    @property
    def straight(self) -> bool:
        """Tell whether readings are nearly straight in the number, not in ζ."""
        return self.amplitude or not self.prior.positive

    @property
    def bend(self) -> tuple[float, float]:
        """Arguments of :func:`coordinates`: ln's standard deviation, and mean by spread.

        Both are 0 where its coordinate is ζ.
        """
        if not (self.straight and self.prior.positive):
            return 0.0, 0.0
        return self.log_std, self.prior.mean / self.prior.spread

    def coordinate(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinate in which readings are nearly straight, and its derivative by ζ.

        It is the number by its standard deviation, or ζ of a number that no change is in
        proportion to.

        Args:
            zeta: any shape; so are both.
        """
        return coordinates(zeta, *self.bend)

    def zeta_of(self, u: float) -> float:
        """Standard normal number at a coordinate."""
        return self.zeta(self.prior.mean + u * self.prior.spread) if self.straight else u

    def coordinate_of(self, value: float) -> tuple[float, float]:
        """Coordinate of a value, and the derivative of the value by it."""
        if self.straight:
            return (value - self.prior.mean) / self.prior.spread, self.prior.spread
        zeta = self.zeta(value)
        return zeta, self.prior.slope(zeta)

    def zeta(self, value: float) -> float:
        """Standard normal number of a value.

        Raises:
            ValueError: where the prior is of positive numbers and the value is not.
        """
        return self.prior.zeta(value)

    def reaching(self, reach: float) -> Unknown:
        """Return it with the range ±``reach`` of ζ, as far as its bounds let it."""
        (least, most), low, high = self.bounds, -reach, reach
        if np.isfinite(least) and (not self.prior.positive or least > 0):
            low = max(low, self.zeta(least))
        if np.isfinite(most):
            high = min(high, self.zeta(most))
        return replace(self, low=low, high=high)

    @property
    def log_std(self) -> float:
        """Standard deviation of the logarithm of a positive number."""
        return float(np.sqrt(np.log1p((self.prior.spread / self.prior.mean) ** 2)))

    @property
    def gradient(self) -> str:
        """Key of its derivative."""
        return f"{self.key}[0]" if self.listed else self.key

    def change(self, value: float) -> Change:
        """Return the change of the configuration that gives it a value."""
        return {self.key: [value] if self.listed else value}


@dataclass(frozen=True, slots=True)
class NumberReading:
    """A reading of numbers by themselves: of one, or of a sum of several.

    Attributes:
        key: by which a laboratory tells it in ``[nuisance]``.
        numbers: coefficients of the unknowns that it is the sum of, by their keys.
        starts: these as configured, or where their effects do nothing, by their keys.
        configured: what would be read of the model as configured.
        std: standard deviation of the reading.
        value: as read; NaN where nothing is read yet.
    """

    key: str
    numbers: Mapping[str, float]
    starts: Mapping[str, float]
    configured: float
    std: float
    value: float = np.nan

    @property
    def change(self) -> float:
        """Difference of the reading to that of the model as configured."""
        return self.value - self.configured


def linear_in(
    readings: Sequence[NumberReading], unknowns: Sequence[Unknown]
) -> tuple[np.ndarray, np.ndarray]:
    """Tell how readings of numbers change with unknowns, in which they are linear.

    Args:
        readings: m of them.
        unknowns: d of them, of which those that are read have straight coordinates.

    Returns:
        Derivatives by the coordinates, shape (m, d), and coordinates as configured, shape (d,).
    """
    by = np.zeros((len(readings), len(unknowns)))
    start = np.zeros(len(unknowns))
    for row, reading in enumerate(readings):
        for place, unknown in enumerate(unknowns):
            if unknown.key in reading.numbers:
                start[place], rate = unknown.coordinate_of(reading.starts[unknown.key])
                by[row, place] = reading.numbers[unknown.key] * rate
    return by, start


def expected(
    readings: Sequence[NumberReading], unknowns: Sequence[Unknown], zeta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Readings of numbers at ζ, less those of the model as configured.

    Args:
        readings: m of them.
        unknowns: of the hypothesis.
        zeta: of these, shape (d,).

    Returns:
        The changes, shape (m,), and their derivatives by ζ, shape (m, d).
    """
    by, start = linear_in(readings, unknowns)
    pairs = [unknown.coordinate(z) for unknown, z in zip(unknowns, zeta, strict=True)]
    u, rate = np.array(pairs).T
    return by @ (u - start), by * rate


def coordinates(
    zeta: np.ndarray, log_std: float | np.ndarray, ratio: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers by their standard deviations, of lognormal ones, and the derivatives by ζ.

    Args:
        zeta: standard normal numbers, shape (…, d); so are both.
        log_std: standard deviations of their logarithms, shape (d,) or one for all.
        ratio: means by standard deviations, alike; 0 for a number whose coordinate is ζ.
    """
    value = ratio * np.exp(log_std * zeta - np.square(log_std) / 2)
    bent = np.greater(ratio, 0)
    return np.where(bent, value - ratio, zeta), np.where(bent, log_std * value, 1.0)


def mixture(
    zeta: np.ndarray, tail: np.ndarray, rare: float = Policy().rare
) -> tuple[np.ndarray, np.ndarray]:
    """Density of priors of which a rare part is wide: a mixture of N(0, 1) and N(0, tail²).

    Args:
        zeta: numbers by the standard deviation of the ordinary part, shape (..., d).
        tail: standard deviation of the wide part of each, (..., d) or (d,); 1 where none is wide.
        rare: probability of the wide part.

    Returns:
        −ln of the density less ½ ln 2π, and its slope by ζ as a part of ζ, (..., d) each: the
        precision of the normal distribution that pulls as much there.
    """
    near = np.log1p(-rare) - 0.5 * zeta**2
    far = np.log(rare / tail) - 0.5 * (zeta / tail) ** 2
    both = np.logaddexp(near, far)
    return -both, 1 - np.exp(far - both) * (1 - tail**-2.0)


def _at_each(function: Callable[[float], float], zeta: float | np.ndarray) -> np.ndarray:
    """Values of a function of one number, of the shape of ``zeta``.

    NumPy's exponential differs by processor, and what is simulated is found by its numbers.
    """
    return np.array([function(z) for z in np.ravel(zeta).tolist()]).reshape(np.shape(zeta))


def factor_of_moduli(
    std: float, low: float, high: float, names: tuple[str, ...] = (MODULUS,)
) -> Unknown:
    """The factor c = exp(s ζ) of all moduli, which every hypothesis fits; its median is 1.

    Args:
        std: s.
        low, high: range of ζ; draws go where no fit does.
        names: causes that it stands for where it is far off.
    """
    mean = float(np.exp(std**2 / 2))
    prior = Prior(mean, mean * float(np.sqrt(np.expm1(std**2))), "as reported", positive=True)
    ends = float(np.exp(std * low)), float(np.exp(std * high))
    return Unknown(MODULUS, prior, low, high, ends, role="always", names=names)


@dataclass(frozen=True, slots=True)
class Cause:
    """An effect of the catalogue with the numbers that are fitted.

    Attributes:
        name: of the effect.
        numbers: those that are fitted, amplitudes first.
        held: its other numbers, and their values.
    """

    name: str
    numbers: tuple[Unknown, ...]
    held: tuple[tuple[Unknown, float], ...]

    def overrides(self, zeta: Sequence[float] | np.ndarray, factor: float = 1.0) -> Change:
        """Return the change that switches the effect on at ζ, its moduli times a factor."""
        fitted = [(n, float(n.at(z))) for n, z in zip(self.numbers, zeta, strict=True)]
        return self._change([*fitted, *self.held], factor)

    @staticmethod
    def _change(values: Sequence[tuple[Unknown, float]], factor: float) -> Change:
        change: dict[str, Any] = {}
        for number, value in values:
            change |= number.change(value * factor if number.modulus else value)
        return change

    def resting(self, factor: float = 1.0) -> Change:
        """Return the change by which the effect is there and does nothing.

        Args:
            factor: of its moduli.
        """
        values = [(n, self.neutral(n) if n.amplitude else float(n.at(0.0))) for n in self.numbers]
        return self._change([*values, *self.held], factor)

    @property
    def smooth(self) -> bool:
        """Tell whether derivatives where it does nothing tell what it changes at first."""
        kind = effect(self.name)
        return not (
            kind.follows_path() or kind.lopsided or kind.curved or issubclass(kind, Displaying)
        )

    def resting_coordinate(self, number: Unknown) -> float:
        """Coordinate of a number where the effect does nothing."""
        value = self.neutral(number) if number.amplitude else float(number.at(0.0))
        return number.coordinate_of(value)[0]

    def box(self) -> np.ndarray:
        """Ranges of ζ, (numbers, 2)."""
        return np.array([[number.low, number.high] for number in self.numbers])

    def neutral(self, number: Unknown) -> float:
        """Value of an amplitude at which the effect does nothing."""
        if self.name not in NAMES:
            return number.prior.mean
        value = effect(self.name).neutral.get(number.key.rpartition(".")[2], 0.0)
        return float(value[0] if isinstance(value, Sequence) else value)

    def start_and_step(self, number: Unknown) -> tuple[float, float]:
        """The value at which an amplitude does nothing, and from there to the ordinary one."""
        start = self.neutral(number)
        step = number.prior.mean - start
        if abs(step) <= 1e-9 * number.prior.spread:
            step = number.prior.spread if number.bounds[1] > start else -number.prior.spread
        return start, step

    def at_strength(
        self, strength: float = 1.0, longest_s: float = np.inf, off: float = Policy().start
    ) -> np.ndarray:
        """ζ at a strength; numbers of the shape at their middles.

        Args:
            strength: by the ordinary one.
            longest_s: that a time of the shape shall not exceed.
            off: standard deviations that it is moved by for that, at most.
        """
        zetas = []
        for number in self.numbers:
            zeta = 0.0
            if number.amplitude:
                start, step = self.start_and_step(number)
                value = start + strength * step
                lost = number.prior.positive and value <= 0
                zeta = number.low if lost else number.zeta(value)
            elif unit(number.key) == "s":
                zeta = min(0.0, max(number.zeta(longest_s), -off))
            zetas.append(np.clip(zeta, number.low, number.high))
        return np.array(zetas)


def causes(
    config: Config, names: Sequence[str] | None = None, policy: Policy = Policy()
) -> list[Cause]:
    """The effects that are not on in ``config`` and may be named.

    Args:
        config: the model that is diagnosed.
        names: of those that are tried; the whole catalogue where None.
        policy: how far their numbers reach.
    """
    on = {active.name() for active in config.extensions.active()}
    candidates = []
    for name in NAMES if names is None else names:
        cls = effect(name)
        if name in on or cls.told.key or not cls.tried or cls.kind == "numerical":
            continue
        candidates.append(cause(cls, config, policy.reach))
    return candidates


def cause(cls: type[Effect], config: Config, reach: float = Policy().reach) -> Cause:
    """An effect with its priors at the stiffness of the configuration's material.

    Args:
        cls: the effect.
        config: the model that is diagnosed.
        reach: largest |ζ| of its numbers.
    """
    priors, given = scaled_priors(cls, config.material.shear_MPa), cls.given(config)
    amplitudes = [key for key in cls.neutral if key in priors and key not in given]
    amplitudes = amplitudes or [key for key in priors if key not in given][:1]
    shapes = [key for key in priors if key not in amplitudes]
    free = [key for key in shapes if key not in {*cls.shapeless, *cls.alike, *given}]
    numbers = tuple(
        _number(cls, key, priors[key], reach, amplitude=key in amplitudes)
        for key in [*amplitudes, *free]
    )
    held = tuple(
        (
            _number(cls, key, priors[key], reach, amplitude=False),
            given.get(key, priors[key].at(0.0) if key in cls.alike else priors[key].mean),
        )
        for key in shapes
        if key not in free
    )
    return Cause(cls.name(), numbers, held)


def _listed(cls: type[Effect], key: str) -> bool:
    default: Any = cls.model_fields[key].default
    return isinstance(default, tuple)


def _number(cls: type[Effect], key: str, prior: Prior, reach: float, *, amplitude: bool) -> Unknown:
    tail = prior.tail if amplitude else 1.0
    # what an instrument shows follows from the readings, however far it is off
    reach *= tail if issubclass(cls, Displaying) else 1.0
    return Unknown(
        f"extensions.{cls.name()}.{key}", prior, -reach, reach, bounds_of(cls, key), amplitude,
        _listed(cls, key), cls.is_modulus(key), tail=tail,
    ).reaching(reach)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Nuisance:
    """One nuisance.

    Attributes:
        unknown: key of the table ``[nuisance]``, and what it is of where there are several; with
            the standard deviation, reported or usual.
        change: (n,) of the readings at one standard deviation, in the unit of each column.
    """

    unknown: Unknown
    change: np.ndarray

    @property
    def name(self) -> str:
        """Key of the unknown."""
        return self.unknown.key

    @property
    def std(self) -> float:
        """Standard deviation of its prior, in the unit of the unknown."""
        return self.unknown.prior.spread
