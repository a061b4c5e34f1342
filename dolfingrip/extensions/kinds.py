"""The base classes of effects: elastic and viscous ones, dimensions, supply, instruments.

Stages and instruments may lag behind by a first-order filter, which starts at rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Final

import numpy as np
from ufl.core.expr import Expr

from dolfingrip.channels import Channel
from dolfingrip.extensions.effect import DirectCheck, Effect, FittedKey, Setup, Site, StrainEnergy
from dolfingrip.forms import transient_network
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.fixture import Camera
from dolfingrip.sections.section import FINGERS, Entry
from dolfingrip.sections.supply import AirLine

MANOMETER: Final = "a manometer at the finger's inlet, at rest and at the highest pressure"
WEIGHT: Final = "a known weight on the load cell, and none"
SQUARE: Final = "a square of known angle in the camera's picture"
"""Measurements that tell numbers of several effects."""


class Elastic(Effect):
    """An effect whose energy is added to the base model's; it has no memory."""

    kind: ClassVar = "elastic"

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        """Return the energy per reference volume (mJ/mm³).

        Args:
            strain: Green–Lagrange strain, (3, 3).
            mu: shear modulus of the base material (MPa).
            c: the effect's parameters by key, as constants of the form.
        """
        raise NotImplementedError

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        c = {key: site.constant(self, key) for key in type(self).model_fields}
        return lambda strain: base(strain) + self.added(strain, site.mu, c)


Network = tuple[Expr, Expr]
"""Shear modulus (MPa) and relaxation time (s) of a Maxwell branch."""


class Viscous(Effect):
    """An effect whose material has Maxwell branches in parallel with the elastic solid.

    ``material.mu_MPa`` is the relaxed modulus μ∞. See
    :mod:`dolfingrip.forms.transient_network`.
    """

    kind: ClassVar = "dissipative"
    place: ClassVar = 3
    clock: ClassVar = True

    def networks(self, site: Site) -> Sequence[Network]:
        """Return modulus and time of each branch.

        Args:
            site: model under construction, which the effect's parameters become constants of.
        """
        raise NotImplementedError

    def branches(self) -> tuple[Sequence[float], Sequence[float]]:
        """Return parts of the instantaneous modulus that relax, and their times (s)."""
        raise NotImplementedError

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        c_inverse = site.remember(self, "C_inverse", np.eye(3))
        branches = []
        for i, (modulus, tau) in enumerate(self.networks(site), 1):
            a = site.remember(self, f"A{i}", np.eye(3))
            now, c_now = transient_network.update(site.strain, a, c_inverse, site.step_s, tau)
            site.history.evolve(a, now)
            branches.append((modulus, a, tau))
        site.history.evolve(c_inverse, c_now)

        def density(strain: Expr) -> Expr:
            over = [
                transient_network.energy(strain, modulus, a, c_inverse, site.step_s, tau)
                for modulus, a, tau in branches
            ]
            return base(strain) + sum(over[1:], start=over[0])

        return density


class DimensionOffset(Effect):
    """An effect that adds an offset to one dimension of the finger, which is then meshed anew.

    Attributes:
        dimension: key of the dimension in the table of the geometry.
        weighed: a check of the mass, which all dimensions change together.
        offset_mm: length that is added to the dimension (mm).
    """

    kind: ClassVar = "geometry"
    felt_by: ClassVar = FINGERS
    either: ClassVar = "thicker or thinner"
    checks: ClassVar = (
        DirectCheck(
            "cut a finger of this print: callipers at walls and base layer", 15.0,
            {"offset_mm": 0.05},
        ),
    )  # fmt: skip
    # relative, as the density of a print is not better known
    weighed: ClassVar = DirectCheck("weigh the finger", 2.0, {"mass_g": 0.01})
    dimension: ClassVar[str]
    offset_mm: float

    @classmethod
    def dimension_key(cls, config: Setup) -> str | None:
        """Return the key of the dimension; None where the body has none, as of a mesh file.

        Args:
            config: of the body.
        """
        has = config.mesh.file is None and hasattr(config.geometry, cls.dimension)
        return f"{config.geometry_table}.{cls.dimension}" if has else None

    @classmethod
    def fitted(cls, config: Setup) -> FittedKey | None:
        key = cls.dimension_key(config)
        if key is None:
            return None
        value = float(getattr(config.geometry, cls.dimension))
        return FittedKey(key, value, 0.2 * value, 2 * value)

    @classmethod
    def possible(cls, config: Setup) -> bool:
        """Return whether the body has the dimension.

        Args:
            config: of the body that it acts on.
        """
        return cls.dimension_key(config) is not None

    def adapt[S: Setup](self, config: S) -> S:
        """``config`` with the printed dimension.

        Raises:
            ConfigError: one line, if the finger is a mesh file, which has no dimensions.
        """
        table, allowed = config.geometry_table, ""
        if config.mesh.file is not None:
            allowed = f"from dimensions only; mesh.file has its {self.dimension}"
        elif not hasattr(config.geometry, self.dimension):
            allowed = f"that has a {self.dimension}, which [{table}] has not"
        if allowed:
            key = f"extensions.{self.name()}.offset_mm = {self.offset_mm:g}"
            raise ConfigError(f"{key}: allowed: with a finger {allowed}")
        return config.changed(**{table: config.geometry.offset(self.dimension, self.offset_mm)})


class SupplyStage(Effect):
    """The base class of effects between regulator and cavity, which are a :class:`Stage`."""

    kind: ClassVar = "loading"
    felt_by: ClassVar = FINGERS


class AirLineChange(Effect):
    """The base class of effects that change numbers of the table ``[supply]``."""

    kind: ClassVar = "loading"
    felt_by: ClassVar = FINGERS

    @classmethod
    def entry_of(cls, key: str) -> Entry:
        """Return how a number enters: with the supply's own."""
        return Entry.SUPPLY

    @classmethod
    def remembers(cls) -> bool:
        """Return whether a state depends on earlier states: air that is in the line stays."""
        return True

    @classmethod
    def possible(cls, config: Setup) -> bool:
        """Return whether the configuration has such a supply.

        Args:
            config: of the body that it acts on.
        """
        return config.supply is not None

    def changes(self, supply: AirLine) -> Mapping[str, float]:
        """Return the numbers of the supply that are others, by key.

        Args:
            supply: as configured.
        """
        raise NotImplementedError

    def adapt[S: Setup](self, config: S) -> S:
        """``config`` with these numbers."""
        supply = config.supply
        return config if supply is None else config.changed(supply=self.changes(supply))


class Instrument(Effect):
    """An effect that changes one channel and nothing else.

    Attributes:
        channel: what it displays.
    """

    kind: ClassVar = "measurement"
    channel: ClassVar[Channel]

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        """The values that the instrument displays, (rows,), in the channel's unit.

        Args:
            true: readings of a run so far, by column, (rows,) each in the order of time.
        """
        raise NotImplementedError

    def reading(self, true: Mapping[str, np.ndarray], camera: Camera) -> Mapping[str, np.ndarray]:
        # a free finger's row has no force, and a coupon's row has no angle
        name = self.channel.name
        return {name: self.displayed(true)} if name in true else {}


def lagging(tau_s: float, step_s: float, before: float, now: float, behind: float) -> float:
    """Return the outlet y of τ dy/dt = x − y as a step ends, exact for an x that is linear in it.

    y = x − Δx (1 − exp(−t))/t + (y₀ − x₀) exp(−t), t = Δt/τ. As τ goes to 0, y goes to
    x − τ dx/dt. In a step of no duration y stays, and with τ = 0 it is x.

    Args:
        tau_s: time constant τ.
        step_s: length of the step, 0 at rest.
        before: x₀, as the step starts.
        now: x, as it ends.
        behind: y₀, as the step starts.
    """
    t = step_s / tau_s if tau_s > 0 else math.inf
    # expm1 keeps the digits in a step much shorter than τ; in a step of no duration it is 0/0
    mean = -math.expm1(-t) / t if t > 0 else 1.0
    return now - (now - before) * mean + (behind - before) * math.exp(-t)
