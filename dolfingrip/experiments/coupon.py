"""Uniaxial tension of the material."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Final

from dolfingrip.channels import DISPLACEMENT, NOMINAL_STRAIN, NOMINAL_STRESS, TIME, readings
from dolfingrip.experiments.experiment import (
    MPI,
    Config,
    Curve,
    Experiment,
    Option,
    Plot,
    Profile,
    Rig,
)
from dolfingrip.experiments.protocol import Stop, cycles, given, steps
from dolfingrip.sections.errors import ConfigError

FIT: Final = "--fit FILE.csv"
"""The option that options of a fit are allowed with."""


class Coupon(Experiment):
    """Pull the material in uniaxial tension: nominal stress against strain."""

    name: ClassVar = "coupon"
    command: ClassVar = "coupon"
    title: ClassVar = "Uniaxial tension"
    control: ClassVar = DISPLACEMENT
    parts: ClassVar = ("bar",)
    table: ClassVar = (DISPLACEMENT, TIME, NOMINAL_STRAIN, NOMINAL_STRESS, *readings("bar"))
    plot: ClassVar = Plot(
        NOMINAL_STRESS.label, (Curve(NOMINAL_STRESS.name, "simulation"),), NOMINAL_STRAIN
    )
    drawable: ClassVar = False
    options: ClassVar = (
        Option(
            "--fit",
            list[Path],
            None,
            "Fit laws to this measured CSV instead; repeatable.",
        ),
        Option("--law", list[str], None, "With --fit: this law alone; repeatable.", needs=FIT),
        Option("--max-stretch", float, None, "With --fit: leave out readings beyond.", needs=FIT),
    )

    def schedule(self, config: Config) -> Sequence[Stop]:
        coupon, protocol = config.coupon, config.protocol
        if protocol.time_s:
            if not protocol.displacement_mm:
                raise ConfigError("protocol.displacement_mm = []: allowed: one for each time_s")
            return given(protocol, protocol.displacement_mm)
        strains = steps(coupon.max_strain, coupon.step_strain)
        travel = [strain * coupon.gauge_length_mm for strain in strains]
        return cycles(travel, coupon.rate_mm_per_s, config.experiment)

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        from dolfingrip.experiments.rigs.bar_rig import BarRig

        return BarRig.built(config, comm, profile)

    def setup(self, config: Config) -> dict[str, Any]:
        return {
            "gauge_length_mm": config.coupon.gauge_length_mm,
            "area_mm2": config.coupon.area_mm2,
            "rate_mm_per_s": config.coupon.rate_mm_per_s,
        }
