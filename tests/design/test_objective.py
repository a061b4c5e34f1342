"""One real, coarse design: its numbers are those of the experiment, on one rank and on two."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import dolfinx
import pytest
from support.small import short

from dolfingrip import experiments
from dolfingrip.config import ConfigError, from_dict, load
from dolfingrip.design.campaign import plan
from dolfingrip.design.optimum import study_file
from dolfingrip.design.optimum.study_file import PublishedDesign
from dolfingrip.design.quantities.index import parse
from dolfingrip.design.quantities.quantity import Outcome
from dolfingrip.experiments.derivatives.gradients import COG, MASS, shape_number
from dolfingrip.jobs.job import JobResult
from dolfingrip.jobs.work import compute
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.measures import centroid
from dolfingrip.parameter import find
from dolfingrip.sections.tables import assignments

QUANTITIES = ("cog_offset_mm", "force_N")
STUDY = study_file.read(Path(__file__).resolve().parents[2] / "examples" / "paper_study.toml")
assert STUDY.published is not None
PAPER = STUDY.published


def asked(
    *overrides: str,
    ranks: int = 1,
    quantities: tuple[str, ...] = QUANTITIES,
    gradients: tuple[str, ...] | None = None,
    **inputs: float,
) -> tuple[dict[str, Any], JobResult]:
    points = ({f"morph.{name}": value for name, value in inputs.items()},)
    base = short("experiment.step_kPa=25", *overrides)
    wanted = plan.Plan(base, tuple(points[0]), points, quantities, gradients=gradients)
    (job,) = wanted.jobs(ranks)
    return job.arguments["config"], compute(job)


def outcome_of(answer: JobResult) -> Outcome:
    """What the objective function returned."""
    assert answer.status == "done", answer.failure
    assert answer.result is not None
    return Outcome(**answer.result)


@pytest.mark.parametrize("design", PAPER.designs, ids=lambda each: f"{each.limit:g}")
def test_the_reference_finger_s_optima_have_the_paper_s_offsets(design: PublishedDesign) -> None:
    """On any mesh, as the centroid of boxes is exact; 0.01 mm moves an optimum by 0.003 in ξ."""
    xi1, xi2 = design.inputs
    config = load(None, assignments(["mesh.size_mm=10", "morph.d_mm=9.5"]))
    found, _ = shape_number(COG, config.changed(morph={"xi1": xi1, "xi2": xi2}))
    assert found == pytest.approx(design.limit, abs=0.015)


def test_a_design_s_force_is_that_at_the_highest_pressure() -> None:
    """Where the finger is vented again that is not the last reading."""
    low = ("experiment.max_pressure_kPa=25", "experiment.unload=true")
    _, answer = asked(*low, quantities=("force_N",), gradients=(), xi1=0.1, xi2=0.0)
    outcome = outcome_of(answer)
    assert outcome.curve is not None
    first, highest, last = outcome.curve["force_N"]
    assert highest > 2 * max(abs(first), abs(last))
    assert outcome.outputs["force_N"] == highest


def test_a_design_s_numbers_are_the_experiment_s() -> None:
    config, answer = asked(xi1=0.3, xi2=-0.3)
    outcome = outcome_of(answer)
    resolved = from_dict(config)
    assert (resolved.morph.xi1, resolved.morph.xi2) == (0.3, -0.3)
    expected = experiments.run("blocked_force", resolved)
    assert outcome.outputs["force_N"] == pytest.approx(expected.rows[-1]["force_N"], rel=1e-10)
    assert outcome.curve is not None
    assert outcome.curve["blocked_pressure_kPa"] == [0.0, 25.0, 50.0]
    assert outcome.curve["force_N"][-1] == outcome.outputs["force_N"]
    # unmorphed, the solid's centroid is nearer to the back of the base layer's region A
    x = centroid(finger_mesh(resolved.finger, resolved.mesh))[0] - resolved.cog.x_ref_mm
    assert outcome.outputs["cog_offset_mm"] != pytest.approx(x, abs=0.05)
    assert outcome.gradients is not None
    assert list(outcome.gradients) == list(QUANTITIES)
    assert {*outcome.gradients["force_N"]} == {"morph.xi1", "morph.xi2"}
    assert outcome.iterations is not None
    assert outcome.iterations > 4
    assert outcome.versions["dolfinx"] == dolfinx.__version__


def test_derivatives_that_are_asked_for() -> None:
    """Those of the force are the experiment's, by another way for ξ1; of the centroid, differences.

    A finger of boxes has its exact centroid on any mesh, so that differences of remeshed fingers
    are good to the step's square; the force by the wall is the experiment's moved mesh.
    """
    keys = ("material.mu_MPa", "finger.wall_mm", "morph.xi1", "extensions.no_self_contact")
    touching = ("finger.gap_mm=0.3", "experiment.max_pressure_kPa=75", "solver.rtol=1e-12")
    config, answer = asked(*touching, gradients=keys, xi1=0.2)
    outcome = outcome_of(answer)
    assert outcome.gradients is not None
    label = "extensions.no_self_contact (with minus without)"
    for slopes in outcome.gradients.values():
        assert list(slopes) == [*keys[:3], label]
    resolved = from_dict(config)
    result = experiments.run("blocked_force", resolved, gradients=keys)
    last = len(result.rows) - 1
    expected = {
        row["parameter"]: row["derivative"]
        for row in result.sensitivities
        if (row["row"], row["column"]) == (last, "force_N")
    }
    assert outcome.gradients["force_N"] == pytest.approx(expected, rel=1e-5)
    assert all(abs(value) > 1e-4 for value in expected.values())
    for key in keys[:3]:
        (parameter,) = find(resolved, [key])
        slope = parameter.derivative(resolved, lambda changed: shape_number(COG, changed)[0])
        assert outcome.gradients["cog_offset_mm"][key] == pytest.approx(slope, abs=1e-6)
    assert outcome.gradients["cog_offset_mm"]["finger.wall_mm"] > 0.1
    assert outcome.gradients["cog_offset_mm"][label] == 0.0


def test_readings_at_places_and_the_mass() -> None:
    """They are the experiment's there, whatever the stops are; the mass is that of the solid."""
    names = ("mass_g", "force_N at 20 kPa", "force_N at 10, 20 kPa", "force_N")
    keys = ("finger.wall_mm", "material.density_kg_m3")
    config, answer = asked(quantities=names, gradients=keys[:1], xi1=0.1)
    outcome = outcome_of(answer)
    resolved = from_dict(config)
    stops = resolved.changed(experiment={"step_kPa": 10})
    result = experiments.run("blocked_force", stops, gradients=keys[:1])
    force = dict(zip(result.column("pressure_kPa"), result.column("force_N"), strict=True))
    assert outcome.outputs["force_N at 20 kPa"] == pytest.approx(force[20.0], rel=1e-6)
    mean = (force[10.0] + force[20.0]) / 2
    assert outcome.outputs["force_N at 10, 20 kPa"] == pytest.approx(mean, rel=1e-6)
    assert outcome.outputs["force_N"] == pytest.approx(force[50.0], rel=1e-6)
    expected = {
        row["row"]: row["derivative"] for row in result.sensitivities if row["column"] == "force_N"
    }
    assert outcome.gradients is not None
    slope = outcome.gradients["force_N at 20 kPa"]["finger.wall_mm"]
    assert slope == pytest.approx(expected[2], rel=1e-4)
    mass, slopes = shape_number(MASS, resolved, find(resolved, list(keys)))
    assert outcome.outputs["mass_g"] == mass
    for parameter in find(resolved, list(keys)):
        difference = parameter.derivative(
            resolved, lambda changed: shape_number(MASS, changed, ())[0]
        )
        assert slopes[parameter.key] == pytest.approx(difference, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("force", "allowed: cog_offset_mm, mass_g"),
        ("mass_g at 3 N", "of the unloaded shape; allowed: without a place"),
        ("force_N at 250 mm", "allowed: a place as in force_N at 250 kPa"),
        ("force_N at kPa", "allowed: a place as in force_N at 250 kPa"),
        ("force_N at 3 N", "allowed: another place"),
        ("margin at 100 kPa", "of a grasp"),
        ("angle_deg at 100 kPa in cycle", "allowed: in blocked_force, bending, push"),
        ("force_N in bending", "blocked_force"),
        ("pressure_kPa", "0 places"),
    ],
)
def test_a_wrong_quantity_gets_one_line(text: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text",
    ["force_N", "mass_g", "pickup_margin", "angle_deg at 100 kPa", "pressure_kPa at 3 N",
     "force_N at 30 deg", "angle_deg at 100, 200.5 kPa in blocked_force"],
)  # fmt: skip
def test_the_text_of_a_quantity_is_read_again(text: str) -> None:
    assert str(parse(text)) == text


def test_bellows_are_told_apart_on_a_morphed_finger() -> None:
    """The floor of the gaps moves with the morph."""
    for xi1, xi2 in ((1.0, -0.5), (-0.2, 1.0)):
        result = experiments.run("bending", short(f"morph.xi1={xi1}", f"morph.xi2={xi2}"))
        assert result.rows[0]["contact_gap_mm"] == pytest.approx(2.0, abs=1e-9)


@pytest.mark.parametrize(
    ("override", "kind", "said"),
    [
        ("finger.wall_mm=3.9999999", "geometry", "leaves 2e-07 mm between two faces"),
        ("solver.max_iterations=1", "iteration limit", "stopped at 0 kPa"),
        ("solver.time_limit_s=1e-6", "time limit", "stopped at 0 kPa (time limit): solver.time"),
    ],
)
def test_failures_have_class_and_sentence(override: str, kind: str, said: str) -> None:
    step = "solver.min_step_kPa=20"
    _, answer = asked(override, step, xi1=0.1)
    assert (answer.status, answer.failure_class) == ("failed", kind)
    assert said in str(answer.failure)
    assert answer.result is None


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun")
def test_two_ranks_give_the_same() -> None:
    low = ("experiment.max_pressure_kPa=10", "experiment.step_kPa=10")
    quantities = ("angle_deg", "cog_offset_mm")
    keys = ("material.mu_MPa", "morph.xi1")
    _, alone = asked(*low, xi1=0.1, quantities=quantities, gradients=keys)
    _, both = asked(*low, xi1=0.1, ranks=2, quantities=quantities, gradients=keys)
    one, two = outcome_of(alone), outcome_of(both)
    assert two.outputs == pytest.approx(one.outputs, rel=1e-8)
    assert one.gradients is not None
    assert two.gradients is not None
    for name, slopes in one.gradients.items():
        assert two.gradients[name] == pytest.approx(slopes, rel=1e-5)
        assert list(slopes) == list(keys)
    _, failed = asked("finger.wall_mm=3.9999999", xi1=0.1, ranks=2)
    assert failed.failure_class == "geometry"
