"""Natural frequencies of the pressurised finger."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, ClassVar

from dolfingrip.channels import ANGLE, PRESSURE, Channel
from dolfingrip.experiments.experiment import (
    MPI,
    PRESSURE_OPTION,
    SUCTION_OPTION,
    Config,
    Curve,
    Plot,
    Profile,
)
from dolfingrip.experiments.finger_experiment import WholeFingerExperiment

if TYPE_CHECKING:
    from dolfingrip.experiments.rigs.finger_rig import FingerRig

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


def _frequencies(rig: FingerRig) -> Callable[[], Mapping[str, float]]:
    """A function that returns the lowest natural frequencies at the present state, by column."""
    from dolfingrip.experiments.rigs.materials import densities
    from dolfingrip.mechanics.model.inertia import Inertia
    from dolfingrip.mechanics.newton.vibration import natural_frequencies_Hz

    newton, site = rig.newton, rig.specimen.site  # not the rig, which holds this function
    mass = Inertia(site.u, site.domain, densities(site)).mass

    def found() -> Mapping[str, float]:
        values = natural_frequencies_Hz(newton, mass, len(FREQUENCIES))
        return {channel.name: float(x) for channel, x in zip(FREQUENCIES, values, strict=True)}

    return found


class Vibration(WholeFingerExperiment):
    """Natural frequencies of the free finger, pressurised.

    Example: dolfingrip vibrate --pressure 100

    They are those of small vibrations about the state at each pressure, which is held constant:
    K φ = ω² M φ with the tangent K and the consistent mass M. The finger vibrates in the plane of
    bending and across it, so the whole finger is meshed.
    """

    name: ClassVar = "vibration"
    command: ClassVar = "vibrate"
    title: ClassVar = "Natural frequencies"
    parts: ClassVar = ("finger",)
    columns: ClassVar = FREQUENCIES
    options: ClassVar = (PRESSURE_OPTION, SUCTION_OPTION)
    dynamic: ClassVar = False
    table: ClassVar = (PRESSURE, ANGLE, *FREQUENCIES)
    plot: ClassVar = Plot(
        "Natural frequency (Hz)",
        tuple(Curve(each.name, each.title) for each in FREQUENCIES),
    )

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> FingerRig:
        rig = self._rig(config, comm, profile)
        rig.further = _frequencies(rig)
        return rig
