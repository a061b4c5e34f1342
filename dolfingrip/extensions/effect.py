"""The base class of effects: a table of parameters with priors, and hooks of the model.

An effect's file imports no solver because the configuration reads it. Its hooks receive everything
that they need of a solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Protocol, runtime_checkable

import numpy as np
import ufl
from ufl.core.expr import Expr

from dolfingrip.sections import units
from dolfingrip.sections.fixture import Camera
from dolfingrip.sections.section import Entry, Role, Section

if TYPE_CHECKING:  # what hooks receive: their modules import the solver
    from dolfingrip.extensions.site import Site
    from dolfingrip.sections.setup import Setup
else:
    Site = Setup = object

StrainEnergy = Callable[[Expr], Expr]
"""A function from Green–Lagrange strain (3, 3) to energy per reference volume (mJ/mm³)."""

Kind = Literal[
    "elastic", "dissipative", "geometry", "set-up", "loading", "measurement", "numerical"
]
"""Kinds of effects in the order in which they act: elastic energies are added, dissipative effects
then scale them or remember their history."""


@dataclass(frozen=True, slots=True)
class Prior:
    """The knowledge of a parameter before anything is measured.

    Attributes:
        mean: expected value, in the unit of the parameter's name; for a list, of each entry.
        spread: standard deviation, in the same unit; for a list, of each entry.
        source: where it comes from; it says so if it is an engineering guess.
        positive: whether it is log-normal instead of normal.
        least: smallest magnitude, where values nearer to 0 are not allowed.
        wide: spread of what would be implausible, by the ordinary one: a rare part of the prior has
            it, for what was told wrongly, and for causes that are stronger than usual.
    """

    mean: float
    spread: float
    source: str
    positive: bool = False
    least: float = 0.0
    wide: float = 4.0

    @property
    def tail(self) -> float:
        """Standard deviation of the wide part by the ordinary one's, in ζ."""
        if not self.positive:
            return self.wide
        return math.sqrt(math.log1p((self.wide * self.spread / self.mean) ** 2)) / self._sigma

    @property
    def _sigma(self) -> float:
        """Standard deviation of the logarithm of a positive value."""
        return math.sqrt(math.log1p((self.spread / self.mean) ** 2))

    def at(self, zeta: float) -> float:
        """Value at a standard normal number ζ."""
        if not self.positive:
            value = self.mean + self.spread * zeta
            return value if abs(value) >= self.least else math.copysign(self.least, value)
        return self.mean * math.exp(self._sigma * zeta - self._sigma**2 / 2)

    def zeta(self, value: float) -> float:
        """Standard normal number of a value.

        Raises:
            ValueError: where the parameter is positive and the value is not.
        """
        if not self.positive:
            return (value - self.mean) / self.spread
        if value <= 0:
            raise ValueError(f"value = {value}: allowed: above 0")
        return (math.log(value / self.mean) + self._sigma**2 / 2) / self._sigma

    def slope(self, zeta: float) -> float:
        """Derivative of the value by ζ."""
        return self._sigma * self.at(zeta) if self.positive else self.spread


@dataclass(frozen=True, slots=True)
class DirectCheck:
    """A measurement that tells numbers of an effect by themselves.

    Effects that one measurement tells of have checks of one name.

    Attributes:
        name: in words.
        minutes: that it takes, an engineering guess.
        std: standard deviation of each number that is read, by its key in the effect's table and in
            its unit: an engineering guess of usual tools.
    """

    name: str
    minutes: float
    std: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class LabNumber:
    """How a laboratory tells a number that it never knows exactly, in the table ``[nuisance]``.

    Attributes:
        key: in that table.
        std: usual standard deviation, in the unit of the key; relative where it has none.
        words: what it is of.
        each_time: whether it is another one each time that the rig is set up.
    """

    key: str
    std: float
    words: str
    each_time: bool = False

    def spread(self, std: float, value: float) -> float:
        """Return a standard deviation in the unit of the number that stands for it.

        Args:
            std: as a laboratory tells it.
            value: of the number, in its unit.
        """
        return std if units.unit(self.key) else std * value

    def as_told(self, std: float, value: float) -> float:
        """Return a standard deviation as a laboratory tells it, the inverse of :meth:`spread`.

        Args:
            std: in the unit of the number that stands for it.
            value: of the number, in its unit.
        """
        return std if units.unit(self.key) else std / value


NEVER: Final = LabNumber("", 0.0, "")
"""Of an effect that no laboratory tells: it acts or not."""


@dataclass(frozen=True, slots=True)
class FittedKey:
    """The number of a configuration by which every hypothesis fits an effect.

    Attributes:
        key: of the configuration.
        value: as configured, in the unit of the key.
        low, high: of what may be fitted, in the same unit.
    """

    key: str
    value: float
    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True, slots=True)
class Flow:
    """Pressures at one stage between regulator and cavity, and times, of one load step.

    Attributes:
        inlet_before_kPa: pressure at its inlet as the step starts.
        inlet_kPa: pressure at its inlet as the step ends; it changes linearly in between.
        outlet_before_kPa: pressure at its outlet as the step starts.
        time_s: time as the step ends.
        step_s: length of the step; 0 at rest.
    """

    inlet_before_kPa: float
    inlet_kPa: float
    outlet_before_kPa: float
    time_s: float
    step_s: float


@runtime_checkable
class Adapting(Protocol):
    """An effect on geometry, mesh or solver; it has no other hook."""

    def adapt[S: Setup](self, config: S) -> S:
        """``config`` with other geometry, mesh or solver; use ``config.changed``."""


@runtime_checkable
class Energetic(Protocol):
    """An effect on the material."""

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        """The strain energy density with this effect; ``base`` is the density without it.

        It adds to ``base``, scales it or replaces it. A dissipative effect returns the incremental
        potential of a load step, which depends on ``site``'s internal variables and step.
        """


@runtime_checkable
class Uneven(Protocol):
    """An effect by which the body's moduli differ from place to place."""

    def moduli(self, site: Site) -> Expr:
        """Factor of all moduli of the finger's own material at each place of its mesh."""


@runtime_checkable
class Joining(Protocol):
    """An effect with further terms of the potential."""

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        """Additional energies of a finger (mJ of the meshed part), as forms in ``site.u``.

        May also change the set-up (``site.held``, ``site.plate``), and add to
        ``site.further`` terms that are no forms, as ``site.add_friction`` does.
        """


@runtime_checkable
class Stage(Protocol):
    """An effect between regulator and cavity."""

    @classmethod
    def name(cls) -> str:
        """Name of its table."""

    @classmethod
    def follows_path(cls) -> bool:
        """Return whether its outlet depends on what was before."""

    def outlet_kPa(self, flow: Flow) -> float:
        """Pressure (kPa) at this stage's outlet, towards the cavity, as a load step ends."""


@runtime_checkable
class Relaxing(Protocol):
    """An effect by which moduli relax."""

    def branches(self) -> tuple[Sequence[float], Sequence[float]]:
        """Parts of the instantaneous moduli that relax, and their times (s)."""


@runtime_checkable
class Displaying(Protocol):
    """An effect on what instruments show."""

    def reading(self, true: Mapping[str, np.ndarray], camera: Camera) -> Mapping[str, np.ndarray]:
        """Readings, by column, that are displayed wrongly, (rows,) each.

        Args:
            true: readings of a run that begins at rest at 0 s, (rows,) each in the order of time.
            camera: set-up of the camera.
        """


class Effect(Section):
    """One effect: its parameters are the table's keys, each with a :class:`Prior`.

    An effect has the hooks that it needs, each of which is a protocol above. The docstring of an
    effect tells its equation, what its effect on angle and force is (Fingerprint:) and what it is
    confused with (Confused with:).

    Attributes:
        kind: part of the model that it belongs to.
        place: among the effects of its kind that do not commute with it, as a gain and an offset
            do not; those of lower place act first.
        neutral: values of its parameters at which it has no effect; default: the first one at 0.
        mixed: whether its energy is also valid with a pressure field (element ``P2-P1``).
        clock: whether its readings depend on time.
        by_decades: whether it follows the logarithm of cycles: fewer than ten show nothing of it
            that softening in the first ones does not.
        tried: whether a diagnosis tries it as a cause.
        told: how a laboratory tells it that never knows it exactly: every hypothesis fits it, and
            it is a cause where it is implausible. Of others the key is empty.
        told_by: how a laboratory tells numbers that are integrated out where it does so, by their
            keys; where they are implausible it is a cause. Without such a report it is none.
        replaces: effects that are no causes of readings whose errors are told so.
        checks: measurements that tell its numbers by themselves.
        shapeless: parameters that do not alter the shape of its change: they hardly matter, or they
            multiply the amplitude.
        alike: parameters that fits determine but that are tried at one value, because all values
            change the readings in nearly the same way.
        lopsided: whether positive and negative values change the readings in different ways, so
            that both are tried.
        curved: whether its ordinary value changes the readings in another way than a small one, so
            that a derivative where it does nothing tells little.
        either: words of its first line, one for values above the neutral one and one for those
            below, with "or" between them.
    """

    role: ClassVar = Role.EXTENSIONS
    kind: ClassVar[Kind]
    mixed: ClassVar[bool] = True
    place: ClassVar[int] = 0
    neutral: ClassVar[Mapping[str, Any]]
    clock: ClassVar[bool] = False
    by_decades: ClassVar[bool] = False
    tried: ClassVar[bool] = True
    told: ClassVar[LabNumber] = NEVER
    told_by: ClassVar[Mapping[str, LabNumber]] = {}
    replaces: ClassVar[tuple[str, ...]] = ()
    checks: ClassVar[tuple[DirectCheck, ...]] = ()
    shapeless: ClassVar[tuple[str, ...]] = ()
    alike: ClassVar[tuple[str, ...]] = ()
    lopsided: ClassVar[bool] = False
    curved: ClassVar[bool] = False
    either: ClassVar[str] = ""

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        super().__pydantic_init_subclass__(**kwargs)
        if "neutral" not in vars(cls):
            cls.neutral = dict.fromkeys([*cls.model_fields][:1], 0.0)

    # -- as a diagnosis tries it -----------------------------------------------------------------

    @classmethod
    def felt_in_bending(cls, config: Setup) -> bool:
        """Return whether a finger that bends freely feels it."""
        return "finger" in cls.felt_by

    @property
    def shears_bars(self) -> str:
        """Number by which a bar that is pulled along its axis shears; empty where none does."""
        return ""

    @classmethod
    def fitted(cls, config: Setup) -> FittedKey | None:
        """Return the number by which every hypothesis fits an effect that is :attr:`told`.

        It is the effect's first number where an effect does not tell another one.

        Args:
            config: of the body that it acts on.

        Returns:
            None where the body has no such number.
        """
        (key, value), *_ = cls.neutral.items()
        on = config.tables["extensions"].inner.get(cls.name())
        return FittedKey(
            f"extensions.{cls.name()}.{key}", value if on is None else on.number_at(key)
        )

    @classmethod
    def possible(cls, config: Setup) -> bool:
        """Return whether it may act beside what is configured.

        Args:
            config: of the body that it acts on.
        """
        return True

    @classmethod
    def given(cls, config: Setup) -> Mapping[str, float]:
        """Return numbers of it that the configuration tells by other keys, by its own.

        These are held where it is tried, and the first of its other numbers is what may be off.

        Args:
            config: of the body that it acts on.
        """
        return {}

    def words(self, config: Setup) -> str:
        """Tell what it does at its numbers.

        Args:
            config: of the body that it acts on.
        """
        phrase = (self.__doc__ or self.name()).splitlines()[0].rstrip(".").partition(" (")[0]
        phrase = f"{phrase[0].lower()}{phrase[1:]}"
        if not self.either:
            return phrase
        (key, start), *_ = self.neutral.items()
        above, _, below = self.either.partition(" or ")
        return phrase.replace(self.either, above if getattr(self, key) > start else below)

    # -- what is known of it ---------------------------------------------------------------------

    @classmethod
    def name(cls) -> str:
        """Name of the effect's table and of its file."""
        return cls.__module__.rpartition(".")[2]

    @classmethod
    def entry_of(cls, key: str) -> Entry:
        """Return how a number of the effect enters a simulation."""
        if cls.kind == "numerical":
            return Entry.CHOICE
        if issubclass(cls, Stage):
            return Entry.SUPPLY
        if issubclass(cls, Displaying):
            return Entry.INSTRUMENT
        if cls.kind == "geometry":
            return Entry.SHAPE
        of_plate = issubclass(cls, Adapting) and cls.felt_by == ("plate",)
        return Entry.POSE if of_plate else Entry.CONSTANT

    @classmethod
    def is_modulus(cls, key: str) -> bool:
        """Return whether a number is a modulus."""
        return key.endswith("_MPa")

    @classmethod
    def remembers(cls) -> bool:
        """Return whether a state depends on earlier states, which an adjoint does not follow."""
        return cls.kind == "dissipative" or issubclass(cls, Stage)

    @classmethod
    def follows_path(cls) -> bool:
        """Return whether readings depend on what was before: a material remembers, a line lags."""
        return cls.kind == "dissipative" or cls.clock

    @classmethod
    def priors(cls) -> dict[str, Prior]:
        """Return the prior of each parameter that has one."""
        return {
            key: prior
            for key, info in cls.model_fields.items()
            for prior in info.metadata
            if isinstance(prior, Prior)
        }
