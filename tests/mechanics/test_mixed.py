"""The mixed element: its derivatives, and no locking where nu is nearly 0.5."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from petsc4py import PETSc
from support import cook, small, taylor

from dolfingrip.config import Solver
from dolfingrip.experiments import run
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.mixed_tangent import MixedTangent, condensing_step
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath

SEED = 11
NU = 0.4999
LITERATURE_MM = 6.9
"""Rise of Cook's membrane in the limit (Simo & Armero 1992; Elguedj et al. 2008)."""


@pytest.fixture(scope="module")
def panel() -> Model:
    """Cook's membrane on 24 elements."""
    return cook.model("P2-P1", 2, NU)


@pytest.fixture
def disturbed(panel: Model) -> Iterator[Model]:
    """The panel at random displacements and pressures."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    rest = panel.unknowns.local()
    panel.unknowns.set_local(rest + rng.uniform(-0.5, 0.5, rest.shape))
    yield panel
    panel.unknowns.set_local(rest)


def test_tangent_is_the_derivative_of_the_equations(disturbed: Model) -> None:
    """Of u and p together, along directions that the supports allow."""
    panel = disturbed
    panel.potential.carried.reset()
    tangent = MixedTangent(panel)
    tangent.assemble()
    direction = np.random.default_rng(SEED + 1).uniform(-1, 1, panel.dofs)
    for bc in panel.supports:
        direction[bc.dof_indices()[0]] = 0.0
    w, product = (panel.unknowns.create_vector() for _ in range(2))
    w.array[:] = direction
    tangent.matrix.mult(w, product)
    start = panel.unknowns.owned()

    def equations(step: float) -> np.ndarray:
        panel.unknowns.set_owned(start + step * direction)
        panel.assemble_equations(product)
        return np.array(product.array)

    slope = np.array(product.array)
    assert taylor.rates(equations, slope, 0.1).min() > 1.9


def test_carried_stress_follows_both_fields(disturbed: Model) -> None:
    """After a step in u and p it is S(u + w, p + q) up to second order."""
    panel = disturbed
    carried = panel.potential.carried
    start = panel.unknowns.local()
    step = np.random.default_rng(SEED + 2).uniform(-1, 1, start.shape)

    def difference(size: float) -> np.ndarray:
        panel.unknowns.set_local(start)
        carried.follow(*panel.unknowns.parts(size * step))
        followed = carried.of_parts[0].x.array.copy()
        panel.unknowns.set_local(start + size * step)
        carried.reset()
        return np.asarray(carried.of_parts[0].x.array - followed)

    assert taylor.rates(difference, 0.0, 0.1).min() > 1.9


def negative_pivots(newton: Newton) -> int:
    """Those of the tangent at the model's present state."""
    newton.tangent.assemble()
    pc = PETSc.PC().create(newton.model.comm)
    pc.setOperators(newton.tangent.matrix)
    pc.setType(PETSc.PC.Type.CHOLESKY)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    pc.setUp()
    return int(pc.getFactorMatrix().getMumpsInfog(12))


def test_state_has_the_pressure(panel: Model) -> None:
    """Loaded, taken back and restored the panel is in equilibrium; its inertia is a minimum's."""
    rest = panel.state()
    newton = Newton(panel, Solver())
    assert LoadPath(newton, {"load_N": 25.0}).advance({"load_N": 50.0}).failure is None
    assert panel.p is not None
    # eliminating the pressures leaves a minimum's
    assert negative_pivots(newton) == panel.p.function_space.dofmap.index_map.size_global
    loaded = panel.state()
    assert loaded.pressure is not None
    assert np.ptp(loaded.pressure) > 1.0
    panel.restore(rest)
    assert not panel.unknowns.local().any()
    panel.restore(loaded)
    # by factors of its own: those of the path are of an earlier state
    assert Newton(panel, Solver()).solve().iterations <= 1
    panel.restore(rest)


def test_pressure_that_belongs_to_a_displacement(disturbed: Model) -> None:
    """Its equations hold after the step to it, which leaves the displacement and looks only."""
    owned = disturbed.u.function_space.dofmap.index_map.size_local * 3
    equations = disturbed.unknowns.create_vector()
    disturbed.assemble_equations(equations)
    before = abs(equations.array_r[owned:]).max()
    start = disturbed.unknowns.local()
    step = np.random.default_rng(SEED + 2).uniform(-0.1, 0.1, start.shape)
    for place in (start, start + step):
        disturbed.unknowns.set_local(place)
        change = condensing_step(disturbed)
        np.testing.assert_array_equal(disturbed.unknowns.local(), place)
        disturbed.unknowns.set_local(place + change)
        disturbed.assemble_equations(equations)
        assert abs(equations.array_r[owned:]).max() < 1e-9 * before
        np.testing.assert_array_equal(disturbed.unknowns.local()[:owned], place[:owned])
        np.testing.assert_allclose(condensing_step(disturbed), 0.0, atol=1e-9)


def test_no_locking_in_cooks_membrane() -> None:
    """Coarse quadratic elements with a pressure are near the limit; linear ones lock.

    The error of 5 % on 4 × 4 cells is the discretisation's at the clamp's singular corner, and
    halves with the mesh. Linear tetrahedra gain next to nothing by refinement.
    """
    mixed = [cook.shear("P2-P1", cells, NU)["rise_mm"] for cells in (4, 8)]
    print("P2-P1", mixed)
    assert mixed[0] == pytest.approx(LITERATURE_MM, rel=0.06)
    assert mixed[1] == pytest.approx(LITERATURE_MM, rel=0.025)
    linear = [cook.shear("P1", cells, NU)["rise_mm"] for cells in (4, 8)]
    print("P1", linear)
    assert max(linear) < 0.35 * LITERATURE_MM


def test_same_model_as_the_displacement_element() -> None:
    """At nu = 0.45 the two elements approach one another as the mesh is refined."""
    differences = []
    for cells in (4, 8, 16):
        mixed, plain = (cook.shear(e, cells, 0.45)["rise_mm"] for e in ("P2-P1", "P2"))
        differences.append(mixed / plain - 1)
    print("differences", differences)
    assert 0 < differences[2] < differences[1] < differences[0]
    assert differences[2] < 0.003


def test_coarse_nearly_incompressible_finger() -> None:
    """Six-millimetre elements give the angle of a finer mesh within the discretisation's error.

    At nu = 0.499, where the displacement element on the same mesh is far too stiff.
    """
    free = ("material.nu=0.499", "contact.self_contact=false", "experiment.step_kPa=50")

    def angle(*overrides: str) -> float:
        return float(run("bending", small.short(*free, *overrides)).column("angle_deg")[-1])

    fine = angle("solver.element=P2-P1", "mesh.size_mm=2.2", "mesh.edge_size_mm=2.2")
    coarse = angle("solver.element=P2-P1")
    locked = angle("solver.element=P1")
    print(f"angle {fine:.3f} deg; coarse {coarse / fine:.4f}, P1 {locked / fine:.4f} of it")
    assert coarse == pytest.approx(fine, rel=0.08)
    assert locked < 0.6 * fine


def test_blocked_finger_in_equilibrium() -> None:
    """The clamp takes what plate and cavity give: contact and pressure act on u alone."""
    settings = small.short("solver.element=P2-P1", "solver.rtol=1e-12", "finger.gap_mm=0.4")
    finger = small.model(settings, plate=True)
    observation = Observation(finger)
    assert list(small.pressurise(finger, [80.0, 160.0]))
    reading = observation.read()
    assert reading["contact_gap_mm"] < settings.contact.barrier_mm
    assert reading["force_N"] > 0.1
    assert small.clamp_force_N(finger)[0] == pytest.approx(-reading["force_N"], rel=1e-8)
