"""Pressure below that of the air around: walls that meet, cycles through 0, limits."""

from __future__ import annotations

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI
from support import fingers, small
from support.passing import WholeSurface, crossings

from dolfingrip import config as configuration
from dolfingrip.config import ConfigError
from dolfingrip.experiments import pressures_kPa, run
from dolfingrip.experiments.index import find
from dolfingrip.experiments.protocol import pressure_stops
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.finger_rig import FingerRig
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.model.domain import distribute
from dolfingrip.mechanics.model.element import displacement_element
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import State
from dolfingrip.sections import protocol_file
from dolfingrip.sections.tables import assignments

SOFT = {
    "finger": {"kind": "cast"},
    "cast": {
        "chambers": 1, "chamber_height_mm": 10.0, "chamber_width_mm": 10.0,
        "chamber_length_mm": 2.0, "wall_mm": 4.0, "tube": False,
    },
    "material": {"mu_MPa": 0.03, "nu": 0.45},
    "mesh": {"size_mm": 8.0},
}  # fmt: skip
"""A block of silicone with one narrow chamber."""


class Watched:
    """Looks at every accepted state."""

    def __init__(self, finger: FingerModel) -> None:
        self._surface = WholeSurface(finger)
        self.states, self.passing = 0, 0

    def converged(self, before: State) -> None:
        self.states += 1
        self.passing += self._surface.passing()


def watched_run(config: configuration.Config) -> tuple[Watched, list[dict[str, float]]]:
    """Bend a finger, look at every accepted state, and read at each stop."""
    experiment = find("bend")
    rig = experiment.prepare(experiment.settings(config), MPI.COMM_SELF, Profile())
    assert isinstance(rig, FingerRig)
    watched = Watched(rig.specimen)
    path = rig.path([watched])
    rows = []
    for stop in experiment.schedule(config):
        assert path.advance(rig.controls(stop)).failure is None
        rows.append(rig.read())
    return watched, rows


def test_triangles_that_pass_are_found() -> None:
    """An edge through a triangle, and one beside it."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [2, 2, 2.0]])
    triangles = np.array([[0, 1, 2]])
    assert crossings(points, triangles, np.array([[3, 4], [4, 5]])) == 1


@pytest.mark.slow
@pytest.mark.parametrize("inside", [True, False], ids=["contact", "none"])
def test_walls_of_a_chamber_meet_and_do_not_pass(
    inside: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every triangle of every accepted state; without contact inside they pass one another."""
    if not inside:
        monkeypatch.setattr(type(configuration.Config()), "walls_may_meet", lambda *_: False)
    config = configuration.from_dict(
        {**SOFT, "experiment": {"max_pressure_kPa": -8.0, "step_kPa": 4.0}}
    )
    watched, rows = watched_run(config)
    print(watched.states, watched.passing, [row["cavity_volume_mm3"] for row in rows])
    assert (watched.passing == 0) is inside
    if inside:
        assert 0 < rows[-1]["wall_gap_mm"] < 0.2
        assert all(row["cavity_volume_mm3"] > 0 for row in rows)


@pytest.mark.parametrize("nodes", [True, False], ids=["nodes", "contact points"])
def test_outer_corners_of_bellows_meet_and_do_not_pass(
    nodes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Contact points of the skin are spread; without contact of its nodes some of them pass."""
    if not nodes:
        monkeypatch.setattr(Surface, "interpolated", False)
    short = ["finger.length_mm=36", "finger.bellows=2"]
    sucked = ["experiment.max_pressure_kPa=-75", "experiment.step_kPa=75"]
    watched, _ = watched_run(configuration.load(None, assignments([*short, *sucked])))
    print(watched.states, watched.passing)
    assert (watched.passing == 0) is nodes


def test_walls_are_kept_apart_between_nodes_too() -> None:
    """Quadratic facets pass between their nodes; no contact point is far from its neighbours."""
    config = small.short("experiment.max_pressure_kPa=-10", "contact.spacing_mm=1.5")
    terms = small.model(config, plate=False).model.terms
    contacts = [each for each in terms if isinstance(each, BarrierContact)]
    inside = [each for each in contacts if each.title == "the wall of cavity"]
    longest = []
    for contact in inside:
        ends = contact.surface.rest[contact.surface.edges]
        longest.append(float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max()))
    nodes, points = longest
    assert nodes > 2.5  # mm; midpoints of elements of 6 mm
    assert points < 1.5 * np.sqrt(2) + 1e-9


def test_a_half_with_its_image_has_the_energy_of_the_whole() -> None:
    """A cavity that ends on the plane of symmetry, in a motion that is its own mirror image."""
    half = fingers.half_mesh()
    found = []
    for solid in (half, fingers.mirrored(half)):
        domain = distribute(MPI.COMM_SELF, solid)
        space = fem.functionspace(domain.mesh, displacement_element("P2"))
        u = fem.Function(space)
        u.interpolate(lambda x: np.array([0 * x[0], -0.97 * x[1], 0 * x[0]]))
        surface = Surface(space, domain, domain.facets("cavity"), None)
        surface = surface.mirrored() if domain.half else surface
        contact = BarrierContact(surface, 0.4, 0.005)
        gradient = np.zeros_like(u.x.array).reshape(-1, 3)
        surface.add_owned(contact.gradient(u.x.array), gradient)
        way = fem.Function(space)
        way.interpolate(lambda x: np.array([x[2], x[1] * x[0], x[0]]))
        found.append(
            (len(surface.triangles), contact.value(u.x.array), gradient.ravel() @ way.x.array)
        )
    (count, energy, slope), (whole, whole_energy, whole_slope) = found
    print(found)
    assert count == whole
    # the vertices are not in the same order, so those of edges on one line move by other 1e-7
    assert energy == pytest.approx(whole_energy, rel=1e-4)
    assert slope == pytest.approx(whole_slope, rel=1e-3)
    assert energy > 0


def test_the_two_faces_of_a_wall_repel_one_another() -> None:
    """The pairs of all surfaces are those within skin and cavity, and those between the two."""
    domain = distribute(MPI.COMM_SELF, fingers.half_mesh())
    space = fem.functionspace(domain.mesh, displacement_element("P2"))
    u = fem.Function(space)
    u.interpolate(lambda x: np.array([-0.95 * x[0], 0 * x[1], 0 * x[2]]))
    names = ("skin", "tip", "cavity")
    every, outside, inside = (
        Surface(space, domain, domain.facets(*some), None) for some in (names, names[:2], names[2:])
    )
    whole, outer, inner = (BarrierContact(each, 0.1, 0.005) for each in (every, outside, inside))
    faces = BarrierContact(every, 0.1, 0.005, separate=True)
    energies = [each.value(u.x.array) for each in (whole, outer, inner, faces)]
    print(energies)
    assert energies[3] > 0.01 * energies[0]
    assert sum(energies[1:]) == pytest.approx(energies[0], rel=1e-4)
    assert faces.max_step(u.x.array, 0.1 * u.x.array) < 1  # it would turn the wall inside out
    # of a finger that is sucked, the skin and its cavities are all the parts
    config = small.short("experiment.max_pressure_kPa=-10")
    terms = small.model(config, plate=False).model.terms
    assert [each for each in terms if isinstance(each, BarrierContact) and each.separate]


def test_stops_go_to_suction_first() -> None:
    """0, suction, 0, the highest pressure and back, in each cycle."""
    asked = ("experiment.min_pressure_kPa=-60", "experiment.step_kPa=50")
    config = small.short(*asked, "experiment.max_pressure_kPa=100", "experiment.cycles=2")
    once = [-50, -60, -50, 0, 50, 100, 50, 0]
    assert pressures_kPa(config) == [0, *once, *once]
    branches = [stop.branch for stop in pressure_stops(config)]
    assert branches[1:9] == [
        *2 * ["loading"], *2 * ["unloading"], *2 * ["loading"], *2 * ["unloading"],
    ]  # fmt: skip
    times = np.diff([stop.time_s for stop in pressure_stops(config)])
    rate = config.experiment.rate_kPa_per_s
    assert times == pytest.approx(np.abs(np.diff(pressures_kPa(config))) / rate)
    assert pressures_kPa(small.short("experiment.max_pressure_kPa=-40")) == [0, -25, -40]
    assert configuration.load(None, {"experiment.max_pressure_kPa": -5.0}).experiment.step_kPa == 5


def test_a_protocol_goes_through_0(tmp_path) -> None:  # type: ignore[no-untyped-def]
    file = tmp_path / "protocol.toml"
    file.write_text("[[segment]]\nto_kPa = -60\nreadings = 1\n[[segment]]\nto_kPa = 60\n")
    table, _ = protocol_file.read(file, "bending")
    assert table["pressure_kPa"] == [0, -60, -30, 0, 30, 60]
    assert table["branch"] == [*2 * ["loading"], *2 * ["unloading"], *2 * ["loading"]]
    assert small.short().changed(protocol=table).pressures_kPa == (-60, 60)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("max_pressure_kPa", -120.0, "below absolute vacuum; allowed: from -101.3 kPa on"),
        ("min_pressure_kPa", -120.0, "below absolute vacuum; allowed: from -101.3 kPa on"),
        ("min_pressure_kPa", 1, "allowed: at least -10000 and at most 0 kPa"),
        ("max_pressure_kPa", 0.0, "allowed: any pressure but 0 kPa"),
    ],
)
def test_no_pump_goes_below_vacuum(key: str, value: float, said: str) -> None:
    with pytest.raises(ConfigError, match=f"experiment.{key} = {value}: {said}"):
        configuration.load(None, {f"experiment.{key}": value})


def test_what_needs_another_control_is_refused() -> None:
    for control in ("volume", "auto"):
        with pytest.raises(ConfigError, match=r'experiment.control = .*with suction: "pressure"'):
            small.short(f"experiment.control={control}", "experiment.min_pressure_kPa=-10")
    with pytest.raises(ConfigError, match=r"cavity.cavity.pressure_ratio = -3.0: -150 kPa in it"):
        configuration.load(None, assignments(["cavity.cavity.pressure_ratio=-3",
                                              "experiment.max_pressure_kPa=50"]))  # fmt: skip


def test_contact_inside_costs_nothing_where_nothing_is_near() -> None:
    """The default run has none; with it, a run that only inflates takes the same iterations."""
    plain = small.short("experiment.step_kPa=25")
    assert not plain.walls_may_meet(["cavity"])
    asked = small.short("experiment.step_kPa=25", "experiment.min_pressure_kPa=-1e-9")
    assert asked.walls_may_meet(["cavity"])
    assert plain.changed(cavity={"cavity": {"pressure_ratio": 0.5}}).walls_may_meet(
        ["cavity", "cavity_2"]
    )
    one, other = (run("bending", each, comm=MPI.COMM_SELF) for each in (plain, asked))
    np.testing.assert_allclose(one["angle_deg"][1:], other["angle_deg"][-2:], rtol=1e-6)
    assert one["iterations"][1:].sum() == other["iterations"][-2:].sum()


def test_the_gap_of_walls_is_that_of_opposite_ones() -> None:
    """A chamber of 2 mm: 2 mm at rest, however near nodes of a corner are to the wall beside it.

    Shrunk along z alone, its gap is as much smaller.
    """
    table = {**SOFT["cast"], "chamber_height_mm": 3.0, "chamber_width_mm": 3.0}
    config = configuration.from_dict(
        {**SOFT, "cast": table, "mesh": {"size_mm": 4.0, "edge_size_mm": 0.5},
         "experiment": {"max_pressure_kPa": -8.0}}
    )  # fmt: skip
    finger = small.model(config, plate=False)
    (walls,) = finger.site.walls.values()
    u = finger.model.u
    assert walls.gap_mm(u.x.array, 5.0) < 0.5
    for share in (0.0, 0.3, 0.9):
        u.interpolate(lambda x, by=share: np.stack([0 * x[0], 0 * x[0], -by * x[2]]))
        near = walls.opposite_mm(u.x.array, 5.0)
        assert near == pytest.approx(2.0 * (1 - share), rel=1e-3)
