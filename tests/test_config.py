"""The configuration: what is refused, how it is said, and that it survives a round trip."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.sections import errors, ranges, units
from dolfingrip.sections.form import Form
from dolfingrip.sections.laws.index import LAWS
from dolfingrip.sections.section import EVERYWHERE, Ratio, Role, Section
from dolfingrip.sections.setup import KINDS
from dolfingrip.sections.tables import assignments

REFUSED = {
    # a value out of its range, which is reported with its unit
    "finger.gap_mm=-1": "finger.gap_mm = -1: allowed: at least 0.001 and at most",
    "finger.wall_mm=nan": "finger.wall_mm = NaN: not a finite number; allowed: at least 0.001",
    "finger.bellows=0": "finger.bellows = 0: allowed: at least 1 and at most 60",
    "plate.tilt_deg=90": "plate.tilt_deg = 90: allowed: above -80 and below 80 deg",
    "morph.xi1=-0.3": "morph.xi1 = -0.3: allowed: at least -0.2 and at most 1",
    "morph.xi2=1.5": "morph.xi2 = 1.5: allowed: at least -0.5 and at most 1",
    "material.nu=0.5": "material.nu = 0.5: allowed: at least 1e-06 and below 0.5",
    "experiment.rate_kPa_per_s=0": "experiment.rate_kPa_per_s = 0: allowed: at least 1e-06 and",
    # another type: nothing is converted silently
    "finger.wall_mm=thick": 'finger.wall_mm = "thick": not a number; allowed: at least 0.001',
    "finger.wall_mm='2'": 'finger.wall_mm = "2": not a number; allowed: at least 0.001',
    "finger.wall_mm=true": "finger.wall_mm = true: not a number; allowed: at least 0.001",
    "finger.wall_mm=1\n2": 'finger.wall_mm = "1\\n2": not a number; allowed: at least 0.001',
    "finger.bellows=2.5": "finger.bellows = 2.5: not an integer; allowed: at least 1",
    "mesh.half=1": "mesh.half = 1: allowed: true, false",
    "mesh.file=3": "mesh.file = 3: allowed: a file's path",
    "solver.element=P3": 'solver.element = "P3": allowed: P1, P2, P2-P1',
    "plate.normal=[1, 0]": "plate.normal = [1, 0]: allowed: three finite numbers",
    "plate.normal=[1, 0, 'a']": 'plate.normal = [1, 0, "a"]: allowed: three finite numbers',
    "plate.normal=[0, 0, 0]": "plate.normal = [0.0, 0.0, 0.0]: allowed: any vector but zero",
    "finger=3": "finger = 3: not a table; allowed: keys length_mm",
    # an unknown key: the near one is named
    "finger.wall_cm=1": "finger.wall_cm: unknown key; did you mean finger.wall_mm? allowed: ",
    "experiment.max_pressure_MPa=1": "did you mean experiment.max_pressure_kPa?",
    "wall_mm=1": "wall_mm: unknown key; did you mean finger.wall_mm? allowed: finger, material",
    "finger.size_mm=1": "finger.size_mm: unknown key; did you mean mesh.size_mm?",
    "contact.gap_mm=1": "did you mean finger.gap_mm or plate.gap_mm?",
    "fingr.wall_mm=1": "fingr: unknown key; did you mean finger?",
    "zzz=1": "zzz: unknown key; allowed: finger,",
    # section and unit are left out
    "wall=2": "wall: unknown key; did you mean finger.wall_mm? allowed: finger, material",
    "max_pressure=9": "max_pressure: unknown key; did you mean experiment.max_pressure_kPa?",
    # an impossible geometry
    "finger.wall_mm=3.5": "finger.wall_mm = 3.5: thicker than half a bellows; "
    "allowed: above 0 and below 3.5 mm",
    "finger.gap_mm=9": "finger.gap_mm = 9.0: leaves no bellows; "
    "allowed: above 0 and below the pitch, 9 mm",
    "finger.channel_mm=10.9": "finger.channel_mm = 10.9: cavity not closed; "
    "allowed: above 0 and below 10.9 mm",
    "finger.channel_width_mm=17": "finger.channel_width_mm = 17.0: cavity not closed; "
    "allowed: above 0 and up to 16.8 mm",
    "finger.base_layer_mm=13": "finger.base_layer_mm = 13.0: leaves no room for a bellows",
    "finger.base_block_mm=84": "finger.base_block_mm = 84.0: leaves no room for bellows; "
    "allowed: above 0 and below 84 mm",
    "finger.tip_mm=90": "finger.tip_mm = 90.0: allowed: above 0 and below length_mm = 90 mm",
    "finger.depth_mm=3": "finger.wall_mm = 1.6: thicker than half a bellows",
    # keys that exclude one another
    "material.bulk_MPa=1": "material.bulk_MPa = 1.0: allowed: above 2/3 mu_MPa",
    "solver.min_step_kPa=30": "solver.min_step_kPa = 30.0: allowed: above 0 and up to max_step_kPa",
    "experiment.step_kPa=300": "experiment.step_kPa = 300.0: allowed: above 0 and up to max_pressu",
    "plate.contact_length_mm=91": "plate.contact_length_mm = 91.0: allowed: above 0 and up to fing",
    "plate.normal=[1, 1, 0]": "plate.normal = [1.0, 1.0, 0.0]: allowed: no y-part with mesh.half",
    # tables within a table, and lists
    "extensions.pronny.g=[1]": "extensions.pronny: unknown key; did you mean extensions.prony?",
    "extensions.prony.tau=[1]": "unknown key; did you mean extensions.prony.tau_s? allowed: g, tau",
    "prony.g=[1]": "prony: unknown key; did you mean extensions.prony?",
    "extensions.prony=3": "extensions.prony = 3: not a table; allowed: keys g, tau_s",
    "extensions.prony.g=[2]": "extensions.prony.g = [2]: allowed: a list of 1 to 3 numbers, each "
    "at least 0 and below 1",
    "extensions.prony.g=[0.1, 0.1]": "extensions.prony.tau_s = [10.0]: allowed: as many numbers",
    "extensions.yeoh.C30_MPa=-1": "extensions.yeoh.C30_MPa = -1: allowed: at least 0 and at most",
    "protocol.branch=['up']": 'protocol.branch = ["up"]: allowed: a list of loading, unloading',
    "protocol.time_s=[1]": "protocol.pressure_kPa = 0 values: allowed: as many as time_s has, 1",
    # no assignment at all
    "finger.wall_mm": "--set finger.wall_mm: allowed: section.key=value",
    "=3": "--set =3: allowed: section.key=value",
}


def _complaint(*overrides: str, file: Path | None = None) -> str:
    with pytest.raises(ConfigError) as caught:
        config.load(file, assignments(overrides))
    return str(caught.value)


@pytest.mark.parametrize("assignment", REFUSED)
def test_bad_input_is_one_line_with_key_value_and_range(assignment: str) -> None:
    said = _complaint(assignment)
    assert REFUSED[assignment] in said
    assert "\n" not in said


def test_a_number_may_have_nothing_on_one_side_of_its_point() -> None:
    made = config.load(None, assignments(["food.friction=.12", "gripper.lift_mm=5."]))
    assert made.food.friction == 0.12
    assert made.gripper.lift_mm == 5.0


def test_a_low_pressure_needs_no_step_of_its_own() -> None:
    made = config.load(None, assignments(["experiment.max_pressure_kPa=10"]))
    assert made.experiment.step_kPa == 10.0
    assert "step_kPa = 20.0: allowed" in _complaint(
        "experiment.max_pressure_kPa=10", "experiment.step_kPa=20"
    )


def test_edges_are_no_coarser_than_the_rest() -> None:
    said = _complaint("mesh.size_mm=4", "mesh.edge_size_mm=5")
    assert said == "mesh.edge_size_mm = 5.0: allowed: above 0 and up to size_mm = 4 mm"


def test_a_number_of_tetrahedra_is_refused_for_hexahedra() -> None:
    said = _complaint("solver.element=S2", "mesh.target_elements=4000")
    assert said.startswith("mesh.target_elements = 4000: a number of tetrahedra; allowed: with ")


def test_both_nu_and_bulk_modulus_are_refused() -> None:
    said = _complaint("material.nu=0.4", "material.bulk_MPa=20")
    assert said == "material.bulk_MPa = 20.0: give either nu or bulk_MPa; nu = 0.4"


def test_gravity_across_the_symmetry_plane_is_refused_for_a_half_finger_only() -> None:
    across = ("gravity.direction=[0, 1, 0]", "gravity.acceleration_m_s2=9.81")
    assert "gravity.direction = [0.0, 1.0, 0.0]: allowed: no y-part" in _complaint(*across)
    assert not config.load(None, assignments([*across, "mesh.half=false"])).mesh.half


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.toml", "wall", "--config {}: not TOML: "),
        ("a.toml", "[finger]\nwall_mm = 1\nwall_mm = 2\n", "--config {}: not TOML: "),
        (
            "a.toml",
            "[finger]\nwall_mm = -1\n",
            "finger.wall_mm = -1: allowed: at least 0.001 and at most",
        ),
        ("a.json", "{", "--config {}: not a run.json: "),
        ("a.json", "{}", "--config {}: not a run.json: "),
        ("a.json", '{"config": 3}', "--config {}: not a run.json: "),
        ("a.json", '{"config": {"finger": {"bellows": null}}}', "finger.bellows = null: not an"),
    ],
)
def test_bad_file_is_one_line(tmp_path: Path, name: str, text: str, said: str) -> None:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    complaint_ = _complaint(file=file)
    assert complaint_.startswith(said.format(file))
    assert "\n" not in complaint_


def test_missing_file_is_named(tmp_path: Path) -> None:
    assert _complaint(file=tmp_path / "no.toml") == (
        f"--config {tmp_path / 'no.toml'}: No such file or directory"
    )


def test_overrides_win_over_the_file_and_later_ones_over_earlier(tmp_path: Path) -> None:
    file = tmp_path / "finger.toml"
    file.write_text("[finger]\nwall_mm = 1.2\ngap_mm = 2.5\n", encoding="utf-8")
    found = config.load(
        file,
        assignments(["finger.wall_mm=1.3", " finger.wall_mm = 1.4", "plate.normal=[1,0,0.5]",
         "solver.element=P1", 'mesh.file="a b.msh"']),
    )  # fmt: skip
    assert (found.finger.wall_mm, found.finger.gap_mm) == (1.4, 2.5)
    assert found.plate.normal == (1.0, 0.0, 0.5)
    assert found.solver.element == "P1"


def test_mesh_file_is_sought_beside_the_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    file = tmp_path / "finger.toml"
    file.write_text('[mesh]\nfile = "own.msh"\n', encoding="utf-8")
    monkeypatch.chdir(tmp_path / "here")
    assert config.load(file).mesh.file == tmp_path / "own.msh"
    assert (
        config.load(file, assignments(["mesh.file=own.msh"])).mesh.file
        == tmp_path / "here" / "own.msh"
    )


CHANGED = [
    "finger.wall_mm=1.8",
    "finger.channel_width_mm=10",
    "mesh.half=false",
    "mesh.file=/tmp/finger \u00e9.msh",
    "material.bulk_MPa=30.0",
    "plate.normal=[0.5, -0.25, 1]",
    "gravity.acceleration_m_s2=9.81",
    "experiment.unload=true",
    "extensions.prony.g=[0.1, 0.2]",
    "extensions.prony.tau_s=[1, 100]",
    "protocol.time_s=[0, 1.5]",
    "protocol.pressure_kPa=[0, 30]",
]


@pytest.mark.parametrize(
    "overrides",
    [[], CHANGED, ["finger.kind=cast", "cast.wall_mm=6"]],
    ids=["reference", "changed", "cast"],
)
def test_printed_configuration_reads_back_equal(overrides: list[str], tmp_path: Path) -> None:
    resolved = config.load(None, assignments(overrides))
    printed = tmp_path / "printed.toml"
    printed.write_text(config.dumps(resolved), encoding="utf-8")
    assert config.load(printed) == config.load(str(printed)) == resolved
    recorded = tmp_path / "run.json"
    content = {"config": resolved.model_dump(mode="json", exclude_none=True)}
    recorded.write_text(json.dumps(content), encoding="utf-8")
    assert config.load(recorded) == resolved


def _keys() -> dict[str, Any]:
    found: dict[str, Any] = {}
    tables = [[section] for section in Config.model_fields]
    for table in tables:
        for key, info in errors.fields(table, Config).items():
            if isinstance(info.default, Section):
                tables.append([*table, key])
            else:
                found[".".join([*table, key])] = info
    assert "finger.along.depth_mm" in found
    return found


def test_every_number_has_its_unit_in_its_name_or_says_that_it_has_none() -> None:
    numbers = {key for key, info in _keys().items() if re.search(r"\bfloat\b", str(info))}
    assert {"finger.wall_mm", "plate.normal"} <= numbers  # the search finds numbers at all
    without = {key for key in numbers if not units.unit(key)}
    assert {"material.nu", "plate.normal"} <= without
    assert [key for key in without if not ranges.pure(_keys()[key])] == []


@pytest.mark.parametrize("name", ["wall", "wall_cm", "wall_per_inch"])
def test_a_number_without_a_unit_says_so(name: str) -> None:
    """A table of the configuration is made; ``Ratio`` is the type of a pure number."""
    table: Any = {"__module__": __name__, "role": Role.BODY, name: 1.0}
    with pytest.raises(TypeError, match=f"{name}: ends in no unit; allowed: one of mm, mm2"):
        type("Table", (Section,), {**table, "__annotations__": {name: float}})
    type("Table", (Section,), {**table, "__annotations__": {name: Ratio}})


def test_every_key_is_printed_with_its_meaning() -> None:
    own = ["finger.kind=adopted", "mesh.file=part.msh"]
    made = [[f"finger.kind={kind}"] for kind in KINDS if not KINDS[kind].of_file]
    boxes = config.load().geometry.boxes()
    assert boxes is not None
    count = Form(offsets_mm=()).count(boxes)
    bent = [
        f"form.offsets_mm={[0.0] * count}",
        "inlet.kind=tube",
        "curve.x_mm=[0, 0]",
        "curve.z_mm=[0, 90]",
        "obstacle.kind=cube",
        "supply.source=tank",
    ]
    ogden = ["material.law=ogden", "material.ogden_mu_MPa=[1]", "material.ogden_alpha=[2]"]
    polynomial = ["material.law=polynomial", "material.C10_MPa=1"]
    chains = [[f"material.law={law}"] for law in LAWS if law not in ("ogden", "polynomial")]
    kinds = ([], *made, own, bent, ogden, polynomial, *chains)
    lines = [
        line
        for kind in kinds
        for line in config.dumps(config.load(None, assignments(kind))).splitlines()
    ]
    for key, info in _keys().items():
        name = key.rpartition(".")[2]
        assert info.description
        assert any(
            re.match(rf"(# )?{name} = .*# {re.escape(info.description)}", line) for line in lines
        ), key


def test_a_configuration_is_not_assigned_to() -> None:
    """One line says how to change one, at any depth."""
    made = config.load()
    for section, key in ((made, "finger"), (made.finger, "wall_mm"), (made.material, "mu_MPa")):
        with pytest.raises(ConfigError) as caught:
            setattr(section, key, 1.7)
        said = str(caught.value)
        assert said.startswith(f"{key} = 1.7: a configuration does not change; allowed: a changed")
        assert "\n" not in said


def test_each_section_declares_what_it_describes_and_who_feels_it() -> None:
    for name, section in config.Config.classes().items():
        assert section.role in Role, name
        assert set(section.felt_by) <= set(EVERYWHERE), name
    roles = {name: section.role for name, section in config.Config.classes().items()}
    assert {roles[kind] for kind in ("finger", "cast", "morph", "film", "material")} == {Role.BODY}
    assert (roles["plate"], roles["camera"]) == (Role.SETUP, Role.INSTRUMENT)
    assert (roles["solver"], roles["protocol"]) == (Role.NUMERICS, Role.PROCEDURE)


@pytest.mark.parametrize(
    ("change", "feel"),
    [
        ({"material.mu_MPa": 2.0}, "finger plate bar modes gripper"),
        ({"finger.wall_mm": 1.8}, "finger gripper"),
        ({"plate.gap_mm": 1.0}, "plate"),
        ({"extensions.plate_gap.offset_mm": 0.2}, "plate"),
        ({"extensions.prony.g": [0.2]}, "finger plate bar modes gripper"),
        ({"extensions.locking.linear": True}, "finger plate bar modes gripper"),
        ({"film.silk.Et_N_per_mm": 3.0}, "finger gripper"),
        ({"coupon.width_mm": 4.0}, "bar"),
        ({"camera.chord": "back edges"}, "finger"),
        ({"food.friction": 0.5}, "gripper"),
        ({"solver.memory_GB": 3.0}, ""),
    ],
)
def test_an_experiment_feels_a_change(change: config.Change, feel: str) -> None:
    """A result depends on what its experiment's parts feel, and not on how it is computed."""
    base = config.Config()
    for part in EVERYWHERE:
        same = config.felt(config.changed(base, change), [part]) == config.felt(base, [part])
        assert same == (part not in feel.split()), part


def test_with_a_protocol_the_ramps_are_not_felt() -> None:
    base = config.Config().changed(protocol={"time_s": [0.0, 1.0], "pressure_kPa": [0.0, 9.0]})
    ramps = {"experiment.step_kPa": 5.0, "experiment.max_pressure_kPa": 50.0}
    assert config.felt(config.changed(base, ramps)) == config.felt(base)
    assert config.felt(config.changed(base, {"experiment.snaps": False})) != config.felt(base)
