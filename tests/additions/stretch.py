"""A made-up experiment: the material pulled by a tenth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from dolfingrip.channels import DISPLACEMENT, NOMINAL_STRAIN, NOMINAL_STRESS
from dolfingrip.config import Config
from dolfingrip.experiments.experiment import Curve, Experiment, Option, Plot
from dolfingrip.experiments.protocol import Stop, cycles

if TYPE_CHECKING:
    from mpi4py import MPI

    from dolfingrip.experiments.rigs.rig import Rig
    from dolfingrip.mechanics.model.profile import Profile


class Stretch(Experiment):
    """Pull the material by a tenth."""

    name: ClassVar = "stretch"
    command: ClassVar = "stretch"
    title: ClassVar = "A tenth"
    control: ClassVar = DISPLACEMENT
    parts: ClassVar = ("bar",)
    table: ClassVar = (DISPLACEMENT, NOMINAL_STRESS)
    plot: ClassVar = Plot(
        NOMINAL_STRESS.label, (Curve(NOMINAL_STRESS.name, "simulation"),), NOMINAL_STRAIN
    )
    measured: ClassVar = False
    drawable: ClassVar = False
    protocol: ClassVar = False
    options: ClassVar = (
        Option("--rate", float, None, "Speed of the crosshead (mm/s).", "coupon.rate_mm_per_s"),
    )

    def schedule(self, config: Config) -> Sequence[Stop]:
        travel = [0.0, 0.1 * config.coupon.gauge_length_mm]
        return cycles(travel, config.coupon.rate_mm_per_s, config.experiment)

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        from dolfingrip.experiments.rigs.bar_rig import BarRig

        return BarRig.built(config, comm, profile)
