"""A number of a design, and the base class of what computes such numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Final

from dolfingrip.channels import ANGLE, FORCE, PRESSURE
from dolfingrip.config import Config, ConfigError
from dolfingrip.files.objective import NamedObjective, Sense
from dolfingrip.sections.units import unit

UNITS: Final = {each.name.rpartition("_")[2]: each.name for each in (PRESSURE, FORCE, ANGLE)}
"""Columns that set a place on a path, by the unit that a place is given in."""

Places = Mapping[str, tuple[float, ...]]
"""Values at which a quantity is read, by column; empty: no place."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number of a design.

    Attributes:
        name: with its unit.
        experiment: that gives it; None if it takes no simulation.
        where: column that sets the place on the experiment's path; "": the highest pressure, or the
            end of a grasp.
        values: of that column; the quantity is the mean over them.
        usual: whether the experiment is the one that is run unless another is named.
    """

    name: str
    experiment: str | None = None
    where: str = ""
    values: tuple[float, ...] = ()
    usual: bool = True

    def __str__(self) -> str:
        other = "" if self.usual else f"in {self.experiment}"
        return " ".join(filter(None, (self.name, self.place, other)))

    @property
    def place(self) -> str:
        """Place where it is read, as in ``at 250 kPa``; "" if it has none."""
        if not self.where:
            return ""
        values = ", ".join(f"{value:g}" for value in self.values)
        return f"at {values} {self.where.rpartition('_')[2]}"


@dataclass(slots=True)
class Outcome:
    """The numbers of a design.

    Attributes:
        outputs: number by quantity.
        gradients: by output its derivatives, by key of the parameter; None where not computed.
        curve: the readings, by column.
        iterations: of Newton's method.
        versions: of the software that computed it, by package.
    """

    outputs: dict[str, float]
    gradients: dict[str, dict[str, float]] | None = None
    curve: dict[str, Any] | None = None
    iterations: int | None = None
    versions: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class AskedDesign:
    """A design whose quantities are asked for.

    Attributes:
        config: of the design.
        keys: of parameters that its quantities are derived by, () for all; None for ξ1 and ξ2 where
            an adjoint gives them.
        ranks: MPI processes.
        fields: folder for the result of each experiment with its fields; None: none is written.
    """

    config: Config
    keys: Sequence[str] | None = None
    ranks: int = 1
    fields: Path | None = None


class QuantitySource(ABC):
    """A kind of quantities, which one file describes.

    Attributes:
        names: of its quantities.
    """

    names: ClassVar[Sequence[str]]

    def quantity(self, said: str, name: str, places: Places, experiment: str | None) -> Quantity:
        """Return the quantity of a name; that of a source without experiments has no place.

        Args:
            said: option with the name, for messages.
            name: one of :attr:`names`.
            places: where it is read.
            experiment: that is run instead of the usual one.

        Returns:
            The quantity.

        Raises:
            ConfigError: one line, where it cannot be read there.
        """
        if places or experiment:
            raise ConfigError(f"{said}: of the unloaded shape; allowed: without a place")
        return Quantity(name)

    def check_design(  # noqa: B027  # those of the shape need none
        self, wanted: Sequence[Quantity], design: AskedDesign
    ) -> None:
        """Refuse what can be computed of no design, before one is.

        Args:
            wanted: quantities of this source.
            design: that the others are varied from.

        Raises:
            ConfigError: one line.
        """

    @abstractmethod
    def add(self, outcome: Outcome, wanted: Sequence[Quantity], design: AskedDesign) -> None:
        """Compute quantities and add them to an outcome, under their texts.

        Args:
            outcome: with outputs, gradients, curve and iterations, which are filled.
            wanted: quantities of this source.
            design: its configuration, and what is wanted of it.

        Raises:
            JobFailure: where there is no result; with the curve up to there.
            ConfigError: where there is no such design, or no such parameter of it.
            MachineError: where a rank died.
        """


def objective(text: str, sense: Sense) -> NamedObjective:
    """Name an objective of a front by its quantity.

    Args:
        text: of the quantity, as ``force_N at 250 kPa``; that of an own objective function, too.
        sense: what is done with it.

    Returns:
        The objective, whose title is the text.
    """
    name, at, place = text.partition(" at ")
    return NamedObjective(
        name=name, unit=unit(name), sense=sense, where=f"at {place}" if at else ""
    )
