"""At what strengths effects are tried."""

from __future__ import annotations

import math

import pytest

from dolfingrip.config import Config
from dolfingrip.diagnosis.simulation.strengths import TriedEffect, ordinary
from dolfingrip.extensions.index import NAMES

TRIED = {each.effect: each for each in ordinary(Config())}


def test_the_whole_catalogue_is_tried_but_the_mesh() -> None:
    assert set(TRIED) == set(NAMES) - {"coarse_mesh"}
    for each in TRIED.values():
        for shape in each.shapes:
            on = Config().overridden(shape.overrides).extensions.active()
            assert [effect.name() for effect in on] == [each.effect]


def test_strength_is_the_mean_or_a_spread_from_neutral() -> None:
    assert TRIED["mooney_rivlin"].shapes[0].overrides == ("extensions.mooney_rivlin.C01_MPa=1.36",)
    assert TRIED["mooney_rivlin"].spread == pytest.approx(math.hypot(1, 0.4 / 1.36))
    assert TRIED["force_gain"].shapes[0].overrides == ("extensions.force_gain.gain=1.01",)
    assert TRIED["force_gain"].spread == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("effect", "one_sided"),
    [("mooney_rivlin", True), ("prony", True), ("plate_friction", True), ("line_lag", True),
     ("ogden", False), ("yeoh", False), ("print_anisotropy", False), ("force_offset", False),
     ("no_self_contact", True)],
)  # fmt: skip
def test_one_sided(effect: str, one_sided: bool) -> None:
    assert TRIED[effect].one_sided == one_sided


@pytest.mark.parametrize(
    ("effect", "count"),
    [("gent", 1), ("prony", 3), ("permanent_set", 3), ("mullins", 1), ("ogden", 3),
     ("line_lag", 3), ("yeoh", 3), ("print_anisotropy", 1)],
)  # fmt: skip
def test_shapes(effect: str, count: int) -> None:
    found = TRIED[effect]
    assert len({shape.overrides for shape in found.shapes}) == len(found.shapes) == count


def test_shapes_go_to_either_side_of_the_prior() -> None:
    """Log-normal of mean 30 and spread 60 s: median 30/√5, spread of the logarithm √ln 5."""
    times = [float(s.overrides[1].split("=[")[1][:-1]) for s in TRIED["prony"].shapes]
    factor = math.exp(1.5 * math.sqrt(math.log(5)))
    median = 30 / math.sqrt(5)
    assert times == pytest.approx([median, median / factor, median * factor], rel=1e-5)


def test_other_amplitudes_are_parts_of_the_ordinary_one() -> None:
    for shape in TRIED["ogden"].shapes:
        alpha = float(shape.overrides[0].split("=")[1])
        assert shape.part == pytest.approx((alpha - 2) / (1 - 2), rel=1e-4)


def test_the_other_sign_of_what_differs_by_it_is_tried() -> None:
    found = TRIED["plate_tilt"]
    assert [shape.overrides for shape in found.shapes] == [
        (f"extensions.plate_tilt.offset_deg={tilt_deg}",) for tilt_deg in (2.0, -2.0, 4.0, -4.0)
    ]
    assert [shape.part for shape in found.shapes] == [1.0, -1.0, 2.0, -2.0]


def of(name: str, *overrides: str) -> TriedEffect:
    return next(e for e in ordinary(Config().overridden(overrides)) if e.effect == name)


def test_what_is_there_already_is_tried_the_other_way() -> None:
    left_out = of("no_self_contact", "contact.self_contact=false")
    assert left_out.shapes[0].overrides == ("contact.self_contact=true",)
    linear = of("locking", "mesh.target_elements=500", "solver.element=P1")
    assert linear.shapes[0].overrides == ('solver.element="P2"',)
    weighty = of("gravity_pitch", "gravity.acceleration_m_s2=9.81")
    assert weighty.shapes[0].tilt_deg == 3.0
    assert not weighty.one_sided
    on = ordinary(Config().overridden(["extensions.prony.g=[0.1]"]))
    assert "prony" not in {each.effect for each in on}
