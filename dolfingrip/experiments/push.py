"""Stiffness of the pressurised finger against a load at its tip."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import ufl

from dolfingrip.channels import ANGLE, PRESSURE, Channel
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.description import Curve, Plot
from dolfingrip.experiments.finger_experiment import FingerExperiment

if TYPE_CHECKING:
    import numpy as np
    from mpi4py import MPI

    from dolfingrip.experiments.rigs.rig import Rig
    from dolfingrip.extensions.site import Site
    from dolfingrip.mechanics.model.profile import Profile
    from dolfingrip.mechanics.newton.newton import Newton
    from dolfingrip.mechanics.readings.reading import Reading

AXES = "xy"

STIFFNESSES = tuple(
    Channel(
        name=f"stiffness_{axis}_N_per_mm",
        unit="N_per_mm",
        title=f"Stiffness {axis}",
        about=f"force along {axis} on the tip face by the displacement that it causes",
        form=".4f",
    )
    for axis in AXES
)


def load(axis: str) -> str:
    """Name of the load along an axis in the model's parameters."""
    return f"push.load_{axis}_N"


class Push(FingerExperiment):
    """Stiffness of the free finger's tip against loads in x and y, pressurised.

    A dead load f is spread evenly over the tip face, Π −= f · ∫u dA / A, so that it works on the
    face's mean displacement ū. The stiffness follows from the tangent K at each pressure:
    1/(bᵀK⁻¹b) with b = ∂ū/∂u, the ratio of a very small load to the displacement that it causes.
    x lies in the plane of bending and y across it, so the whole finger is meshed.
    """

    name: ClassVar = "push"
    command: ClassVar = "push"
    title: ClassVar = "Stiffness at the tip"
    parts: ClassVar = ("finger",)
    columns: ClassVar = STIFFNESSES
    table: ClassVar = (PRESSURE, ANGLE, *STIFFNESSES)
    plot: ClassVar = Plot(
        "Stiffness at the tip (N/mm)",
        (
            Curve(STIFFNESSES[0].name, "x, in the plane of bending"),
            Curve(STIFFNESSES[1].name, "y, sideways"),
        ),
    )
    measured: ClassVar = False
    gradients: ClassVar = False

    def settings(self, config: Config) -> Config:
        return config.changed(mesh={"half": False})

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        from dolfingrip.experiments.rigs.finger_rig import FingerRig

        rig = FingerRig.built(
            config, comm, profile, plate=False, loads=dead_loads, made_for=self.made_for
        )
        if rig.newton.model.domain.half:
            raise ConfigError(
                f"mesh.file = {config.mesh.file}: half a finger, which has no stiffness in y; "
                "allowed: a whole one"
            )
        rig.further = stiffness(rig.newton)
        return rig


def dead_loads(site: Site) -> Sequence[ufl.Form]:
    """Potentials of loads of 0 N along x and y on the tip face (mJ of the meshed part)."""
    tip = site.domain.surface(
        "tip", quadrature_degree=2 * site.u.function_space.ufl_element().degree
    )
    per_area = site.fixed(1 / site.area_mm2("tip"))
    found = []
    for i, axis in enumerate(AXES):
        force = site.parameters[load(axis)] = site.fixed(0.0)
        found.append(-force * per_area * site.u[i] * tip)
    return found


def stiffness(newton: Newton) -> Callable[[], Mapping[str, float]]:
    """A function that returns the stiffness at the model's present state, by column."""
    from dolfingrip.mechanics.readings.tip import TipDisplacement

    tips = [TipDisplacement(newton.model, axis) for axis in AXES]

    def found() -> Mapping[str, float]:
        solve = newton.linear()
        along = zip(Push.columns, tips, strict=True)
        return {each.name: 1 / compliance_mm_per_N(solve, tip) for each, tip in along}

    return found


def compliance_mm_per_N(solve: Callable[[np.ndarray], np.ndarray], moved: Reading) -> float:
    """Derivative of a displacement by the load that works on it, for the whole solid.

    Args:
        solve: applies the inverse K⁻¹ of the model's tangent.
        moved: the displacement (mm).
    """
    model = moved.model
    direction = moved.gradient()
    for bc in model.supports:
        dofs, owned = bc.dof_indices()
        direction[dofs[:owned]] = 0.0
    product = model.comm.allreduce(float(direction @ solve(direction)))
    return product / model.domain.copies  # each part of the solid bears its share of the load
