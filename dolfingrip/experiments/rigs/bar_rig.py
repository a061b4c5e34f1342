"""The rig of a coupon: a crosshead moves one end of a bar."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

from mpi4py import MPI

from dolfingrip.channels import DISPLACEMENT, FORCE, NOMINAL_STRAIN, NOMINAL_STRESS, TIME
from dolfingrip.config import Config, Solver
from dolfingrip.experiments.protocol.schedule import Stop
from dolfingrip.experiments.rigs.bar import CouponModel, build
from dolfingrip.experiments.rigs.display import displayed
from dolfingrip.experiments.rigs.perturbation import ParameterPerturbation, of_constants
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.readings.of_model import of_model
from dolfingrip.mechanics.readings.prescribed import ControlValue, Time
from dolfingrip.mechanics.readings.reading import Reading
from dolfingrip.parameter import Parameter


class BarRig(Rig):
    """Moves a bar's end, and reads force, travel and width.

    Args:
        config: configuration that was asked for.
        bar: model of the bar.
        profile: takes the time of each phase.
    """

    specimen_name: ClassVar = "coupon"
    quantity = "displacement"

    def __init__(self, config: Config, bar: CouponModel, profile: Profile) -> None:
        super().__init__(Newton(bar.model, _strict(bar.config), profile), bar)
        self._config = config
        model = bar.model
        travel = ControlValue(model, DISPLACEMENT.name, model.controls[DISPLACEMENT.name])
        found: list[Reading] = [Time(model), travel, bar.force(), *of_model(model, "bar")]
        self.readings = {reading.column: reading for reading in found}
        self._bar = bar

    @classmethod
    def built(cls, config: Config, comm: MPI.Comm, profile: Profile) -> BarRig:
        """The rig of the configuration's coupon."""
        with profile.phase("forms"):
            bar = build(config, comm)
        return cls(config, bar, profile)

    def longest(self) -> dict[str, float]:
        sides = self._config.coupon
        return {
            DISPLACEMENT.name: sides.step_strain * sides.gauge_length_mm,
            TIME.name: self._config.solver.max_step_s or math.inf,
        }

    def controls(self, stop: Stop) -> Mapping[str, float]:
        return {DISPLACEMENT.name: stop.value, TIME.name: stop.time_s}

    def displayed(self, config: Config, true: Mapping[str, float]) -> dict[str, float]:
        sides = config.coupon
        row = displayed(config, true)
        row[NOMINAL_STRAIN.name] = row[DISPLACEMENT.name] / sides.gauge_length_mm
        row[NOMINAL_STRESS.name] = row[FORCE.name] / sides.area_mm2
        return row

    def read(self) -> dict[str, float]:
        true = {column: reading.value() for column, reading in self.readings.items()}
        return self.displayed(self._config, true)

    def perturbations(
        self, config: Config, parameters: Sequence[Parameter]
    ) -> Sequence[ParameterPerturbation]:
        return of_constants(parameters, config, self._bar.model, self._bar.parameters)


def _strict(config: Config) -> Solver:
    """The solver's settings with a relative tolerance for a bar whose end is moved.

    The first residual of such a bar belongs to a stretch without narrowing and is of the order of
    λ. The force to be found is of the order of μ.
    """
    mu, lmbda = config.material.shear_MPa, config.material.lmbda_MPa
    return config.solver.model_copy(update={"rtol": config.solver.rtol * mu / (lmbda + mu)})
