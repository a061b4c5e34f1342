"""Natural frequencies and damping of the pressurised finger."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, ClassVar

from dolfingrip.channels import ANGLE, DAMPINGS, FREQUENCIES, PRESSURE
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


def _modes(rig: FingerRig) -> Callable[[], Mapping[str, float]]:
    """A function that returns frequencies and damping ratios at the present state, by column."""
    import numpy as np

    from dolfingrip.experiments.rigs.materials import densities
    from dolfingrip.extensions.effect import Relaxing
    from dolfingrip.mechanics.model.inertia import Inertia
    from dolfingrip.mechanics.newton.vibration import complex_frequencies

    newton, site = rig.newton, rig.specimen.site  # not the rig, which holds this function
    inertia = Inertia(site.u, site.domain, densities(site), site.masses)
    relaxing = site.config.extensions.active(Relaxing)
    times_s = [tau for effect in relaxing for tau in effect.branches()[1]]

    def modes() -> Mapping[str, float]:
        s = complex_frequencies(
            newton, inertia.assembled_mass(), len(FREQUENCIES), site.history, times_s
        )
        values = np.concatenate([s.imag / (2 * np.pi), -s.real / np.abs(s)])
        names = (channel.name for channel in (*FREQUENCIES, *DAMPINGS))
        return dict(zip(names, values.tolist(), strict=True))

    return modes


class Vibration(WholeFingerExperiment):
    """Natural frequencies and damping ratios of the free finger, pressurised.

    Example: dolfingrip vibrate --pressure 100

    They are those of small vibrations about the state at each pressure, which is held constant:
    s² M φ + K(s) φ = 0 with the tangent K, complex where the material relaxes, and the consistent
    mass M; 2π times the frequency is the imaginary part of s, and the damping ratio ζ = −Re s/|s|.
    The finger vibrates in the plane of
    bending and across it, so the whole finger is meshed. A measurement may have such frequencies
    and damping ratios in place of the record of a ring-down.
    """

    name: ClassVar = "vibration"
    command: ClassVar = "vibrate"
    title: ClassVar = "Natural frequencies"
    parts: ClassVar = ("finger", "modes")
    measured: ClassVar = True
    gradients: ClassVar = True
    options: ClassVar = (PRESSURE_OPTION, SUCTION_OPTION)
    dynamic: ClassVar = False
    table: ClassVar = (PRESSURE, ANGLE, *FREQUENCIES, DAMPINGS[0])
    plot: ClassVar = Plot(
        "Natural frequency (Hz)",
        tuple(Curve(each.name, each.title) for each in FREQUENCIES),
    )

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> FingerRig:
        rig = self._rig(config, comm, profile)
        rig.further = _modes(rig)
        return rig
