"""Dead loads on the tip face, and the finger's stiffness against them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from dolfingrip.channels import Channel

if TYPE_CHECKING:
    import numpy as np

    from dolfingrip.experiments.rigs.finger import Additions
    from dolfingrip.extensions.site import Site
    from dolfingrip.mechanics.newton.newton import Newton
    from dolfingrip.mechanics.readings.reading import Reading

AXES = "xy"

STIFFNESSES = tuple(
    Channel(
        name=f"stiffness_{axis}_N_per_mm",
        unit="N_per_mm",
        title=f"Stiffness {axis}",
        about=f"force along {axis} on the tip face divided by the displacement that it causes",
        form=".4f",
    )
    for axis in AXES
)


def load(axis: str) -> str:
    """Name of the load along an axis in the model's parameters.

    Args:
        axis: x or y.

    Returns:
        The name; the load is in N.
    """
    return f"push.load_{axis}_N"


def dead_loads(site: Site) -> Additions:
    """Add loads of 0 N along x and y on the tip face.

    Args:
        site: fields and constants of the finger; the loads become constants of it.

    Returns:
        Their potentials (mJ of the meshed part).
    """
    from dolfingrip.experiments.rigs.finger import Additions

    tip = site.domain.surface(
        "tip", quadrature_degree=2 * site.u.function_space.ufl_element().degree
    )
    per_area = site.fixed(1 / site.area_mm2("tip"))
    loads = []
    for i, axis in enumerate(AXES):
        force = site.parameters[load(axis)] = site.fixed(0.0)
        loads.append(-force * per_area * site.u[i] * tip)
    return Additions(loads=loads)


def stiffness(newton: Newton) -> Callable[[], Mapping[str, float]]:
    """A function that returns the stiffness at the model's present state, by column."""
    from dolfingrip.mechanics.readings.tip import TipDisplacement

    tips = [TipDisplacement(newton.model, axis) for axis in AXES]

    def found() -> Mapping[str, float]:
        solve = newton.linear()
        along = zip(STIFFNESSES, tips, strict=True)
        return {channel.name: 1 / compliance_mm_per_N(solve, tip) for channel, tip in along}

    return found


def compliance_mm_per_N(solve: Callable[[np.ndarray], np.ndarray], moved: Reading) -> float:
    """Derivative of a displacement by the load that works on it, for the whole solid.

    Args:
        solve: applies the inverse K⁻¹ of the model's tangent.
        moved: the displacement (mm).
    """
    model = moved.model
    direction = moved.gradient()
    direction[model.supported] = 0.0
    product = model.comm.allreduce(float(direction @ solve(direction)))
    return product / model.domain.copies  # each part of the solid bears its share of the load
