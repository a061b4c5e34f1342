"""Deformable surfaces against rigid bodies: derivatives, step bounds, what a free body does."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem
from petsc4py import PETSc
from scipy.spatial.transform import Rotation
from support import blocks, taylor

from dolfingrip.config import Solver
from dolfingrip.forms import plate
from dolfingrip.mechanics.contact.density import Density, Smooth, TwoStage
from dolfingrip.mechanics.contact.distance import (
    BentCapsule,
    Capsule,
    Plane,
    RoundedBox,
    SignedDistance,
)
from dolfingrip.mechanics.contact.friction import Friction
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.contact.rigid_points import RigidPoints
from dolfingrip.mechanics.contact.sampled_distance import SampledDistance
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.pose import Pose
from dolfingrip.mechanics.model.rigid_body import RigidBody, RigidMotion, ball
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.tangent import Tangent

SEED = 23
WIDTH = 0.4
SHAPES: list[SignedDistance] = [
    Plane((0.0, 0.0, -1.0)),
    Capsule(1.0, 0.0),
    Capsule(0.5, 0.6),
    RoundedBox((0.8, 0.6, 0.5), 0.2),
    BentCapsule(0.5, 0.9, 1.5),
    SampledDistance.of(
        lambda x: np.linalg.norm(x - [0.4, -0.2, 0.1], axis=1) - 0.8,
        np.full(3, -2.4),
        np.full(3, 2.4),
        0.2,
    ),
]
NAMES = ["plane", "sphere", "capsule", "box", "bent", "sampled"]
MATERIAL = blocks.NeoHooke(2.0, 0.3)
every = pytest.mark.parametrize("shape", SHAPES, ids=NAMES)


def resting(
    shape: SignedDistance,
    *,
    gap_mm: float,
    density: Density | None = None,
    pose: Pose | None = None,
    mass_kg: float = 0.01,
) -> tuple[Model, RigidContact, RigidMotion]:
    """A unit block, a little deformed, with a turned rigid body above it that is free to move."""
    block = blocks.Block("block", blocks.block((3, 3, 3)), MATERIAL, held={2: ["below"]})
    model = blocks.model([block])
    inertia = mass_kg * np.array([[0.5, 0.1, 0.0], [0.1, 0.6, 0.05], [0.0, 0.05, 0.4]])
    body = RigidBody("body", mass_kg, inertia, (0.45, 0.55, 3.0))
    pose = pose or body.pose(model.domain.mesh)
    rng = np.random.default_rng(SEED)
    for constant, value in zip(pose.constants[3:], rng.uniform(-0.4, 0.4, 3), strict=True):
        constant.value = value
    density = density or Smooth(WIDTH, 0.7)
    contact = RigidContact(model.u, model.domain, ["above", "right"], shape, pose, density)
    motion = RigidMotion(body, pose, np.array([0.3, 0.1, -9.81]), model.comm)
    model.u.x.array[:] = 0.02 * rng.uniform(-1, 1, model.u.x.array.shape)
    model.u.x.array[model.supports[0].dof_indices()[0]] = 0.0
    # down until the nearest point is as near as asked
    for _ in range(60):
        least = contact.gaps_mm(model.u.x.array).min()
        pose.constants[2].value -= least - gap_mm
    model = Model(
        model.domain, model.u, model.potential, model.supports, {}, [motion, contact],
        global_unknowns=pose.free,
    )  # fmt: skip
    motion.accept()
    return model, contact, motion


@pytest.mark.parametrize("density", [Smooth(0.2, 3.0), TwoStage(0.2, 3.0)], ids=["smooth", "two"])
def test_density(density: Density) -> None:
    """Orders of Taylor's remainders; the two-stage one is the plate's in UFL."""
    gaps = np.array([0.01, 0.05, 0.08, 0.12, 0.15, 0.19, 0.25])
    w = np.array([1, -1, 1, 1, -1, -1, 1.0])
    found = density.at(gaps)
    assert found.energy[-1] == found.slope[-1] == found.curvature[-1] == 0
    assert (
        taylor.rates(lambda e: density.at(gaps + e * w).energy, found.slope * w, 1e-3).min() > 1.9
    )
    rates = taylor.rates(lambda e: density.at(gaps + e * w).slope, found.curvature * w, 1e-3)
    assert rates.min() > 1.9
    if isinstance(density, TwoStage):
        width, stiffness = ufl.as_ufl(density.width_mm), ufl.as_ufl(density.stiffness_MPa)
        form = [float(plate.energy(ufl.as_ufl(gap), width, stiffness)(())) for gap in gaps]
        np.testing.assert_allclose(found.energy, form, rtol=1e-14)


@every
def test_derivatives(shape: SignedDistance) -> None:
    """Of all unknowns: the gradient is the energy's, the tangent the gradient's."""
    print("seed", SEED)
    model, contact, _ = resting(shape, gap_mm=0.1)
    model.prescribe({"time_s": 0.01})  # so that there is inertia
    gaps = contact.gaps_mm(model.u.x.array)
    assert 2 <= (gaps < WIDTH).sum() < len(gaps)
    start = model.unknowns.owned()
    direction = np.random.default_rng(SEED + 1).uniform(-1, 1, start.shape)
    for bc in model.supports:
        direction[bc.dof_indices()[0]] = 0.0
    model.carried.reset()
    tangent = Tangent(model)
    tangent.assemble()
    taylor.check_derivatives(model, tangent, direction, 0.01)


@every
def test_points_that_move_with_the_mesh(shape: SignedDistance) -> None:
    """Where the reference moves, the gradient is that of a contact on the moved mesh.

    Areas grow linearly with the motion, so that the difference falls as its square.
    """
    model, contact, _ = resting(shape, gap_mm=0.1)
    mesh, dofs = model.domain.mesh, model.u.x.array
    rng = np.random.default_rng(SEED + 2)
    matrix = rng.uniform(-1, 1, (3, 3))
    field = model.u.copy()
    field.interpolate(lambda x: matrix @ x)

    def gradient(of: RigidContact) -> np.ndarray:
        found = Gradient(model.unknowns)
        of.add_gradient(dofs, found)
        return found.array

    step, start = 1e-5, gradient(contact)
    contact.move_reference(step * field.x.array)
    found = gradient(contact)
    contact.move_reference(None)
    np.testing.assert_array_equal(gradient(contact), start)
    kept = mesh.geometry.x.copy()
    mesh.geometry.x[:] += step * kept @ matrix.T
    regions = ["above", "right"]
    moved = RigidContact(model.u, model.domain, regions, shape, contact.pose, contact.density)
    mesh.geometry.x[:] = kept
    change = gradient(moved) - start
    scale = np.abs(change).max()
    assert scale > 0
    np.testing.assert_allclose(found - start, change, rtol=0, atol=1e-4 * scale)


@every
def test_no_step_leads_through(shape: SignedDistance) -> None:
    """Every point keeps a tenth of its distance all the way, whatever moves and turns."""
    print("seed", SEED)
    model, contact, _ = resting(shape, gap_mm=0.05)
    rng = np.random.default_rng(SEED + 3)
    start = model.unknowns.local()
    dofs = len(model.u.x.array)
    gaps = contact.gaps_mm(model.u.x.array)
    shortened = 0
    for size in (0.01, 0.1, 0.3, 1.0, 3.0) * 4:
        step = size * rng.uniform(-1, 1, start.shape)
        allowed = contact.max_step(start[:dofs], step)
        shortened += allowed < 1
        assert 0 < allowed <= 1
        for part in np.linspace(0, allowed, 30):
            model.unknowns.set_local(start + part * step)
            assert (contact.gaps_mm(model.u.x.array) >= (0.1 - 1e-9) * gaps).all()
        model.unknowns.set_local(start)
    assert shortened > 3
    # head-on it is nine tenths of the distance, but for what the shape curves away
    step = np.zeros_like(start)
    step[contact.pose.global_unknowns[2].place] = -1.0  # type: ignore[union-attr]
    allowed = contact.max_step(start[:dofs], step)
    assert 0.9 * gaps.min() - 1e-12 < allowed < 1.2 * gaps.min()


@pytest.mark.parametrize(
    "shape", [Plane((0.0, 0.0, 1.0)), BentCapsule(0.5, 0.9, 1.5)], ids=["plane", "bent"]
)
def test_no_step_leads_a_bodys_own_points_through(shape: SignedDistance) -> None:
    """Each keeps a tenth of its distance all the way, however the body moves and turns."""
    print("seed", SEED)
    model = blocks.model([blocks.Block("far", blocks.block((1, 1, 1)), MATERIAL)])
    body = RigidBody("body", 0.01, 0.01 * np.eye(3), (0.1, 0.2, 0.0))
    pose = body.pose(model.domain.mesh)
    rng = np.random.default_rng(SEED)
    for constant, value in zip(pose.constants[3:], (0.7, -0.4, 0.5), strict=True):
        constant.value = value
    skin = rng.normal(size=(200, 3))
    skin *= np.array([1.5, 0.6, 0.8]) / np.linalg.norm(skin, axis=1)[:, None]
    other = Pose([], np.zeros((6, 0)), np.zeros(6))
    areas = np.full(len(skin), 0.05)
    contact = RigidPoints(model.u, skin, areas, pose, shape, other, Smooth(WIDTH, 0.7))
    model = Model(
        model.domain,
        model.u,
        model.potential,
        model.supports,
        {},
        [contact],
        global_unknowns=pose.free,
    )
    dofs = model.u.x.array
    for _ in range(60):  # up until the nearest point is as near as asked
        pose.constants[2].value -= contact.gaps_mm(dofs).min() - 0.05
    start, gaps = model.unknowns.local(), contact.gaps_mm(dofs)
    shortened = 0
    for size in (0.01, 0.1, 0.3, 1.0, 3.0) * 6:
        step = np.zeros_like(start)
        for number in pose.free:
            step[number.place] = size * rng.uniform(-1, 1)
        allowed = contact.max_step(dofs, step)
        shortened += allowed < 1
        assert 0 < allowed <= 1
        for part in np.linspace(0, allowed, 30):
            model.unknowns.set_local(start + part * step)
            assert (contact.gaps_mm(dofs) >= (0.1 - 1e-9) * gaps).all()
        model.unknowns.set_local(start)
    assert shortened > 3
    step = np.zeros_like(start)
    step[pose.global_unknowns[2].place] = -1.0  # type: ignore[union-attr]
    allowed = contact.max_step(dofs, step)
    assert 0.9 * gaps.min() - 1e-12 < allowed < 1.2 * gaps.min()


def test_free_fall_and_spin() -> None:
    """Implicit Euler's own solutions: y_n = −g h² n(n + 1)/2; tan Δθ' = sin Δθ/(2 − cos Δθ)."""
    model, contact, motion = resting(Capsule(0.4, 0.0), gap_mm=50.0)
    pose, step_s = contact.pose, 0.002
    inertia = motion.body.inertia_kg_mm2
    values, axes = np.linalg.eigh(inertia)
    axis = axes[:, int(values.argmax())]
    for constant in pose.constants[3:]:
        constant.value = 0.0
    motion.accept()
    first = 0.05
    # as if the last step had been a turn by so much
    turning = (np.eye(3) - Rotation.from_rotvec(-first * axis).as_matrix()) / step_s
    motion.motion.start(
        np.vstack([np.zeros(3), motion.body.gyration_mm * turning]), np.zeros((4, 3))
    )
    height, turned, turn = pose.coordinates[:3], 0.0, first
    newton = Newton(model, Solver(rtol=1e-12, atol_N=1e-15))
    model.u.x.array[:] = 0.0
    for n in range(1, 5):
        model.prescribe({"time_s": n * step_s})
        assert newton.solve().converged
        model.accept_step()
        turn = np.arctan2(np.sin(turn), 2 - np.cos(turn))
        turned += turn
        q = pose.coordinates
        fallen = 1e3 * motion.gravity_m_s2 * step_s**2 * n * (n + 1) / 2
        np.testing.assert_allclose(q[:3] - height, fallen, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(q[3:], turned * axis, rtol=1e-8, atol=1e-12)


def test_a_free_sphere_settles_on_a_block() -> None:
    """The whole pose is free: inertia holds what no contact does; at rest the block bears it."""
    block = blocks.Block(
        "block", blocks.block((4, 4, 4)), MATERIAL,
        held={axis: ["below"] for axis in range(3)},
    )  # fmt: skip
    model = blocks.model([block])
    sphere = ball("sphere", 0.02, 2.0, (0.5, 0.5, 3.0 + 0.02))
    pose = sphere.pose(model.domain.mesh)
    contact = RigidContact(
        model.u, model.domain, ["above"], Capsule(2.0, 0.0), pose, TwoStage(0.02, 5.0)
    )
    motion = RigidMotion(sphere, pose, np.array([0, 0, -9.81]), model.comm)
    model = Model(
        model.domain, model.u, model.potential, model.supports, {}, [motion, contact],
        global_unknowns=pose.free,
    )  # fmt: skip
    motion.accept()
    newton = Newton(model, Solver(rtol=1e-9, max_iterations=60))
    # long steps of implicit Euler take all energy at once
    for time_s in (0.01, 0.1, 1.0, 10.0, 100.0):
        model.prescribe({"time_s": time_s})
        assert newton.solve().converged
        model.accept_step()
    weight = 0.02 * 9.81
    load = contact.load_N(model.u.x.array)
    np.testing.assert_allclose(load[:3], [0, 0, weight], atol=1e-5 * weight)
    assert model.reactions()[:, 2].sum() == pytest.approx(weight, rel=1e-5)
    q = pose.coordinates
    assert 1.85 < q[2] - 1 < 2.0
    np.testing.assert_allclose(q[[0, 1, 3, 4, 5]], [0.5, 0.5, 0, 0, 0], atol=1e-2)


@every
def test_friction_follows_all_unknowns(shape: SignedDistance) -> None:
    """Rows, normal forces and friction's forces along a step of points and body together.

    The length of a sampled distance's gradient changes, too, which 2 % of the largest rise allow.
    """
    print("seed", SEED)
    model, contact, _ = resting(shape, gap_mm=0.1)
    mu = fem.Constant(model.domain.mesh, PETSc.ScalarType(0.4))
    friction = Friction(contact, model.u, mu)
    rng, size = np.random.default_rng(SEED + 2), model.unknowns.owned().shape
    along, before = (model.unknowns.to_local(rng.uniform(-1, 1, size)) for _ in range(2))
    local = model.unknowns.local() + 0.01 * before  # points slip by about half of what they may
    model.unknowns.set_local(local)
    assert friction.update_lagged(model.u.x.array)
    nodes, first = contact.touching, contact.tangential(model.u.x.array)
    moved = nodes.change(along)

    def rows(step: float) -> np.ndarray:
        model.unknowns.set_local(local + step * along)
        return nodes.at_nodes(model.u.x.array)

    assert taylor.rates(rows, moved, 1e-3).min() > 1.9
    pressed = []
    for step in (1e-5, -1e-5):
        model.unknowns.set_local(local + step * along)
        now = contact.tangential(model.u.x.array)
        np.testing.assert_array_equal(now.keys, first.keys)
        pressed.append(now.normal_N)
    rise = first.pressed_more_N(moved, contact.facing(along))
    difference = (pressed[0] - pressed[1]) / 2e-5
    np.testing.assert_allclose(rise, difference, atol=0.02 * np.abs(rise).max())
    assert (rise < 0).any()
    assert (rise > 0).any()

    model.unknowns.set_local(local)
    correction = friction.lagged_correction(model.u.x.array)
    assert correction is not None

    def change(step: float) -> np.ndarray:
        found = Gradient(model.unknowns)
        correction.add_change(step * along, found)
        return found.array

    rate = Gradient(model.unknowns)
    correction.add_rate(along, rate)
    assert taylor.rates(change, rate.array, 1e-3).min() > 1.9
    rows = model.unknowns.global_rows(np.arange(len(rate.array)))
    assert np.abs(rate.array[rows]).max() > 0


@pytest.mark.parametrize("length", [0.6, 1.0, 1.5])
def test_friction_s_normal_forces_are_by_mm_where_the_gradient_is_longer_or_shorter(
    length: float,
) -> None:
    """Force and rise are derivatives of the energy by the body's way along its normal.

    φ is ``length`` times the distance from a plane, as a sampled one may be: its values are those
    of differences of the energy and of the forces, whatever its gradient's length is.
    """
    model, contact, _ = resting(Plane((0.0, 0.0, -length)), gap_mm=0.1 * length)
    first = contact.tangential(model.u.x.array)
    normal = first.normals[0]
    np.testing.assert_allclose(first.normals, np.tile(normal, (len(first.keys), 1)))
    assert len(first.keys) >= 2

    def moved(way_mm: float) -> tuple[float, np.ndarray]:
        """Energy and normal forces after the plane has come nearer by a way."""
        for constant, part in zip(contact.pose.constants[:3], way_mm * normal, strict=True):
            constant.value += part
        energy = contact.value(model.u.x.array)
        found = contact.tangential(model.u.x.array).normal_N
        for constant, part in zip(contact.pose.constants[:3], way_mm * normal, strict=True):
            constant.value -= part
        return energy, found

    step = 1e-6
    (more, nearer), (less, farther) = moved(step), moved(-step)
    assert first.normal_N.sum() == pytest.approx((more - less) / (2 * step), rel=1e-6)
    np.testing.assert_allclose(first.rise_N_per_mm, (nearer - farther) / (2 * step), rtol=1e-6)
