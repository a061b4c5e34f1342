"""Design spaces: the paper's grid, samples, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.config import Config, ConfigError, felt, from_dict
from dolfingrip.design.campaign import plan, space


def paper() -> list[space.Varied]:
    return [space.parse(text) for text in space.PAPER]


def test_the_paper_s_points() -> None:
    found = space.points(paper(), "grid")
    assert len(found) == 208
    for key, low, step in (("morph.xi1", -0.2, 0.08), ("morph.xi2", -0.5, 0.125)):
        values = sorted({point[key] for point in found})
        np.testing.assert_allclose(values, low + step * np.arange(len(values)), atol=1e-12)
        assert values[-1] == 1.0
    assert 0.0 in {point["morph.xi2"] for point in found}
    assert len({design.key for design in _plan(found).designs()}) == 208


def _plan(points: list[space.Inputs], **changes: object) -> plan.Plan:
    return plan.Plan(Config(), tuple(points[0]), tuple(points), **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["sobol", "lhs"])
@pytest.mark.parametrize("dimensions", [1, 3])
def test_samples_are_even_and_repeat_with_the_seed(kind: space.Points, dimensions: int) -> None:
    texts = ["finger.wall_mm=1.2:1.8", "morph.xi1=-0.2:1", "finger.base_layer_mm=2.5:4"]
    parameters = [space.parse(text) for text in texts[:dimensions]]
    seed, number = 7, 64
    print(f"seed {seed}")
    found = space.points(parameters, kind, number, seed)
    assert found == space.points(parameters, kind, number, seed)
    assert found != space.points(parameters, kind, number, seed + 1)
    for p in parameters:
        values = np.array([point[p.key] for point in found])
        bins = np.histogram(values, bins=8, range=(p.low, p.high))[0]
        assert bins.sum() == number
        assert (bins == number // 8).all()


def test_a_longer_sobol_sequence_contains_the_shorter_one() -> None:
    """So that a campaign asked for more points computes only those."""
    assert space.points(paper(), "sobol", 20)[:13] == space.points(paper(), "sobol", 13)


def test_whole_numbers_stay_whole() -> None:
    found = space.points([space.parse("finger.bellows=6:9")], "sobol", 32)
    assert {point["finger.bellows"] for point in found} == {6, 7, 8, 9}
    assert all(isinstance(point["finger.bellows"], int) for point in found)
    assert len(found) == 4  # each design once


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("morph.xi1", "allowed: section.name=low:high"),
        ("morph.xi1=a:b", "allowed: section.name=low:high"),
        ("morph.xi1=0:0.5:1", "count = 1: allowed: 2 to 100000"),
        ("morph.xi1=0.5:0.1", "allowed: low below high"),
        ("morph.xi1=-0.3:1", "morph.xi1 = -0.3: allowed: at least -0.2 and at most 1"),
        (
            "finger.wall_mm=-1:1",
            "finger.wall_mm = -1: allowed: at least 0.001 and at most",
        ),
        ("finger.bellows=1.5:3", "finger.bellows = 1.5: not an integer; allowed: at least 1"),
        ("finger.wall=1:2", "finger.wall: unknown key; did you mean finger.wall_mm?"),
        ("extensions.prony.g=0:0.1", "extensions.prony.g: no number"),
        ("extensions.gent.inverse_J_m=-1:0", "extensions.gent.inverse_J_m = -1: allowed: at leas"),
        ("finger.wall_mm.x=0:1", "wall_mm is a value, not a section"),
        ("wall=1:2", "wall: unknown key"),
        ("mesh.half=0:1", "mesh.half: no number"),
        ("plate.normal=0:1", "plate.normal: no number"),
        ("solver.element=0:1", "solver.element: no number"),
        ("morph.xi1=nan:1", "morph.xi1 = NaN: not a finite number; allowed: at least -0.2"),
    ],
)
def test_refused_parameters(text: str, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        space.parse(text)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_refused_numbers_of_points() -> None:
    for kind, number, said in (
        ("grid", 100, "the grid has 16 x 13 points"),
        ("sobol", None, "--number = None; allowed: 1 to 100000"),
        ("lhs", 0, "--number = 0; allowed: 1 to 100000"),
    ):
        with pytest.raises(ConfigError, match=said):
            space.points(paper(), kind, number)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="needs a count"):
        space.points([space.parse("morph.xi1=0:1")], "grid")
    with pytest.raises(ConfigError, match="given twice"):
        space.points([paper()[0]] * 2, "grid")


@pytest.mark.parametrize("base", [{}, {"extensions": {"mooney_rivlin": {"C01_MPa": 0.3}}}])
def test_numbers_of_effects_vary(base: dict[str, object]) -> None:
    """Whether the effect is on in the base or not."""
    varied = space.parse("extensions.mooney_rivlin.C01_MPa=0.5:1:2")
    points = tuple(space.points([varied], "grid"))
    wanted = plan.Plan(Config.model_validate(base), (varied.key,), points)
    configs = [from_dict(design.config) for design in wanted.designs()]
    assert [varied.parameter.value(config) for config in configs] == [0.5, 1.0]


def test_key_depends_on_what_the_result_depends_on() -> None:
    point: space.Inputs = {"morph.xi1": 0.1}
    key = _plan([point]).designs()[0].key
    assert _plan([{"morph.xi1": 0.1}]).designs()[0].key == key
    assert _plan([{"morph.xi1": 0.1 + 1e-9}]).designs()[0].key != key
    assert _plan([point], quantities=("cog_offset_mm",)).designs()[0].key != key
    assert _plan([point], objective="a:b").designs()[0].key != key


def test_a_mesh_file_counts_by_its_content(tmp_path) -> None:  # type: ignore[no-untyped-def]
    keys = []
    for name, content in (("a.msh", "1"), ("b.msh", "1"), ("b.msh", "2")):
        (tmp_path / name).write_text(content)
        mesh = Config().mesh.model_copy(update={"file": tmp_path / name})
        base = Config().model_copy(update={"mesh": mesh})
        keys.append(plan.Plan(base, ("morph.xi1",), ({"morph.xi1": 0.1},)).designs()[0].key)
    assert keys[0] == keys[1] != keys[2]


def test_a_switch_that_came_later_counts_where_it_is_on() -> None:
    def key(**changes: dict[str, object]) -> str:
        base = Config().changed(**changes)
        return plan.content_key(felt(base))

    older = Config().model_dump(mode="json")
    del older["mesh"]["both_sides"], older["experiment"]["snaps"]
    same = key(mesh={"both_sides": False}, experiment={"snaps": True})
    assert key() == same == plan.content_key(felt(older))
    assert len({key(), key(mesh={"both_sides": True}), key(experiment={"snaps": False})}) == 3
