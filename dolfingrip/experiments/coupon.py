"""Uniaxial tension of the material."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Final

from dolfingrip.channels import (
    DISPLACEMENT,
    NOMINAL_STRAIN,
    NOMINAL_STRESS,
    TIME,
    TRANSVERSE_STRAIN,
    readings,
)
from dolfingrip.experiments.experiment import (
    MPI,
    Config,
    Curve,
    Experiment,
    Option,
    Plot,
    Profile,
    Readings,
    Rig,
)
from dolfingrip.experiments.protocol import Stop, cycles, given, steps
from dolfingrip.sections.errors import ConfigError

FIT: Final = "--fit FILE.csv"
"""The option that options of a fit are allowed with."""


GROWN: Final = 1.2
"""Volume, by that at rest, which no rubber reaches."""


class Coupon(Experiment):
    """Pull the material in uniaxial tension: nominal stress against strain.

    Example: dolfingrip coupon --set coupon.max_strain=1
    """

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
    does_without: ClassVar = (
        "solver.element", "solver.integration", "material.density_kg_m3",
        "material.elongation_at_break", "experiment.control", "experiment.snaps",
        "experiment.max_pressure_kPa", "experiment.min_pressure_kPa", "experiment.step_kPa",
        "experiment.max_volume_ratio", "experiment.step_volume_ratio",
        "experiment.rate_kPa_per_s", "experiment.rest_s",
    )  # fmt: skip
    options: ClassVar = (
        Option(
            "--fit",
            list[Path],
            None,
            "Fit laws to this measured CSV instead; repeatable.",
        ),
        Option("--law", list[str], None, "Fit this law alone; repeatable.", needs=FIT),
        Option("--max-stretch", float, None, "Largest stretch that is fitted.", needs=FIT),
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

    def notes(self, config: Config) -> list[str]:
        from dolfingrip.experiments.results import doubts

        return doubts.not_given(config)

    def remarks(self, result: Readings) -> list[str]:
        from dolfingrip.experiments.results import doubts

        if not result.rows:
            return []
        stretch = 1 + result.column(NOMINAL_STRAIN.name)
        volume = stretch * (1 + result.column(TRANSVERSE_STRAIN.name)) ** 2
        most, nu = int(volume.argmax()), result.config.material.poisson
        sentences = doubts.of_law(result.config, float(stretch.max()))
        if volume[most] > GROWN:
            soft = ", where the energy K/2 (ln J)² softens" if volume[most] > math.e else ""
            sentences.append(
                f"at a stretch of {stretch[most]:.3g} the volume is {volume[most]:.2f} of that at "
                f"rest{soft}: rubber keeps it and resists more; nu = {nu:.4g}"
            )
        return sentences

    def setup(self, config: Config) -> dict[str, Any]:
        return {
            "gauge_length_mm": config.coupon.gauge_length_mm,
            "area_mm2": config.coupon.area_mm2,
            "rate_mm_per_s": config.coupon.rate_mm_per_s,
        }
