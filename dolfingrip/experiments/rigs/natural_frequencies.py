"""Natural frequencies of the finger at its present pressure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from dolfingrip.channels import Channel

if TYPE_CHECKING:
    from dolfingrip.experiments.rigs.rig import Rig

FREQUENCIES = tuple(
    Channel(
        name=f"frequency_{i}_Hz",
        unit="Hz",
        title=f"Frequency {i}",
        about=f"natural frequency {i} of small vibrations at constant pressure",
        form=".2f",
    )
    for i in (1, 2, 3, 4)
)


def frequencies(rig: Rig) -> Callable[[], Mapping[str, float]]:
    """A function that returns the lowest natural frequencies at the present state, by column."""
    from dolfingrip.experiments.rigs.base_material import densities
    from dolfingrip.mechanics.model.inertia import Inertia
    from dolfingrip.mechanics.newton.vibration import natural_frequencies_Hz

    newton, site = rig.newton, rig.specimen.site  # not the rig, which holds this function
    mass = Inertia(site.u, site.domain, densities(site)).mass

    def found() -> Mapping[str, float]:
        values = natural_frequencies_Hz(newton, mass, len(FREQUENCIES))
        return {each.name: float(x) for each, x in zip(FREQUENCIES, values, strict=True)}

    return found
