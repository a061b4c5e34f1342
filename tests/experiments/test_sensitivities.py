"""Forward sensitivities against differences of whole runs.

A random direction in the space of all parameters of a case is as good as each by itself: a wrong
derivative by any of them shows. ``benchmarks/sensitivities.csv`` has the errors one by one, of more
effects. The runs that are subtracted move the mesh as the derivative does and take the same steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from support import differences, small

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.derivatives.sensitivities import chosen
from dolfingrip.parameter import Entry, Parameter, every, find
from dolfingrip.sections.tables import assignments

SEED = 17
VOLUME = (
    "experiment.control=volume", "experiment.max_volume_ratio=1.1",
    "experiment.step_volume_ratio=0.05",
)  # fmt: skip
FEW = ("mesh.size_mm=10", "mesh.edge_size_mm=10")
TO_50_kPa = ("experiment.max_pressure_kPa=50", "experiment.step_kPa=25")
ELASTIC, LASTING = 1e-5, 1e-3
"""Errors allowed, as parts of the readings' scales."""


def settings(*overrides: str) -> Config:
    """A short finger, solved to rounding."""
    return config.load(None, assignments([*differences.SHORT, *overrides]))


def direction(parameters: list[Parameter], *, forwards: bool = False) -> dict[Parameter, float]:
    """A random change of all parameters, of a third of their scales at most."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    low = 0.1 if forwards else -1.0
    return {each: 0.3 * each.scale * float(rng.uniform(low, 1.0)) for each in parameters}


def along(
    slopes: list[dict[str, int | float | str]], way: Mapping[Parameter, float]
) -> list[dict[str, float]]:
    """Rows of the derivatives in a direction."""
    parts = [differences.by_parameter(slopes, p.key, rate) for p, rate in way.items()]
    return [
        {name: sum(part[i][name] for part in parts) for name in row}
        for i, row in enumerate(parts[0])
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("experiment", "overrides", "allowed"),
    [
        ("bending", ("extensions.gravity_pitch.pitch_deg=-40", *TO_50_kPa, *FEW,
                     *differences.INSTRUMENTS[:3]), ELASTIC),
        ("blocked_force", (*differences.BLOCKED, *differences.COMPLIANT), ELASTIC),
        ("bending", ("extensions.prony={}", "extensions.set_point_logged={}",
                     "extensions.sensor_lag={}", *FEW, *differences.CYCLES), LASTING),
        ("blocked_force", ("extensions.plate_friction={}", "plate.tilt_deg=5",
                           *FEW, *differences.CYCLES), LASTING),
        ("bending", (*VOLUME, *FEW, "extensions.wall_offset={}"), ELASTIC),
        ("blocked_force", (*VOLUME, "extensions.prony={}", "extensions.plate_compliance={}",
                           *FEW, "plate.tilt_deg=5", "experiment.unload=true"), LASTING),
        ("bending", (*differences.MOTION, *FEW), ELASTIC),
        ("bending", (*differences.SUPPLIED, "solver.max_step_s=0.02", *FEW), ELASTIC),
    ],
    ids=["hanging", "bellows touch", "viscous cycles", "frictional cycles", "controlled by volume",
         "viscous, controlled by volume", "in motion", "supplied with air"],
)  # fmt: skip
def test_all_parameters(experiment: str, overrides: tuple[str, ...], allowed: float) -> None:
    at = settings(*overrides)
    parameters = chosen(at, None)
    base, slopes = differences.derivatives(experiment, at, parameters)
    way = direction(parameters)
    found = along(slopes, way)
    # the scale of a direction of so many parameters is that of their number's root
    scale = 0.3 * np.sqrt(len(parameters) / 3)
    worst, column = differences.error(base, found, differences.difference(experiment, at, way))
    print("largest error", worst / scale, column, "of", len(parameters), "parameters")
    assert worst / scale < allowed


@pytest.mark.slow
def test_derivatives_where_effects_do_nothing_are_those_of_starting_them() -> None:
    """At neutral values the derivative is finite and not 0; one-sided differences of second order.

    The steps are a hundredth of the priors' spreads, whose curvature leaves 1e-4.
    """
    neutral = (
        "extensions.gent.inverse_J_m=0", "extensions.mooney_rivlin.C01_MPa=0",
        "extensions.set_point_logged.tau_s=0", "extensions.prony.g=[0]",
        "extensions.pressure_offset.offset_kPa=0", "extensions.angle_gain.gain=1",
        *TO_50_kPa, *FEW, "experiment.unload=true", "contact.self_contact=false",
    )  # fmt: skip
    at = settings(*neutral)
    keys = [text.partition("=")[0] for text in neutral[:6]]
    parameters = find(at, keys)
    base, slopes = differences.derivatives("bending", at, parameters)
    for parameter in parameters:
        step = 0.01 * parameter.scale
        runs = [
            differences.rows("bending", at, parameter.at(at, parameter.value(at) + k * step))
            for k in (1, 2)
        ]
        found = differences.by_parameter(slopes, parameter.key, 1.0)
        expected = [
            (-1.5 * row["angle_deg"] + 2 * a["angle_deg"] - 0.5 * b["angle_deg"]) / step
            for row, a, b in zip(base, *runs, strict=True)
        ]
        angles = np.array([row["angle_deg"] for row in found])
        print(parameter.key, angles, expected)
        largest = np.abs(expected).max()
        assert largest * parameter.scale > 1e-5  # degrees
        np.testing.assert_allclose(angles, expected, atol=2e-3 * largest)


def test_every_effect_registers_its_numbers() -> None:
    """All real numbers of all effects, with units, bounds and priors; choices are marked."""
    from dolfingrip.extensions.index import EFFECTS

    on = [f"extensions.{effect.name()}={{}}" for effect in EFFECTS]
    found = every(config.load(None, assignments(on)))
    keys = [parameter.key for parameter in found]
    assert len(keys) == len(set(keys))
    for effect in EFFECTS:
        own = [p for p in found if p.key.startswith(f"extensions.{effect.name()}.")]
        if effect.kind == "numerical":
            assert all(parameter.entry is Entry.CHOICE for parameter in own)
            continue
        assert own, effect.name()
        for parameter in own:
            assert parameter.scale > 0
            assert parameter.low < parameter.high
            if parameter.key.partition("[")[0].rpartition(".")[2] in effect.priors():
                assert parameter.prior is not None


@pytest.mark.parametrize(
    ("keys", "overrides", "said"),
    [
        (["finger.wal_mm"], (), "--parameters finger.wal_mm: no parameter of this configuration"),
        (
            ["extensions.coarse_mesh.factor"],
            ("extensions.coarse_mesh={}",),
            "allowed: extensions.coarse_mesh, the difference of two runs",
        ),
        (
            [],
            ("experiment.control=volume", "gravity.acceleration_m_s2=9.81"),
            "with --gradients or --bands and gravity",
        ),
    ],
)
def test_what_has_no_derivative_says_so(
    keys: list[str], overrides: tuple[str, ...], said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        chosen(config.load(None, assignments(overrides)), keys)


@pytest.mark.parametrize("on", [(), ("extensions.coarse_mesh.factor=1.5",)], ids=["off", "on"])
def test_a_choice_of_the_model_has_the_difference_of_two_runs(
    on: tuple[str, ...], tmp_path: Path
) -> None:
    """With minus without, whether the configuration has the choice or not."""
    low = ("experiment.max_pressure_kPa=25", "experiment.step_kPa=25")
    told = []
    result = run(
        "bending", small.short(*low, *on), comm=small.SELF, out=tmp_path,
        gradients=["extensions.coarse_mesh"], progress=told.append,
    )  # fmt: skip
    without, with_it = (
        run("bending", small.short(*low, *setting), comm=small.SELF)
        for setting in ((), ("extensions.coarse_mesh={}",))
    )
    assert len(told) == 2 * len(result.rows)
    found = {(row["row"], row["column"]): row["derivative"] for row in result.sensitivities}
    for name in ("angle_deg", "tip_x_mm", "cavity_volume_mm3"):
        expected = with_it.column(name) - without.column(name)
        assert [found[i, name] for i in range(2)] == pytest.approx(expected, abs=1e-12)
        assert abs(expected[-1]) > 1e-6
    assert result.second_runs == {"extensions.coarse_mesh": None}
    text = (tmp_path / "sensitivity.csv").read_text(encoding="utf-8")
    assert "1,angle_deg,extensions.coarse_mesh (with minus without)," in text


def test_a_run_with_derivatives_is_the_same_run() -> None:
    """Readings and iterations are those of a run without; one factorisation more, at rest."""
    at = small.short("experiment.step_kPa=25")
    plain, derived = (
        run("bending", at, comm=small.SELF, gradients=keys)
        for keys in (None, ["material.mu_MPa", "finger.wall_mm"])
    )
    for name in ("angle_deg", "tip_x_mm", "cavity_volume_mm3"):
        np.testing.assert_array_equal(plain.column(name), derived.column(name))
    newton = [result.facts.newton for result in (plain, derived)]
    assert newton[0].iterations == newton[1].iterations
    more = newton[1].factorisations - newton[0].factorisations
    assert more == 1
    assert {row["parameter"] for row in derived.sensitivities} == {
        "material.mu_MPa", "finger.wall_mm",
    }  # fmt: skip
