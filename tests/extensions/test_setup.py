"""Set-up: a clamp on springs, sag, what is only displaced in the table."""

from __future__ import annotations

import numpy as np
import pytest
from support import bodies, small, trial
from support.paths import by_pressure

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.rigs.finger import build
from dolfingrip.extensions.clamp_compliance import ClampCompliance
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.sections.tables import assignments

ONE_STEP = (
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=20",
    "experiment.step_kPa=20",
)
SOFT = {"compliance_mm_per_N": 0.5, "compliance_rad_per_Nmm": 0.0}


def test_free_bending_does_not_feel_the_clamp() -> None:
    """Weightless, no force on the base: to where Newton's iterations end."""
    soft = {"compliance_mm_per_N": 1.0, "compliance_rad_per_Nmm": 1e-3}
    held, loose = (
        run("bending", trial.configured(on, *trial.STRICT, *ONE_STEP), comm=trial.SELF)
        for on in ({}, {ClampCompliance: soft})
    )
    assert held.failure is loose.failure is None
    assert held.column("angle_deg")[-1] > 1
    for name in ("angle_deg", "tip_x_mm", "cavity_volume_mm3"):
        assert loose.column(name)[-1] == pytest.approx(held.column(name)[-1], rel=1e-8)


def test_clamp_in_series() -> None:
    """A base that shifts by c F: the same force as from a plate that stands so much farther away.

    Without friction the plate, whose normal is x, shifts the base along x alone.
    """
    on = {ClampCompliance: SOFT}
    found = run("blocked_force", trial.configured(on, *trial.STRICT, *ONE_STEP), comm=trial.SELF)
    assert found.failure is None
    force = found.column("force_N")[-1]
    assert force > 0.2
    gap = SOFT["compliance_mm_per_N"] * force
    settings = trial.configured({}, *trial.STRICT, *ONE_STEP, f"plate.gap_mm={gap}")
    rigid = run("blocked_force", settings, comm=trial.SELF)
    assert force == pytest.approx(rigid.column("force_N")[-1], rel=1e-7)
    shift = found.column("tip_x_mm")[-1] - rigid.column("tip_x_mm")[-1]
    assert shift == pytest.approx(gap, rel=1e-6)


def test_a_base_turns_by_the_moment() -> None:
    """φ = c_φ F z, z the lever of a force on the last 10 mm of the finger."""
    compliance = 1e-4
    values = {"compliance_mm_per_N": 0.0, "compliance_rad_per_Nmm": compliance}
    settings = trial.configured({ClampCompliance: values}, *ONE_STEP)
    finger = small.model(settings, plate=True)
    path = by_pressure(Newton(finger.model, settings.solver))
    assert path.advance({"pressure_kPa": 20.0}).failure is None
    values = {unknown.name: unknown.value for unknown in finger.model.unknowns.global_unknowns}
    turn = values["clamp_compliance.turn_rad"]
    assert max(abs(values[f"clamp_compliance.shift_{axis}_mm"]) for axis in "xz") < 1e-12
    force, length = finger.plate.force_N(), settings.finger.length_mm
    # the plate pushes towards +x, which turns the base from z to x
    assert compliance * force * (length - 11) < turn < compliance * force * (length + 1)


def test_sag_of_a_cantilever() -> None:
    """wL⁴/(8EI) + 3wL²/(5GA) of a square bar that lies (Timoshenko, shear coefficient 5/6)."""
    length, side, acceleration = 60.0, 3.0, 0.02
    settings = config.load(
        None,
        assignments(
            [
                "contact.self_contact=false",
                "material.nu=0.05",
                f"extensions.gravity_pitch.acceleration_m_s2={acceleration}",
                "extensions.gravity_pitch.pitch_deg=90",
            ]
        ),
    )
    bar = bodies.box((2, 2, 24), (side, side, length))
    ends = {"clamp": bodies.plane(2, 0.0), "tip": bodies.plane(2, length)}
    finger = build(settings, bodies.domain(bar, ends), plate=False)
    assert Newton(finger.model, settings.solver).solve().converged
    nodes = finger.model.u.function_space.tabulate_dof_coordinates()
    tip = np.isclose(nodes[:, 2], length)
    sag = finger.model.u.x.array.reshape(-1, 3)[tip, 0].mean()
    shear = settings.material.mu_MPa
    young = 2 * shear * 1.05
    load = settings.material.density_kg_m3 * acceleration * 1e-9 * side**2
    expected = load * length**4 / (8 * young * side**4 / 12)
    expected += 3 * load * length**2 / (5 * shear * side**2)
    assert sag == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(
    ("changes", "section", "key", "expected"),
    [
        ("base_layer_offset.offset_mm=0.2", "finger", "base_layer_mm", 3.7),
        ("wall_offset.offset_mm=-0.2", "finger", "wall_mm", 1.4),
        ("plate_gap.offset_mm=0.5", "plate", "gap_mm", 1.5),
        ("plate_tilt.offset_deg=-3", "plate", "tilt_deg", 1.0),
        ("coarse_mesh.factor=2", "mesh", "size_mm", 14.0),
        ("coarse_mesh.factor=2", "mesh", "edge_size_mm", 0.4),
        ("locking.linear=true", "solver", "element", "P1"),
        ("no_self_contact.left_out=true", "contact", "self_contact", False),
        ("no_self_contact.left_out=false", "contact", "self_contact", True),
    ],
)
def test_what_becomes_of_the_configuration(
    changes: str, section: str, key: str, expected: float | str
) -> None:
    base = ("plate.gap_mm=1", "plate.tilt_deg=4")
    found = config.load(None, assignments([*base, f"extensions.{changes}"])).adapted()
    assert getattr(getattr(found, section), key) == (
        expected if isinstance(expected, str) else pytest.approx(expected)
    )


def test_tetrahedra_that_lock_do_not_take_over_how_hexahedra_are_graded() -> None:
    graded = ("mesh.edge_size_mm=7", "extensions.locking={}")
    assert config.load(None, assignments(graded)).adapted().mesh.edge_size_mm is None
    kept = config.load(
        None, assignments(("solver.element=P2", "mesh.edge_size_mm=1", *graded[1:]))
    ).adapted()
    assert kept.mesh.edge_size_mm == 1


def test_what_cannot_be_adapted_says_so() -> None:
    for change, said in (
        (
            "plate_gap.offset_mm=-1",
            r"plate.gap_mm = -1.0: allowed: at least 0 and at most",
        ),
        ("base_layer_offset.offset_mm=9.5", r"finger.base_layer_mm = 13.0: leaves no room"),
    ):
        with pytest.raises(ConfigError, match=said):
            config.load(None, assignments([f"extensions.{change}"])).adapted()


@pytest.mark.parametrize("name", ["mullins", "bulk_modulus"])
def test_what_a_pressure_field_does_not_go_with_is_refused(name: str) -> None:
    settings = small.short("solver.element=P2-P1", f"extensions.{name}={{}}")
    with pytest.raises(ConfigError, match=rf"^extensions\.{name}: allowed: with solver.element"):
        small.model(settings, plate=False)
