"""The effects there are, in the order in which they act on one another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import ufl
from pydantic import Field, create_model

from dolfingrip.extensions.effect import Effect, StrainEnergy
from dolfingrip.sections.lookup import only_class
from dolfingrip.sections.section import Section

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site

NAMES = (
    # strain energies add; what comes later scales or remembers what came before
    "mooney_rivlin",
    "yeoh",
    "gent",
    "ogden",
    "ogden_terms",
    "polynomial",
    "bulk_modulus",
    "print_anisotropy",
    "mullins",
    "permanent_set",
    "prony",
    "temperature_drift",
    # geometry
    "wall_offset",
    "base_layer_offset",
    # set-up
    "gravity_pitch",
    "clamp_compliance",
    "plate_compliance",
    "plate_gap",
    "plate_tilt",
    "plate_friction",
    "bellows_friction",
    # from the regulator to the cavity
    "pressure_gain",
    "pressure_offset",
    "line_lag",
    # from the sensor to the table
    "force_gain",
    "force_offset",
    "force_drift",
    "angle_definition",
    "angle_gain",
    "angle_offset",
    # the model
    "coarse_mesh",
    "locking",
    "no_self_contact",
)
"""One line an effect: its file's name, which is its table's."""


def effect(name: str) -> type[Effect]:
    """The class in the file of an effect."""
    return only_class(f"dolfingrip.extensions.{name}", Effect)


EFFECTS: tuple[type[Effect], ...] = tuple(effect(name) for name in NAMES)


class Switched(Section):
    """Effects that the simple model leaves out; a table of its own switches each on."""

    effects: ClassVar[tuple[type[Effect], ...]] = ()

    def active(self, hook: str | None = None) -> Sequence[Any]:
        """The effects that are on, in the index' order; those with ``hook`` only where given."""
        found = (getattr(self, each.name()) for each in self.effects)
        return [on for on in found if on is not None and (hook is None or on.has(hook))]

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        """``base`` with all effects on it."""
        for effect in self.active("strain_energy"):
            base = effect.strain_energy(base, site)
        return base

    def terms(self, site: Site) -> list[ufl.Form]:
        """Further energies of all effects."""
        return [term for effect in self.active("terms") for term in effect.terms(site)]

    def without(self, hook: str) -> Self:
        """The same with the effects that have ``hook`` switched off."""
        return self.model_copy(update={on.name(): None for on in self.active(hook)})


def table(effects: Iterable[type[Effect]]) -> type[Switched]:
    """The section ``[extensions]`` with a table for each of ``effects``."""
    effects = tuple(effects)
    fields: dict[str, Any] = {
        each.name(): (
            each | None,
            Field(None, description=(each.__doc__ or "").splitlines()[0]),
        )
        for each in effects
    }
    made = create_model("Extensions", __base__=Switched, __doc__=Switched.__doc__, **fields)
    made.effects = effects
    return made


if TYPE_CHECKING:  # its fields are known as it runs only
    Extensions = Switched
else:
    Extensions = table(EFFECTS)
