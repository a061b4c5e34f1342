"""The rig of a coupon: a crosshead moves one end of a bar."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.channels import DISPLACEMENT, FORCE, NOMINAL_STRAIN, NOMINAL_STRESS, TIME
from dolfingrip.config import Config, Solver
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.rigs.materials import BaseMaterial
from dolfingrip.experiments.rigs.perturbation import ParameterPerturbation, of_constants
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.extensions.site import Site
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import displacement_element, integration_degree
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import History, Memory
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.readings.integrals import Reaction
from dolfingrip.mechanics.readings.prescribed import ControlValue, Time
from dolfingrip.mechanics.readings.reading import Reading, of_model
from dolfingrip.parameter import Parameter

CLAMPED_CELLS = 2
"""Elements across the thinner side of a bar whose ends are held fast."""


class Crosshead(Memory):
    """Moves one end of the bar: a control, and a memory of its position.

    A move stretches the whole bar evenly. This is the solution if its ends are free to narrow.
    """

    def __init__(self, u: fem.Function, length_mm: float) -> None:
        self._u = u
        self._share = u.function_space.tabulate_dof_coordinates()[:, 2] / length_mm
        self._value = 0.0

    @property
    def value(self) -> float:
        """Displacement (mm)."""
        return self._value

    def set(self, value: float) -> None:
        """Prescribe ``value``."""
        self._u.x.array[2::3] += (value - self._value) * self._share
        self._value = value

    def values(self) -> dict[str, np.ndarray]:
        """Present position of the crosshead (mm), by name."""
        return {"crosshead_mm": np.array([self._value])}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Read its position from a restored displacement."""
        self._value = float(values["crosshead_mm"][0])


@dataclass(slots=True)
class CouponModel:
    """A bar along z, at rest from 0 to its gauge length.

    Attributes:
        config: configuration that it was built from.
        model: model that is solved.
        history: internal variables of the model.
        moved: owned displacement nodes of the end that moves.
        parameters: constants of the potential by name.
    """

    config: Config
    model: Model
    history: History
    moved: np.ndarray
    parameters: dict[str, fem.Constant]

    def force(self) -> Reaction:
        """Tensile force: the moved end's reaction."""
        return Reaction(self.model, FORCE.name, self.moved, axis=2)


def build(config: Config, comm: MPI.Comm = MPI.COMM_WORLD) -> CouponModel:
    """The model of a bar.

    With sliding grips the stretch is uniform and the stress is uniaxial, so any number of
    linear elements is exact.

    Args:
        config: coupon, material and effects.
        comm: ranks to run on.

    Returns:
        The model at rest.
    """
    config = config.adapted()
    sides, clamped = config.coupon, config.coupon.grip == "clamped"
    size = np.array([sides.width_mm, sides.thickness_mm, sides.gauge_length_mm])
    cells = np.array([1, 1, comm.size])
    if clamped:
        cells = np.maximum(np.round(CLAMPED_CELLS * size / size.min()), cells).astype(int)
    block = mesh.create_box(
        comm, [np.zeros(3), size], cells.tolist(), ghost_mode=mesh.GhostMode.none
    )
    block.topology.create_connectivity(2, 3)
    domain = Domain(block, {}, half=False)
    space = fem.functionspace(block, displacement_element("P2" if clamped else "P1"))
    u = fem.Function(space, name="displacement_mm")
    base = BaseMaterial.on(block, config.material)
    history = History(u, integration_degree(space))
    site = Site(config, domain, u, base.mu, base.lmbda, history, parameters=dict(base.constants))
    density = config.extensions.strain_energy(base.energy, site)

    x = space.tabulate_dof_coordinates() / size
    foot, head = np.isclose(x[:, 2], 0), np.isclose(x[:, 2], 1)
    held = [foot | head] * 3
    if not clamped:  # no more than what a rigid body needs, so that it may also shear
        held[0] = foot & np.isclose(x[:, 0], 0) & np.isclose(x[:, 1], 0)
        held[1] = foot & np.isclose(x[:, 1], 0)
    supports = [
        fem.dirichletbc(
            PETSc.ScalarType(0.0),
            (3 * np.flatnonzero(where) + axis).astype(np.int32),
            space.sub(axis),
        )
        for axis, where in enumerate(held)
    ]
    crosshead = Crosshead(u, sides.gauge_length_mm)
    potential = Potential(u, [density], carried=config.solver.mixed_integration_point)
    model = Model(
        domain,
        u,
        potential,
        supports,
        {DISPLACEMENT.name: crosshead},
        memories=[crosshead, history],
    )
    owned = space.dofmap.index_map.size_local
    moved = np.flatnonzero(head[:owned])
    return CouponModel(config, model, history, moved, site.parameters)


class BarRig(Rig):
    """Moves a bar's end, and reads force, travel and width.

    Args:
        config: configuration that was asked for.
        bar: model of the bar.
        profile: takes the time of each phase.
    """

    specimen_name: ClassVar = "coupon"

    def __init__(self, config: Config, bar: CouponModel, profile: Profile) -> None:
        super().__init__(Newton(bar.model, _strict(bar.config), profile), bar)
        self._config = config
        model = bar.model
        travel = ControlValue(model, DISPLACEMENT.name, model.controls[DISPLACEMENT.name])
        readings: list[Reading] = [Time(model), travel, bar.force(), *of_model(model, "bar")]
        self.readings = {reading.column: reading for reading in readings}
        self._bar = bar

    @classmethod
    def built(cls, config: Config, comm: MPI.Comm, profile: Profile) -> BarRig:
        """The rig of the configuration's coupon."""
        with profile.phase("forms"):
            bar = build(config, comm)
        return cls(config, bar, profile)

    @property
    def quantity(self) -> str:
        return "displacement"

    def longest(self) -> dict[str, float]:
        sides = self._config.coupon
        return {
            DISPLACEMENT.name: sides.step_strain * sides.gauge_length_mm,
            TIME.name: self._config.solver.max_step_s or math.inf,
        }

    def controls(self, stop: Stop) -> Mapping[str, float]:
        return {DISPLACEMENT.name: stop.value, TIME.name: stop.time_s}

    def displayed(self, config: Config, true: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        sides = config.coupon
        row = config.extensions.displayed(true)
        row[NOMINAL_STRAIN.name] = row[DISPLACEMENT.name] / sides.gauge_length_mm
        row[NOMINAL_STRESS.name] = row[FORCE.name] / sides.area_mm2
        return row

    def read(self) -> dict[str, float]:
        true = {column: reading.value() for column, reading in self.readings.items()}
        return self.shown(self._config, true)

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
