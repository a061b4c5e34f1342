"""Several deformable bodies of different materials in one model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import ufl
from dolfinx import fem
from support import blocks
from support.stacks import NU, PUSH, STIFFNESS, TOP, WIDTH, is_upper

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.meshes.solid import MeshError, merged, second_order

SOFT, STIFF = blocks.NeoHooke(2.0, NU), blocks.NeoHooke(5.0, NU)
SYMMETRY = {0: ["left"], 1: ["front"]}


def stacked(lower: int, upper: int) -> list[blocks.Block]:
    """Unit cubes, soft below and stiff above, one barrier's width apart along z."""
    above = blocks.block((upper,) * 3, origin=(0.0, 0.0, 1 + WIDTH))
    return [
        blocks.Block("pad", blocks.block((lower,) * 3), SOFT, held={**SYMMETRY, 2: ["below"]}),
        blocks.Block("block", above, STIFF, held={**SYMMETRY, 2: ["above"]}),
    ]


@pytest.mark.parametrize(("lower", "upper"), [(3, 3), (3, 4)], ids=["matching", "not matching"])
def test_bodies_pressed_together(lower: int, upper: int) -> None:
    """Bars of different moduli in series with the gap: push − closing = F (1/E₁ + 1/E₂).

    See test_contact_patch, whose cubes are alike; also for what unevenness is the barrier's.
    """
    model = blocks.model(stacked(lower, upper))
    domain, space = model.domain, model.u.function_space
    assert set(domain.parts) == {"pad", "block"}
    surface = Surface(space, domain, domain.facets(*domain.regions))
    model.terms = [BarrierContact(surface, WIDTH, STIFFNESS)]
    points = space.tabulate_dof_coordinates()
    z = points[:, 2]
    model.u.x.array[:] = np.where(is_upper(points)[:, None], [0, 0, -PUSH], 0.0).ravel()
    assert Newton(model, Solver(rtol=1e-9, max_iterations=60)).solve().converged

    u, forces = model.u.x.array.reshape(-1, 3), model.reactions()
    below, above = np.isclose(z, 1.0), np.isclose(z, 1 + WIDTH)
    closing = u[below, 2].mean() - u[above, 2].mean()
    ends = [forces[np.isclose(z, level), 2].sum() for level in (0.0, TOP)]
    bars = (PUSH - closing) / (1 / SOFT.young_MPa + 1 / STIFF.young_MPa)
    print("force", ends, "bars", bars, "gap closed by", closing)
    assert ends[0] == pytest.approx(-ends[1], rel=1e-6)
    assert abs(ends[0]) == pytest.approx(bars, rel=0.01)
    assert 0.0 < closing < 0.05 * WIDTH
    assert max(np.ptp(u[below, 2]), np.ptp(u[above, 2])) < 1.5 * closing
    # at the far ends: where they touch, the wider one's edges are held back by the narrower one's
    for material, end in ((SOFT, 0.0), (STIFF, TOP)):
        widening = u[np.isclose(z, end) & np.isclose(points[:, 0], 1.0), 0].mean()
        print("widening", widening, NU * bars / material.young_MPa)
        assert widening == pytest.approx(NU * bars / material.young_MPa, rel=0.02)


@pytest.mark.parametrize("carried", [True, False])
def test_regions_of_one_body(carried: bool) -> None:
    """Two materials in one bar that does not narrow: F = δ/(1/E₁ + 1/E₂) at small strain."""
    solid = blocks.block((2, 2, 4), (1.0, 1.0, 2.0))
    upper = solid.points[solid.cells].mean(axis=1)[:, 2] > 1
    materials = {"soft": blocks.NeoHooke(2.0, 0.0), "stiff": blocks.NeoHooke(5.0, 0.0)}
    cells = {"soft": np.flatnonzero(~upper), "stiff": np.flatnonzero(upper)}
    held = {**SYMMETRY, 2: ["below", "above"]}
    bar = blocks.Block("bar", replace(solid, regions=cells), materials, held)
    model = blocks.model([bar], carried=carried)
    assert set(model.domain.parts) == {"soft", "stiff"}
    assert "above" in model.domain.regions
    push = 1e-6
    points = model.u.function_space.tabulate_dof_coordinates()
    model.u.x.array[:] = np.where(np.isclose(points[:, 2:], 2.0), [0, 0, -push], 0.0).ravel()
    assert Newton(model, Solver(rtol=1e-11)).solve().converged
    force = model.reactions()[np.isclose(points[:, 2], 0.0), 2].sum()
    assert force == pytest.approx(push / (1 / 2.0 + 1 / 5.0), rel=1e-5)


def test_a_lone_body_is_what_a_mesh_is() -> None:
    """No parts, plain names, and one integral over everything: nothing is recompiled."""
    lone = blocks.Block("finger", blocks.block((1, 1, 1)), SOFT)
    domain = blocks.domain([lone])
    assert domain.parts == {}
    assert set(domain.regions) == set(blocks.SIDES)
    measure = domain.volume(quadrature_degree=1)
    assert measure == ufl.Measure("dx", domain.mesh, metadata={"quadrature_degree": 1})
    assert not isinstance(blocks.energies(domain, [lone]), dict)


def test_bodies_of_one_material_share_its_energy() -> None:
    solids = [
        blocks.Block(name, blocks.block((1, 1, 1), origin=(x, 0, 0)), SOFT)
        for name, x in (("a", 0.0), ("b", 2.0))
    ]
    domain = blocks.domain(solids)
    assert not isinstance(blocks.energies(domain, solids), dict)
    one = fem.Constant(domain.mesh, 1.0)
    for names in (("a",), ("b",), ("a", "b"), ()):
        volume = fem.assemble_scalar(fem.form(one * domain.volume(*names)))
        assert volume == pytest.approx(2 if len(names) != 1 else 1, rel=1e-12)
    area = fem.assemble_scalar(fem.form(one * domain.surface("b/above")))
    assert area == pytest.approx(1, rel=1e-12)


def test_elements_of_different_kinds_are_refused() -> None:
    box = blocks.block((1, 1, 1))
    said = "tetrahedra of order 1, tetrahedra of order 2; allowed: elements of one shape"
    with pytest.raises(MeshError, match=said):
        merged([box, second_order(box)])
