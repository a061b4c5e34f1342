"""Every key of the configuration does something: it changes a result, or it is refused.

The keys that only say something of a part or of the solver are in ``Section.effort``; tables that
no experiment feels are for moulds.
"""

from __future__ import annotations

import typing
from pathlib import Path
from typing import Any

import pytest
from support import hollow_box
from support.command import run_command

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.idle import idle
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.meshes import files
from dolfingrip.sections.errors import bare
from dolfingrip.sections.geometry.index import GEOMETRIES
from dolfingrip.sections.section import Section

kinds = pytest.mark.parametrize("kind", GEOMETRIES)

OWN_TABLES = ("override", "along")
"""Dimensions of single chambers, which tests/meshes/test_own_chambers.py moves."""

MESHES = {"half": False, "order": 1, "size_mm": 4.0, "edge_size_mm": 4.0, "refine": 2,
          "target_elements": 500, "both_sides": True}  # fmt: skip


def finger(kind: str, folder: Path) -> Config:
    """A coarse finger of a kind; of an adopted one half a box as a file."""
    sizes = (6.0, 1.5) if GEOMETRIES[kind].hexahedra else (8.0, 7.9)
    mesh: dict[str, Any] = dict(zip(("size_mm", "edge_size_mm"), sizes, strict=True))
    if GEOMETRIES[kind].of_file:
        files.write(folder / "box.msh", hollow_box.mesh())
        mesh = {"file": str(folder / "box.msh")}
    tables: dict[str, Any] = {"finger": {"kind": kind}, "mesh": mesh, "morph": {"d_mm": 4.0}}
    geometry = GEOMETRIES[kind]
    if geometry.number in geometry.model_fields:
        tables.setdefault(geometry.table(), {})[geometry.number] = 2
    return config.from_dict(tables)


def others(value: Any, info: Any) -> list[Any]:
    """Other values of a key, of which one may be allowed."""
    if typing.get_origin(hint := bare(info.annotation)) is typing.Literal:
        return [each for each in typing.get_args(hint) if each != value]
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1, value - 1]
    if isinstance(value, float):
        return [1.03 * value, 0.97 * value] if value else [0.03, 2.0, -0.03]
    if isinstance(value, tuple) and value and isinstance(value[0], float):
        return [[0.0, 0.0, 2.0], [2.0, 0.0, 1.0]]
    return [5.0, 2, 2000, True, [1.0, 2.0, 3.0]] if value is None else []


def told(asked: Config) -> list[str]:
    """What each experiment's answer depends on, or why it refuses the configuration."""
    found = []
    for name in EXPERIMENTS:
        try:
            found.append(Request.of(name, asked).key)
        except ConfigError as error:
            found.append(str(error))
    return found


@kinds
def test_every_key_counts_in_some_experiment(tmp_path: Path, kind: str) -> None:
    base = finger(kind, tmp_path)
    before, idle, tried = told(base), [], 0
    for table, section in base.tables.items():
        for key, info in type(section).model_fields.items():
            changes = []
            for value in others(getattr(section, key), info):
                try:
                    changes.append(config.changed(base, {f"{table}.{key}": value}))
                except ConfigError:
                    continue
            tried += bool(changes)
            if changes and section.felt_by and key not in section.effort:
                idle += [f"{table}.{key}"] * all(told(each) == before for each in changes)
    assert not idle
    assert tried > 80


def shape(asked: Config) -> tuple[Any, ...]:
    """What tells one mesh from another."""
    mesh = solid(asked)
    return mesh.points.shape, mesh.cells.shape, float(abs(mesh.points).sum()), *mesh.facets


@pytest.mark.parametrize("kind", [
    pytest.param(kind, marks=pytest.mark.slow if each.tetrahedra else [])
    for kind, each in GEOMETRIES.items()
])  # fmt: skip
def test_every_dimension_and_size_changes_the_mesh(tmp_path: Path, kind: str) -> None:
    """Or the key is refused, as those of a file are."""
    base = finger(kind, tmp_path)
    before, idle = shape(base), []
    table = base.geometry_table
    own = [
        (f"{table}.{key}", others(getattr(base.geometry, key), info))
        for key, info in type(base.geometry).model_fields.items()
        if key not in (*OWN_TABLES, *base.geometry.effort, "kind")
    ]
    sizes = [(f"mesh.{key}", [value]) for key, value in MESHES.items()]
    thicknesses = [(f"morph.{key}", [0.1]) for key in ("xi1", "xi2")]
    refused = 0
    for key, values in own + sizes + thicknesses:
        same = False
        for value in values:
            try:
                same = shape(config.changed(base, {key: value})) == before
            except ConfigError:
                refused += 1
                continue
            if not same:
                break
        idle += [key] * same
    # hexahedra of first order have straight edges, and those of a file the order that they have
    assert set(idle) <= {"mesh.order"}
    assert refused >= 8 or not GEOMETRIES[kind].of_file


@pytest.mark.parametrize(
    "setting",
    ["adopted.wall_mm=1", "adopted.length_mm=120", "mesh.size_mm=2", "mesh.both_sides=true"],
)
@pytest.mark.parametrize("command", ["bend", "mesh", "doe", "synthetic", "push", "grasp"])
def test_a_file_s_dimensions_are_refused_by_every_command(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], command: str, setting: str
) -> None:
    finger("adopted", tmp_path)
    file = tmp_path / "adopted.toml"
    file.write_text('[mesh]\nfile = "box.msh"\n[finger]\nkind = "adopted"\n', encoding="utf-8")
    asked = ("--config", file, "--set", setting, "--out", tmp_path / "out")
    assert run_command(command, *asked) == 2
    error = capfd.readouterr().err
    assert setting.replace("=", " = ").replace("true", "True") in error.replace(".0", "")
    assert error.count("\n") == 1


def test_a_campaign_varies_no_dimension_of_a_file(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Nor that of a finger whose table only describes the file."""
    finger("adopted", tmp_path)
    for kind, key in (("adopted", "adopted.wall_mm"), ("bellows", "finger.wall_mm")):
        file = ("--set", f"mesh.file={tmp_path / 'box.msh'}", "--set", f"finger.kind={kind}")
        asked = ("doe", "--parameter", f"{key}=2:3:2", *file, "--out", tmp_path / "out")
        assert run_command(*asked) == 2
        said = f"{key} = 2.0: a dimension of the solid in mesh.file, which stays as it is; allowed:"
        assert said in capfd.readouterr().err


# -- keys that do nothing in an experiment ---------------------------------------------------------

SMALL = {
    "bending": {}, "blocked_force": {}, "cycle": {}, "push": {}, "vibration": {},
    "coupon": {"coupon.max_strain": 0.05},
    "grasp": {"gripper.preset": "coarse", "food.kind": "cube"},
}  # fmt: skip
"""What makes a run of each experiment short, beside a coarse mesh."""

LOAD = {"experiment.max_pressure_kPa": 5.0, "experiment.step_kPa": 5.0, "solver.element": "P1"}

MODES: dict[str, dict[str, Any]] = {
    "ramps": {},
    "volume": {"experiment.control": "volume", "experiment.max_volume_ratio": 1.05,
               "experiment.step_volume_ratio": 0.05},
    "inertia": {"experiment.dynamic": True, "solver.max_step_s": 0.1, "release.load_x_N": 0.01},
    "air": {"supply.source": "tank", "experiment.unload": True, "experiment.hold_s": 1.0},
    "hanging": {"gravity.acceleration_m_s2": 9.81, "extensions.tip_mass.mass_g": 5.0,
                "camera.markers": 2, "extensions.camera_tilt.about_z_deg": 2.0},
}  # fmt: skip
"""Ways of free bending, with and without keys that others need beside them."""

AT_ITS_DEFAULT = {
    "mesh.both_sides", "camera.from_mm", "camera.to_mm", "protocol.displacement_mm",
    "protocol.cycle", "protocol.branch", "protocol.pressure_kPa", "protocol.volume_ml",
    "base.time_s", "base.acceleration_m_s2", "supply.board",
}  # fmt: skip
"""Keys that are refused where nothing looks at them; a board's name stands for other keys."""


def allowed(base: Config, key: str) -> typing.Iterator[bool]:
    """Whether each other value of a key is taken."""
    table, name = key.split(".")
    section = base.tables[table]
    for value in others(getattr(section, name), type(section).model_fields[name]):
        try:
            config.changed(base, {key: value})
            yield True
        except ConfigError:
            yield False


def keys_without_effect(
    monkeypatch: pytest.MonkeyPatch, name: str, asked: Config
) -> tuple[set[str], set[str]]:
    """Keys that a run does not look at, and those of them of which it is said."""
    request = Request.of(name, asked)
    tables, seen = dict(request.config.tables), set()
    fields = {each: frozenset(each.model_fields) for each in map(type, tables.values())}

    def look(section: Section, key: str) -> Any:
        if key in fields.get(type(section), ()):
            seen.add((type(section), key))
        return object.__getattribute__(section, key)

    with monkeypatch.context() as patched:
        patched.setattr(Section, "__getattribute__", look, raising=False)
        result = run(name, asked)
    assert len(result.rows) > 1
    unseen = [
        f"{table}.{key}" for table, section in tables.items() for key in type(section).model_fields
        if (type(section), key) not in seen and key not in section.effort
    ]  # fmt: skip
    told = {
        line.partition(":")[0]
        for line in idle(request.experiment, request.config, dict.fromkeys(unseen))
    }
    print(sorted({*unseen} - told))
    return set(unseen), told


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "mode"),
    [*((name, "ramps") for name in EXPERIMENTS), *(("bending", mode) for mode in MODES)],
)
def test_a_key_that_no_run_looks_at_is_said_to_do_nothing(
    monkeypatch: pytest.MonkeyPatch, name: str, mode: str
) -> None:
    """Each key of each table, of those that are for all kinds of geometry, too."""
    asked = config.load(None, {"mesh.size_mm": 14.0, **LOAD, **SMALL[name], **MODES[mode]})
    unseen, told = keys_without_effect(monkeypatch, name, asked)
    assert unseen - told <= AT_ITS_DEFAULT
    assert told


@kinds
def test_a_key_that_no_run_of_a_kind_looks_at_is_said_to_do_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kind: str
) -> None:
    """Its own table, too."""
    asked = config.changed(
        finger(kind, tmp_path), {k: v for k, v in LOAD.items() if "element" not in k}
    )
    unseen, told = keys_without_effect(monkeypatch, "bending", asked)
    taken = {key for key in unseen - told if any(allowed(asked, key))}
    assert taken <= AT_ITS_DEFAULT


def test_a_run_says_which_overrides_do_nothing() -> None:
    def said(name: str, change: dict[str, Any]) -> list[str]:
        asked = config.load(None, change)
        return list(idle(EXPERIMENTS[name], asked, change))

    assert said("bending", {"coupon.width_mm": 9.0, "extensions.plate_gap.offset_mm": 1.0}) == [
        "coupon.width_mm: bend does not depend on it",
        "extensions.plate_gap.offset_mm: bend does not depend on it",
    ]
    volume = {"experiment.max_volume_ratio": 3.0}
    assert said("bending", volume) == [
        'experiment.max_volume_ratio: does nothing without experiment.control = "volume" or "auto"'
    ]
    assert said("bending", {**volume, "experiment.control": "volume"}) == []
    assert said("coupon", {"experiment.max_pressure_kPa": 9.0, "solver.linear": "direct"}) == [
        "experiment.max_pressure_kPa: coupon does not depend on it"
    ]
    assert said("grasp", {"food.bump_mm": 1.0, "food.edge_radius_mm": 1.0}) == [
        "food.bump_mm: does nothing beside the table's other keys"
    ]
    assert said("blocked_force", {"plate.gap_mm": 1.0, "finger.wall_mm": 2.0}) == []


@pytest.mark.parametrize(
    ("key", "quantity", "said"),
    [
        ("coupon.width_mm", "force_N at 5 kPa", "coupon.width_mm: force does not depend on it"),
        ("experiment.max_volume_ratio", "mass_g", "does nothing without experiment.control"),
        ("cog.x_ref_mm", "force_N at 5 kPa", "cog.x_ref_mm: force does not depend on it"),
    ],
)
def test_a_campaign_varies_nothing_that_does_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], key: str, quantity: str, said: str
) -> None:
    """All its designs would be one."""
    asked = ("doe", "--parameter", f"{key}=2:3:2", "--quantity", quantity, "--out", tmp_path)
    assert run_command(*asked) == 2
    error = capfd.readouterr().err
    assert said in error
    assert error.count("\n") == 1
