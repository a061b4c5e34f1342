"""The readings as a function of parameters: modulus and those of effects, by simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.simulation import modulus
from dolfingrip.diagnosis.simulation.closed_forms import has_closed_form
from dolfingrip.diagnosis.simulation.nuisances import WALL, by_log_modulus, modulus_keys
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.secants import felt_in
from dolfingrip.diagnosis.simulation.simulated import Case, Simulated, SimulationFailure, simulate
from dolfingrip.diagnosis.simulation.walls import WallCurves
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import Entry, find, moduli
from dolfingrip.parameter.priors import scaled_priors

SCALE: Final = "modulus"
"""Name of the factor of all moduli among the parameters."""

STEP: Final = 1e-3
"""Relative difference of moduli over which scaled readings are derived by them."""

MARGIN: Final = 1e-3
"""Distance of values from their bounds, as part of the prior's spread."""


class FitFailure(Exception):
    """A simulation at some values did not come to its end; the text says why."""


@dataclass(frozen=True, slots=True)
class FreeParameter:
    """A number that a fit finds.

    Attributes:
        key: ``extensions.effect.name`` or :data:`SCALE`.
        prior: of it.
        low, high: bounds.
        listed: whether the key is a list of one entry.
    """

    key: str
    prior: Prior
    low: float
    high: float
    listed: bool = False

    @property
    def gradient_key(self) -> str:
        """Key of the derivative."""
        return f"{self.key}[0]" if self.listed else self.key

    def override(self, value: float) -> str:
        """As with ``--set``."""
        return f"{self.key}=[{value!r}]" if self.listed else f"{self.key}={value!r}"

    @property
    def is_modulus(self) -> bool:
        """Whether it is in proportion to the material's modulus."""
        return self.key.endswith("_MPa")


def modulus_parameter(measurement: Measurement, config: Config) -> FreeParameter | None:
    """The factor of all moduli; None where tests are of different materials, or it is known.

    Of coupons alone, forces are in proportion to the cross-section, too, so the factor is of both.
    """
    materials = {str(moduli(test.setup.applied(config))) for test in measurement.tests}
    spread = max(test.setup.nuisances["modulus"] for test in measurement.tests)
    if coupons_alone(measurement):
        spread = math.hypot(spread, area_spread(measurement))
    if len(materials) > 1 or spread == 0:
        return None
    prior = Prior(1.0, spread, "the material's modulus", positive=True)
    return FreeParameter(SCALE, prior, 0.1, 10.0)


def wall_parameter(spread: float) -> FreeParameter:
    """The walls' thickness by that configured, of a relative standard deviation."""
    return FreeParameter(WALL, Prior(1.0, spread, "of the walls' thickness"), 0.5, 1.5)


def coupons_alone(measurement: Measurement) -> bool:
    """Whether all readings are in proportion to the modulus, or do not depend on it."""
    return all(test.experiment == "coupon" for test in measurement.tests)


def area_spread(measurement: Measurement) -> float:
    """Relative standard deviation of the coupons' cross-section."""
    return max(test.setup.nuisances["coupon_area"] for test in measurement.tests)


def can_be_fitted(name: str, overrides: Sequence[str], config: Config) -> bool:
    """Whether an effect has parameters that simulations can be derived by."""
    if has_closed_form(name) or not overrides or effect(name).kind == "numerical":
        return False
    return bool(free_parameters(name, overrides, config))


def free_parameters(name: str, overrides: Sequence[str], config: Config) -> list[FreeParameter]:
    """What a fit of an effect finds: the parameters with a prior, but those that are held."""
    on = config.overridden(overrides)
    found = []
    for key, prior in scaled_priors(effect(name), config.material.shear_MPa).items():
        if key in effect(name).shapeless:
            continue
        path = f"extensions.{name}.{key}"
        for parameter in find(on, [path]):
            if parameter.entry is Entry.CHOICE:
                continue
            margin = MARGIN * prior.spread
            found.append(
                FreeParameter(
                    path, prior, parameter.low + margin, parameter.high - margin,
                    parameter.key != path,
                )
            )  # fmt: skip
    return found


@dataclass
class EffectModel:
    """The readings of a measurement with effects whose parameters are free.

    Attributes:
        measurement, config, workers: as for
            :func:`~dolfingrip.diagnosis.simulation.simulated.simulate`.
        scale: the factor of all moduli, first among the parameters, where it is free.
        effects: parameters of the effects, after all others.
        held: overrides of the effects' other parameters.
        base: without effects; serves where there are none.
        count: of evaluations by simulation.
        wall: the walls' thickness, after ``scale``, where ``curves`` tell what it changes.
        curves: of the base model; they serve beside effects, too.
        shifts: nuisances that are simulated at their values, after these.
    """

    measurement: Measurement
    config: Config
    workers: Workers
    scale: FreeParameter | None
    effects: Sequence[FreeParameter] = ()
    held: Sequence[str] = ()
    base: Simulated | None = None
    scales: bool = False
    count: int = 0
    wall: FreeParameter | None = None
    curves: WallCurves | None = None
    shifts: Sequence[FreeParameter] = ()
    _known: dict[tuple[float, ...], tuple[Vector, Matrix]] = field(default_factory=dict)

    @property
    def parameters(self) -> list[FreeParameter]:
        """All that is free."""
        first = [each for each in (self.scale, self.wall) if each]
        return [*first, *self.shifts, *self.effects]

    @property
    def coupons_alone(self) -> bool:
        """Whether all readings are in proportion to the modulus, or do not depend on it."""
        return coupons_alone(self.measurement)

    def start(self) -> list[float]:
        """Medians of the priors."""
        return [each.prior.at(0.0) for each in self.parameters]

    def overrides(self, values: Sequence[float]) -> tuple[str, ...]:
        """The configuration at these values, as with ``--set``; without ``shifts``."""
        factor, _, own = self._split(self._beside_walls(values))
        return (*self._material(factor), *self._extensions(factor, own))

    def evaluate(self, values: Sequence[float]) -> tuple[Vector, Matrix]:
        """Readings, shape (n,), and their derivatives by the parameters, shape (n, p).

        Raises:
            FitFailure: where a simulation fails.
        """
        key = tuple(float(f"{value:.10g}") for value in self._beside_walls(values))
        if key not in self._known:
            self._known[key] = self._evaluate(key)
        readings, slopes = self._known[key]
        return (readings, slopes) if self.wall is None else self._moved(values, readings, slopes)

    @property
    def in_closed_form(self) -> bool:
        """Whether no evaluation needs a simulation."""
        return self.base is not None and not (self.effects or self.held)

    @property
    def of_the_finger(self) -> list[int]:
        """Places of the parameters but walls and shifts: what an addition is simulated at."""
        first = int(self.scale is not None)
        second = len(self.parameters) - len(self.effects)
        return [*range(first), *range(second, len(self.parameters))]

    @property
    def _configured(self) -> Config:
        """Without effects, as the first test was set up; its material is that of all."""
        return self.measurement.tests[0].setup.applied(self.config)

    def _beside_walls(self, values: Sequence[float]) -> list[float]:
        """All values but that of the walls."""
        at = int(self.scale is not None)
        return [*values[:at], *values[at + int(self.wall is not None) :]]

    def _split(self, values: Sequence[float]) -> tuple[float, Sequence[float], Sequence[float]]:
        """The factor of all moduli, the shifts and the effects' parameters; walls left out."""
        first = int(self.scale is not None)
        second = first + len(self.shifts)
        return (values[0] if first else 1.0), values[first:second], values[second:]

    def _moved(
        self, values: Sequence[float], readings: Vector, slopes: Matrix
    ) -> tuple[Vector, Matrix]:
        """With what the walls change in the base model."""
        assert self.curves is not None
        at = int(self.scale is not None)
        factor, walls = (values[0] if at else 1.0), values[at]
        change, by_walls = self.curves.change(walls, factor)
        found = np.insert(slopes, at, by_walls, axis=1)
        if self.scale:
            more, less = (
                self.curves.change(walls, factor * (1 + way * STEP))[0] for way in (1, -1)
            )
            found[:, 0] += (more - less) / (2 * STEP * factor)
        return readings + change, found

    def _material(self, factor: float) -> tuple[str, ...]:
        if factor == 1.0:
            return ()
        return modulus.overrides(self._configured, factor)

    def _extensions(self, factor: float, own: Sequence[float]) -> tuple[str, ...]:
        values = [v * factor if p.is_modulus else v for p, v in zip(self.effects, own, strict=True)]
        return (*self.held, *(p.override(v) for p, v in zip(self.effects, values, strict=True)))

    def _evaluate(self, values: tuple[float, ...]) -> tuple[Vector, Matrix]:
        """Readings and derivatives with the walls as configured; ``values`` are the others."""
        factor, moved, own = self._split(values)
        if self.in_closed_form:
            return self._without_effect(factor)
        simulated_factor = 1.0 if self.coupons_alone else factor
        stages = () if self.base is None else self.base.case.overrides
        keys = tuple(p.gradient_key for p in self.effects)
        with_scale: tuple[str, ...] = ()
        if self.scale and not self.coupons_alone:
            with_scale = modulus_keys(self._configured)
        case = self._case(
            (
                *stages,
                *self._material(simulated_factor),
                *(p.override(v) for p, v in zip(self.shifts, moved, strict=True)),
                *self._extensions(simulated_factor, own),
            ),
            (*(p.key for p in self.shifts), *keys, *with_scale),
        )
        try:
            (found,) = simulate(self.measurement, self.config, [case], self.workers)
        except ConfigError as error:
            raise FitFailure(str(error)) from None
        self.count += 1
        if np.isnan(found.readings).any():
            raise FitFailure(sentence(found.failures))
        columns = [
            found.slope(p.gradient_key) * (simulated_factor if p.is_modulus else 1.0)
            for p in self.effects
        ]
        if not self.coupons_alone:
            shifts = [found.slope(p.key) for p in self.shifts]
            return found.readings, self._with_scale(found, factor, own, shifts, columns)
        forces = in_proportion(self.measurement)
        size = np.where(forces, factor, 1.0)
        first = [np.where(forces, found.readings, 0.0)] if self.scale else []
        return size * found.readings, np.column_stack([*first, *(size * c for c in columns)])

    def _case(self, overrides: tuple[str, ...], gradients: tuple[str, ...]) -> Case:
        """With the effects in the experiments that feel any of them, and without them elsewhere.

        A free finger beside a plate with friction has no memory then, and need not be unloaded.
        """
        names = sorted({p.key.split(".")[1] for p in self.effects})
        if not names:
            return Case(overrides, gradients)
        own = tuple(f"extensions.{name}." for name in names)
        return Case(
            overrides,
            gradients,
            only_in=frozenset().union(*(felt_in(name, self._configured) for name in names)),
            elsewhere=tuple(each for each in overrides if not each.startswith(own)),
        )

    def _with_scale(
        self,
        found: Simulated,
        factor: float,
        own: Sequence[float],
        shifts: list[Vector],
        columns: list[Vector],
    ) -> Matrix:
        if not self.scale:
            return np.column_stack([*shifts, *columns])
        by_factor = by_log_modulus(self.measurement, found) / factor
        for parameter, value in zip(self.effects, own, strict=True):
            if parameter.is_modulus:
                by_factor = by_factor + found.slope(parameter.gradient_key) * value
        return np.column_stack([by_factor, *shifts, *columns])

    def _without_effect(self, factor: float) -> tuple[Vector, Matrix]:
        """From the base simulation: by exact scaling, else linear in the factor."""
        assert self.base is not None
        base = self.base
        if not self.scale:
            return base.readings, np.zeros((len(base.readings), 0))
        if self.scales:
            here, more, less = (
                modulus.scaled(self.measurement, base, factor * by)
                for by in (1.0, 1 + STEP, 1 - STEP)
            )
            return here, ((more - less) / (2 * STEP * factor))[:, None]
        slope = by_log_modulus(self.measurement, base)
        return base.readings + (factor - 1) * slope, slope[:, None]


def sentence(failures: Sequence[SimulationFailure]) -> str:
    """Why simulations failed, in one line."""
    return "; ".join(dict.fromkeys(each.sentence for each in failures)) or "no reading"
