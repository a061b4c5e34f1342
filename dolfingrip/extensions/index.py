"""The index of effects, in the order in which they act on one another."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable, Mapping, Sequence
from functools import partial, reduce
from operator import mul
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self, get_args, overload

import numpy as np
import ufl
from pydantic import Field, create_model
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import (
    Displaying,
    Effect,
    Energetic,
    Joining,
    Kind,
    StrainEnergy,
    Uneven,
)
from dolfingrip.sections.fixture import Camera
from dolfingrip.sections.lookup import classes
from dolfingrip.sections.section import Role, Section

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site

SHARED = ("camera", "effect", "index", "kinds", "site", "supply")
"""Files that effects share. Each other file of this folder holds one effect."""

FAR = Camera()
"""A camera of which nothing is told."""


EFFECTS: tuple[type[Effect], ...] = tuple(
    sorted(
        classes(
            "effects",
            "dolfingrip.extensions",
            [
                file.name
                for file in pkgutil.iter_modules([str(Path(__file__).parent)])
                if file.name not in SHARED
            ],
            Effect,
        ).values(),
        key=lambda effect: (get_args(Kind).index(effect.kind), effect.place, effect.name()),
    )
)
"""All effects, one a file of this folder or of a plugin (:func:`dolfingrip.plugin`): by kind in the
order of :data:`Kind`, within a kind by place, then by name."""

_BY_NAME = {each.name(): each for each in EFFECTS}

NAMES: tuple[str, ...] = tuple(_BY_NAME)
"""Names of the effects' files and tables, in the same order."""


def effect(name: str) -> type[Effect]:
    """Return the class of an effect.

    Args:
        name: of its file, and of its table.
    """
    return _BY_NAME[name]


def fitted_effects() -> list[type[Effect]]:
    """List the effects whose numbers a laboratory never knows exactly: every hypothesis fits them.

    Each has :attr:`~dolfingrip.extensions.effect.Effect.told`.
    """
    return [effect for effect in EFFECTS if effect.told.key]


def camera_errors() -> list[type[Effect]]:
    """List the effects whose numbers are integrated out where a laboratory tells them.

    Each has :attr:`~dolfingrip.extensions.effect.Effect.told_by`.
    """
    return [effect for effect in EFFECTS if effect.told_by]


class Switched(Section):
    """Effects that the simple model leaves out; each is switched on by its own table."""

    role: ClassVar = Role.EXTENSIONS
    extensible: ClassVar = True
    effects: ClassVar[tuple[type[Effect], ...]] = ()

    @overload
    def active(self) -> list[Effect]: ...

    @overload
    def active[E](self, kind: type[E]) -> list[E]: ...

    def active(self, kind: type[Any] = Effect) -> list[Any]:
        """Return the effects of a kind that are on, in the index's order.

        Args:
            kind: protocol of a hook that they have; all effects where none is given.
        """
        switches = (getattr(self, effect.name()) for effect in self.effects)
        # nearly all are off, and a look at a protocol takes long
        return [on for on in switches if on is not None and isinstance(on, kind)]

    @property
    def inner(self) -> Mapping[str, Section]:
        """The effects that are on, by name."""
        return {on.name(): on for on in self.active()}

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        """``base`` with all effects on it."""
        for effect in self.active(Energetic):
            base = effect.strain_energy(base, site)
        return base

    def in_places(self, energies: Sequence[StrainEnergy], site: Site) -> list[StrainEnergy]:
        """Strain energies of the body with the moduli of each place."""
        moduli = [effect.moduli(site) for effect in self.active(Uneven)]
        return [partial(_scaled, energy, moduli) for energy in energies] if moduli else [*energies]

    def terms(self, site: Site) -> list[ufl.Form]:
        """Further energies of all effects."""
        return [term for effect in self.active(Joining) for term in effect.terms(site)]

    def displayed(
        self, true: Mapping[str, np.ndarray], camera: Camera = FAR
    ) -> dict[str, np.ndarray]:
        """Distort the readings of a run so far by the instruments, one after the other.

        Args:
            true: true readings by column, (rows,) each in the order of time, in the columns' units.
            camera: set-up of the camera.

        Returns:
            What the instruments show by column, (rows,) each, in the same units.
        """
        shown = dict(true)
        for effect in self.active(Displaying):
            shown |= effect.reading(shown, camera)
        return shown

    def without(self, kind: type[Any]) -> Self:
        """Return these extensions without the effects of a kind."""
        return self.model_copy(update={on.name(): None for on in self.active(kind)})


def _scaled(energy: StrainEnergy, factors: Sequence[Expr], strain: Expr) -> Expr:
    return reduce(mul, factors, energy(strain))


def table(effects: Iterable[type[Effect]]) -> type[Switched]:
    """Make the class of the section ``[extensions]``.

    Args:
        effects: each has a table in it.
    """
    effects = tuple(effects)
    fields: dict[str, Any] = {
        effect.name(): (
            effect | None,
            Field(None, description=(effect.__doc__ or "").splitlines()[0]),
        )
        for effect in effects
    }
    made = create_model("Extensions", __base__=Switched, __doc__=Switched.__doc__, **fields)
    made.effects = effects
    return made


if TYPE_CHECKING:  # its fields are known only at run time
    Extensions = Switched
else:
    Extensions = table(EFFECTS)
