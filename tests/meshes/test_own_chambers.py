"""Chambers with dimensions of their own: meshes, solids, mass, derivatives and refusals.

References: volumes by hand; OpenCASCADE's volume of the solid model, which no mesh is part of;
differences of the same numbers, of order h², at meshes made anew.
"""

from __future__ import annotations

from typing import Any

import gmsh
import numpy as np
import pytest

from dolfingrip import config
from dolfingrip.config import Config, ConfigError, changed, felt
from dolfingrip.experiments.derivatives.gradients import shape_number
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.rigs.undeformed import placed, solid, straight, unplaced
from dolfingrip.experiments.simulate import compute
from dolfingrip.meshes.dimensions import moved
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.measures import moments
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid_model import add_finger
from dolfingrip.meshes.walls import facing
from dolfingrip.parameter import find
from dolfingrip.sections.form import Form

COARSE = {"mesh.size_mm": 8.0, "mesh.edge_size_mm": 8.0}
MANY = {
    "finger.override.1.depth_mm": 18.0,
    "finger.override.3.depth_mm": 14.0,
    "finger.override.4.base_layer_mm": 5.0,
    "finger.override.5.wall_mm": 1.2,
    "finger.override.6.width_mm": 16.0,
    "finger.override.7.width_mm": 23.0,
    "finger.along.gap_mm": [1.5, 2.5, 2.0],
}
PNEUNET = {
    "finger.kind": "pneunet",
    "pneunet.along.chamber_height_mm": [8.0, 12.0],
    "pneunet.override.1.chamber_width_mm": 12.0,
    "pneunet.override.3.wall_mm": 1.0,
    "pneunet.override.5.chamber_length_mm": 8.0,
    "pneunet.override.8.roof_mm": 1.5,
}
SHARED = Config()


def made(change: dict[str, Any], **further: Any) -> Config:
    return changed(SHARED, {**COARSE, **change, **further})


def whole_mm3(found: Config) -> float:
    return 2 * moments(solid(found))[0]


def modelled_mm3(found: Config) -> float:
    with session("solid model"):
        return float(gmsh.model.occ.getMass(3, add_finger(found.geometry, half=False)))


def test_a_shallower_bellows_lacks_what_its_roof_is_lower() -> None:
    """2 mm less depth: of both walls across z, of both sides, 7.25 mm long and 20 mm wide."""
    length, wall, width = SHARED.finger.bellows_mm, 1.6, 20.0
    lost = 2 * (2 * wall * width + 2 * (length - 2 * wall) * wall)
    found = whole_mm3(made({"finger.override.3.depth_mm": 14.0}))
    assert whole_mm3(made({})) - found == pytest.approx(lost, rel=1e-9)


@pytest.mark.parametrize("change", [MANY, PNEUNET], ids=["bellows", "pneunet"])
def test_meshes_have_the_volume_of_the_solid_model(change: dict[str, Any]) -> None:
    found = made(change)
    check(solid(found))
    expected = modelled_mm3(found)
    assert abs(expected / modelled_mm3(made({"finger.kind": found.finger.kind})) - 1) > 1e-4
    assert whole_mm3(found) == pytest.approx(expected, rel=1e-10)


def test_tetrahedra_have_the_volume_of_the_solid_model() -> None:
    found = made(MANY, **{"solver.element": "P2"})
    assert whole_mm3(found) == pytest.approx(modelled_mm3(found), rel=1e-10)


def test_round_bellows_have_crowns_of_their_own() -> None:
    round_ = {"finger.kind": "round_bellows", "solver.element": "P2"}
    found = made(round_ | {"round_bellows.override.3.crown_radius_mm": 10.0})
    shared = modelled_mm3(made(round_))
    ring, inner = 12.5**2 - 10**2, (12.5 - 0.8) ** 2 - (10 - 0.8) ** 2
    lost = 2 * np.pi * (4.5 * ring - (4.5 - 2 * 0.8) * inner)  # of both bellows
    assert shared - modelled_mm3(found) == pytest.approx(lost, rel=1e-9)
    longer = made(round_ | {"round_bellows.override.3.pitch_mm": 9.0})
    assert longer.geometry.length_mm == pytest.approx(2 * 5.0 + 8 * 7.0 + 2.0)


@pytest.mark.parametrize(
    ("change", "keys"),
    [
        (MANY, [*MANY, "finger.override.2.depth_mm", "finger.depth_mm"]),
        (PNEUNET, [each for each in PNEUNET if "." in each and each != "finger.kind"]),
    ],
    ids=["bellows", "pneunet"],
)
@pytest.mark.parametrize("name", ["mass_g", "cog_offset_mm"])
def test_derivatives_of_mass_and_centre(change: dict[str, Any], keys: list[str], name: str) -> None:
    found, step = made(change), 1e-3
    parameters = find(found, keys)
    _, slopes = shape_number(name, found, parameters)
    for each in parameters:
        ends = [
            shape_number(name, each.at(found, each.value(found) + by), ())[0]
            for by in (step, -step)
        ]
        assert slopes[each.key] == pytest.approx((ends[0] - ends[1]) / 2 / step, rel=1e-6, abs=1e-8)


def test_a_mesh_moves_back_and_forth() -> None:
    """From the shared dimensions to those of chambers, as a design that begins there does."""
    shared, own = made({}), made(MANY)
    there = straight(own, shared.geometry).points
    np.testing.assert_allclose(there, straight(own).points, atol=1e-12)
    back = moved(there, own.geometry, shared.geometry)
    np.testing.assert_allclose(back, straight(shared).points, atol=1e-12)


def test_a_free_form_bends_them_too() -> None:
    boxes = SHARED.geometry.boxes()
    assert boxes is not None
    count = Form(along=4, offsets_mm=()).count(boxes)
    offsets = np.random.default_rng(3).uniform(-0.2, 0.2, count).tolist()
    found = made(MANY | {"form.along": 4, "form.offsets_mm": offsets, "morph.xi2": 0.2})
    points = straight(found).points
    np.testing.assert_allclose(unplaced(placed(points, found), found), points, atol=1e-11)
    np.testing.assert_allclose(solid(found).points, placed(points, found), atol=1e-12)


def test_least_walls_and_gaps_are_those_of_the_chambers() -> None:
    found = made({key: MANY[key] for key in ("finger.override.5.wall_mm", "finger.along.gap_mm")})
    walls, gaps, _ = facing(found.geometry, found.mesh)
    assert walls.distances(walls.corners).min() == pytest.approx(1.2, rel=5e-3)
    assert gaps.distances(gaps.corners).min() == pytest.approx(1.5)


def test_readings_have_derivatives_by_each() -> None:
    """The angle of three bellows at 20 kPa, against differences on the moving mesh."""
    short = {"finger.bellows": 3, "finger.length_mm": 45.0, "finger.override.2.depth_mm": 14.0}
    keys = ["finger.override.2.depth_mm", "finger.override.3.width_mm"]
    start, step = made(short, **{"solver.rtol": 1e-11}), 2e-3

    def angle(found: Config, keys: list[str] | None = None) -> Any:
        places, columns = (Place("pressure_kPa", 20.0),), ("angle_deg",)
        return compute(
            Request.of("bending", found, keys, columns=columns, places=places, made_for=start)
        )

    slopes = angle(start, keys).slopes
    for each in find(start, keys):
        ends = [each.at(start, each.value(start) + by) for by in (step, -step)]
        up, down = (float(angle(end).columns["angle_deg"][0]) for end in ends)
        expected = (up - down) / 2 / step
        assert slopes["angle_deg", each.key][0] == pytest.approx(expected, rel=1e-5)


def test_printed_walls_are_all_thicker() -> None:
    found = made(
        {
            "finger.override.3.wall_mm": 1.2,
            "finger.along.wall_mm": [1.4, 2.1],
            "extensions.wall_offset.offset_mm": 0.1,
        }
    ).adapted()
    walls = [found.finger.of(i).wall_mm for i in range(8)]
    assert walls == pytest.approx([1.5, 1.6, 1.3, *(1.5 + 0.1 * i for i in range(3, 8))])


def test_results_without_them_keep_their_keys() -> None:
    assert not {"override", "along"} & felt(SHARED)["finger"].keys()
    own = made({"finger.override.3.depth_mm": 14.0})
    assert felt(own)["finger"]["override"] == {"3": {"depth_mm": 14.0}}
    assert config.from_dict(own.model_dump(mode="json")) == own


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"finger.override.3.depth_mm": 4.0},
            "finger.override.3.depth_mm = 4.0: allowed: at least 9.21 mm, beside",
        ),
        (
            {"finger.override.2.wall_mm": 3.9},
            "finger.override.2.wall_mm = 3.9: allowed: at most 3.495 mm, beside",
        ),
        (
            {"finger.override.3.depth_mm": -4.0},
            "finger.override.3.depth_mm = -4.0: allowed: at least 0.001 and at most 500 mm",
        ),
        ({"finger.override.9.depth_mm": 14.0}, "finger.override.9 = a table: allowed: 1 to 8"),
        (
            {"finger.override.3.length_mm": 14.0},
            "finger.override.3.length_mm: unknown key; did you mean finger.length_mm",
        ),
        (
            {"finger.along.depth_mm": [14.0]},
            "finger.along.depth_mm = [14.0]: allowed: a list of 2 to 60 numbers",
        ),
        (
            {"finger.along.depth_mm": [14.0, 4.0]},
            "finger.along.depth_mm = [14.0, 4.0]: 8.286 mm in number 5 from the clamp; allowed: "
            "at least 9.21 mm there",
        ),
        (
            {"finger.along.depth_mm": [14.0] * 9},
            "finger.along.depth_mm = [14.0, 14.0, 14.0, 14.0, 14.0, 14.0, 14.0, 14.0, 14.0]: "
            "allowed: 2 to 8 values",
        ),
        (
            {"finger.override.3.depth_mm": 14.0, "mesh.file": "part.msh"},
            "mesh.file = part.msh: allowed: without [finger.override] and [finger.along]",
        ),
    ],
)
def test_refused(change: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        made(change)
    assert str(caught.value).startswith(said)
