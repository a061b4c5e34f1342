"""A clamp that follows global unknowns: its derivatives, and the finger under volume control."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import ufl
from dolfinx import fem, la
from support import small, taylor, trial
from support.paths import by_pressure

from dolfingrip.experiments import run
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.extensions.clamp_compliance import ClampCompliance
from dolfingrip.extensions.plate_compliance import PlateCompliance
from dolfingrip.mechanics.model.term import Term
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.mixed_tangent import MixedTangent
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.tangent import Tangent

SEED = 3
SOFT = {
    ClampCompliance: {"compliance_mm_per_N": 0.5, "compliance_rad_per_Nmm": 1e-4},
    PlateCompliance: {"compliance_mm_per_N": 0.3},
}
LOADED = (
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=20",
    "experiment.step_kPa=20",
)


def allowed(finger: FingerModel) -> np.ndarray:
    """A random direction of the unknowns in which the clamp moves as its global unknowns do."""
    model, rng = finger.model, np.random.default_rng(SEED)
    moving, width = model.constraint, model.unknowns.owned_size
    assert moving is not None
    direction = rng.uniform(-0.1, 0.1, width)
    for bc in model.supports:
        direction[bc.dof_indices()[0]] = 0.0
    model.unknowns.global_rows(direction)[len(model.unknowns.global_unknowns) :] = 0.0
    changes = [
        unknown.change(direction) for unknown in moving.global_unknowns
    ]  # on one rank: no ghosts
    for change, unknown in zip(changes, moving.global_unknowns, strict=True):
        direction[moving.dofs] += change * trial.way(finger, unknown)
    return direction


class Foundation(Term):
    """∫ k |u|⁴/4 dX: a further energy in UFL, with forms of its own."""

    def __init__(self, finger: FingerModel) -> None:
        u = finger.model.u
        test, along = ufl.TestFunction(u.function_space), ufl.TrialFunction(u.function_space)
        energy = 1e-3 * ufl.inner(u, u) ** 2 / 4 * ufl.dx(metadata={"quadrature_degree": 4})
        gradient = ufl.derivative(energy, u, test)
        tangent = ufl.derivative(gradient, u, along)
        self._gradient, self._tangent = fem.form(gradient), fem.form(tangent)

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        found = fem.assemble_vector(self._gradient)
        found.scatter_reverse(la.InsertMode.add)
        gradient.at_nodes[:] += found.array[: gradient.at_nodes.size].reshape(-1, 3)

    def tangent_forms(self) -> Sequence[Sequence[fem.Form]]:
        return [[self._tangent]]


@pytest.mark.parametrize("further", [False, True], ids=["", "second energy"])
@pytest.mark.parametrize("element", ["S2", "P2-P1"])
def test_tangent_is_the_derivative_of_the_equations(element: str, further: bool) -> None:
    """Of all unknowns, from a loaded state; the plate is left, whose curvature jumps.

    The clamp's rows are those of all terms with forms, not of the first alone.
    """
    print("seed", SEED)
    settings = trial.configured(SOFT, *LOADED, f"solver.element={element}", "plate.gap_mm=30")
    finger = small.model(settings, plate=True)
    model = finger.model
    if further:
        model.terms = [*model.terms, Foundation(finger)]
    model.controls["pressure_kPa"].set(20.0)
    model.unknowns.set_owned(model.unknowns.owned() + 0.3 * allowed(finger))
    model.potential.carried.reset()
    tangent = (Tangent if model.p is None else MixedTangent)(model)
    tangent.assemble()
    direction = allowed(finger)
    w, product = (model.unknowns.create_vector() for _ in range(2))
    w.array[:] = direction
    tangent.matrix.mult(w, product)
    slope, start = np.array(product.array), model.unknowns.owned()

    def equations(step: float) -> np.ndarray:
        model.unknowns.set_owned(start + step * direction)
        model.assemble_equations(product)
        return np.array(product.array)

    assert taylor.rates(equations, slope, 0.1).min() > 1.9
    # the global unknowns' own equations, small compared with the elements'
    rows = model.unknowns.global_rows(np.arange(len(slope)))
    found = taylor.rates(lambda step: equations(step)[rows], slope[rows], 0.1)
    assert found.min() > 1.9


def test_volume_and_pressure_lead_to_the_same_states() -> None:
    """With a clamp and a plate that give way: where the pressure is the same, so is the force."""
    settings = trial.configured(SOFT, *trial.STRICT, *LOADED, "experiment.step_kPa=10")
    inflated = run("blocked_force", settings, comm=trial.SELF)
    assert inflated.failure is None
    volumes = inflated.column("cavity_volume_mm3")
    ratio = float(volumes[-1] / volumes[0])
    by_volume = trial.configured(
        SOFT,
        *trial.STRICT,
        *LOADED,
        "experiment.control=volume",
        f"experiment.max_volume_ratio={ratio!r}",
        f"experiment.step_volume_ratio={(ratio - 1) / 2!r}",
    )
    found = run("blocked_force", by_volume, comm=trial.SELF)
    assert found.failure is None
    assert inflated.column("force_N")[-1] > 0.1
    assert found.column("cavity_pressure_kPa")[-1] == pytest.approx(20.0, rel=1e-6)
    for name in ("force_N", "angle_deg", "tip_x_mm"):
        assert found.column(name)[-1] == pytest.approx(inflated.column(name)[-1], rel=1e-6)


def test_no_compliance_is_the_base_model() -> None:
    """The springs' constraints hold the base and the plate; their forces are the reactions."""
    none = {effect: effect.neutral for effect in SOFT}
    settings = [trial.configured(on, *trial.STRICT, *LOADED) for on in ({}, none)]
    held, still = (small.model(each, plate=True) for each in settings)
    for finger in (held, still):
        path = by_pressure(Newton(finger.model, finger.config.solver))
        assert path.advance({"pressure_kPa": 20.0}).failure is None
    difference = still.model.u.x.array - held.model.u.x.array
    assert np.abs(difference).max() < 1e-9 * np.abs(held.model.u.x.array).max()
    values = {unknown.name: unknown.value for unknown in still.model.unknowns.global_unknowns}
    force = held.plate.force_N()
    assert values["plate_compliance.force_N"] == pytest.approx(-force, rel=1e-8)
    assert values["clamp_compliance.force_x_N"] == pytest.approx(force, rel=1e-8)
    assert values["clamp_compliance.force_z_N"] == pytest.approx(0.0, abs=1e-8 * force)
