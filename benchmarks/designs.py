"""Designs by gradients: what each step beyond the paper buys, random starts, the paper's front.

``python -m benchmarks.designs steps`` solves the problems of :data:`STEPS` on the paper's finger
and writes ``design_steps.csv``; ``starts`` begins at twenty places on a short, coarse finger and
writes ``design_starts.csv``; ``tube`` makes an actuator that bends of a bare tube and writes
``design_tube.csv``; ``gripper`` searches for finger and pose together and writes
``design_gripper.csv``; ``front`` compares what is learnt from gradients with what is learnt from
the 208 designs of ``paper_designs.csv``, and writes ``design_front.csv``. The last three
draw pictures in ``docs``. All go on where they were stopped.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from benchmarks.fronts import front
from dolfingrip import config as configuration
from dolfingrip.charts.theme import BLUE, INK, ORANGE, figure_theme
from dolfingrip.design.gradient import run
from dolfingrip.design.gradient import starts as several
from dolfingrip.design.gradient.descent import Descent, Trial
from dolfingrip.design.gradient.evaluation import DesignSimulations
from dolfingrip.design.gradient.file import FACING
from dolfingrip.design.gradient.problem import Constraint, Problem
from dolfingrip.design.gradient.read import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.diagnosis.results import write
from dolfingrip.experiments import run as simulate
from dolfingrip.experiments.simulate import computed_in
from dolfingrip.files import table
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.meshes.adoption.sound import check_crossings
from dolfingrip.meshes.solid import MeshError
from dolfingrip.report.page import finger as report
from dolfingrip.report.shape_change import draw_section
from dolfingrip.report.skin import extract_skin

HERE = Path(__file__).parent
PICTURES = HERE.parent / "docs"
EXAMPLES = HERE.parent / "examples"
FINGER = EXAMPLES / "paper_finger.toml"
PAPER = (EXAMPLES / "paper_design.toml").read_text(encoding="utf-8")
FREE = (EXAMPLES / "free_design.toml").read_text(encoding="utf-8")
TUBE = EXAMPLES / "tube_design.toml"
GRIPPER = EXAMPLES / "gripper_design.toml"
ROBUST = "".join(
    f'\n[[scenarios]]\nchange = ["{change}"]\n'
    for change in (
        "finger.wall_mm=0.1", "finger.wall_mm=-0.1", "material.mu_MPa=0.293",
        "material.mu_MPa=-0.293",
    )
)  # fmt: skip
"""±0.1 mm of wall, and ±10 % of the modulus."""

COUPONS = EXAMPLES / "coupons" / "ninjaflex_uniaxial.csv"
EXTENDED = "extended.toml"
"""Stands for the model that a diagnosis of printed coupons writes; see :func:`_extended`."""

STEPS = {
    "two numbers (the paper)": PAPER,
    "two numbers, mean of 100, 175 and 250 kPa": PAPER.replace("250.0", "[100.0, 175.0, 250.0]"),
    "two numbers, the worst of walls and moduli": PAPER.replace("= 15", "= 60") + ROBUST,
    "two numbers, the worse of the model and a diagnosis's": PAPER.replace("= 15", "= 30")
    + f'\n[[scenarios]]\nconfig = "{EXTENDED}"\n',
    "eleven numbers": FREE[: FREE.index("[free_form]")] + "[method]\nsimulations = 40\n",
    "eleven numbers and a free form": FREE,
}
"""Design files by what they are."""

SHORT = (
    "mesh.size_mm=6", "mesh.edge_size_mm=6", "finger.length_mm=38", "finger.bellows=2",
    "finger.gap_mm=0.6", "experiment.max_pressure_kPa=150",
)  # fmt: skip
START = """
set = {set}
[objective]
maximise = "force_N"
at_pressure_kPa = 150.0
[[constraints]]
of = "cog_offset_mm"
at_most = 3.2
[[constraints]]
of = "least_wall_mm"
at_least = 0.7
[parameters]
morph.xi1 = [-0.2, 1.0]
morph.xi2 = [-0.5, 0.6]
finger.wall_mm = [0.8, 2.0]
finger.gap_mm = [0.4, 1.2]
[method]
simulations = 12
starts = 20
"""


def _read(text: str) -> Problem:
    """The problem of a text, whose files are those of the examples."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml", dir=EXAMPLES, encoding="utf-8") as file:
        file.write(text)
        file.flush()
        return read(Path(file.name))


def _solved(problem: Problem, out: Path, pool: Pool) -> Descent:
    compute = computed_in(out, pool)
    return several.solve(problem, compute, lambda trial, limits: None).best(problem)


def _extended(out: Path) -> Path:
    """The extended model of the paper's finger by the diagnosis of eight printed coupons."""
    file = out / EXTENDED
    if not file.exists():
        write(
            diagnose([COUPONS], configuration.load(FINGER), out, DiagnosisSettings()),
            [COUPONS],
            out,
        )
    return file.resolve()


def steps(out: Path, pool: Pool) -> list[dict[str, Any]]:
    """A row for each problem."""
    found: list[dict[str, Any]] = []
    extended = _extended(out / "diagnosis")
    for number, (name, text) in enumerate(STEPS.items()):
        problem = _read(text.replace(f'"{EXTENDED}"', f'"{extended}"'))
        begun = time.process_time()
        one = _solved(problem, out / str(number), pool)
        own_s = time.process_time() - begun
        told = run.facts(problem, one, None, 0.0)
        found.append(
            {
                "problem": name,
                "numbers": len(problem.variables),
                "simulations": one.simulations,
                "simulations_s": round(one.seconds, 1),  # of load paths, with derivatives
                "steps_s": round(own_s, 1),  # of processor between them
                "start_N": round(one.start.objective, 4),
                "best_N": round(one.best.objective, 4),
                "gain_percent": round(100 * (told.gain or 0.0), 2),
                "limits_kept": all(each.kept for each in told.constraints),
                "xi1": round(told.parameters["morph.xi1"].value, 4),
                "xi2": round(told.parameters["morph.xi2"].value, 4),
            }
        )
        print(found[-1], flush=True)
        table.write(HERE / "design_steps.csv", found)
    return found


def starts(out: Path, pool: Pool) -> list[dict[str, Any]]:
    """A row for each start, all on one mesh."""
    problem = _read(START.format(set=list(SHORT)).replace("'", '"'))
    every = several.solve(problem, computed_in(out, pool), lambda trial, limits: None)
    told = every.facts(problem)
    found: list[dict[str, Any]] = []
    for number, (one, each) in enumerate(zip(every.descents, told["starts"], strict=True)):
        row: dict[str, Any] = {"start": number, "ending": each["ending"]}
        if isinstance(one, Descent):
            taken = [each.objective for each in one.trials if each.accepted]
            row |= {
                "simulations": one.simulations,
                "accepted": len(taken),
                "rejected": sum(not each.accepted for each in one.trials),
                "failed": sum(bool(each.failure) for each in one.trials),
                "every_accepted_step_improves": bool((np.diff(taken) > 0).all()),
                "intersections": sum(
                    bool(_intersects(problem, each, out)) for each in one.trials if each.accepted
                ),
                "start_N": round(one.start.objective, 4),
                "best_N": round(one.best.objective, 4),
                "as_good": each["as_good"],
                "cog_offset_mm": round(one.best.limits[0], 4),
                "least_wall_mm": round(one.best.limits[1], 4),
                **{
                    variable.key: round(float(value), 4)
                    for variable, value in zip(problem.variables, one.best.values, strict=True)
                },
            }
        found.append(row)
        print(row, flush=True)
    print("differs between the best designs:", told["differ"] or "nothing")
    keys = max(found, key=len)
    shown = [{key: each.get(key) for key in keys} for each in found]
    table.write(HERE / "design_starts.csv", shown)
    return found


def _intersects(problem: Problem, trial: Trial, out: Path) -> str:
    """Where the finger's surface, its chambers included, passes through itself; "" if nowhere.

    All triangles of the boundary are looked at in each state of the load path, by a search of its
    own: the model's contact sees the skin alone.
    """
    states = simulate(str(problem.objective.experiment), trial.shape.config, out=out / "checked")
    fields = report.read(out / "checked" / "fields.pvd", len(states))
    skin = extract_skin(fields.mesh)
    for displacement in fields.displacements:
        try:
            check_crossings(skin.move(displacement), skin.triangles)
        except MeshError as error:
            return str(error)
    return ""


def tube(out: Path, pool: Pool) -> list[dict[str, Any]]:
    """A row for each accepted design on the way from a tube."""
    problem = read(TUBE)
    compute = computed_in(out, pool)
    begun = time.process_time()
    one = several.solve(problem, compute, lambda trial, limits: None).best(problem)
    own_s = time.process_time() - begun
    found: list[dict[str, Any]] = [
        {
            "simulations": each.simulations,
            "angle_deg": round(each.objective, 2),
            **{name: round(each.shape.value(name), 3) for name in FACING[::2]},
        }
        for each in one.trials
        if each.accepted
    ]
    table.write(HERE / "design_tube.csv", found)
    print(*found, sep="\n", flush=True)
    meshes = one.best.shape.mesh, one.start.shape.mesh
    draw_section(*meshes, f"{one.best.objective:.1f}° at 60 kPa", PICTURES / "design_tube.png")
    print(f"{one.ending}; simulations {one.seconds:.0f} s, steps {own_s:.0f} s of processor")
    run.write(run.facts(problem, one, None, 0.0), one, out)
    for each in one.trials:
        if each.accepted:
            where = _intersects(problem, each, out)
            print(f"{each.objective:.1f}°: {where or 'no intersection'}", flush=True)
    best = one.best.shape.config
    finer = simulate("bending", best.changed(mesh={"refine": best.mesh.refine + 1}))
    print(f"cells two thirds as large: {finer.rows[-1]['angle_deg']:.1f}°")
    return found


def gripper(out: Path, pool: Pool) -> list[dict[str, Any]]:
    """A row for each food: what the paper's gripper, its finger in the new pose, and both bear."""
    problem = read(GRIPPER)
    compute = computed_in(out, pool)
    one = several.solve(problem, compute, _said).best(problem)
    own = np.array([each.key.startswith("morph.") for each in problem.variables])
    posed = np.where(own, one.start.values, one.best.values)
    made = {
        "paper's finger": one.start.values,
        "paper's finger, new pose": posed,
        "new finger and pose": one.best.values,
    }
    found: list[dict[str, Any]] = []
    for name, values in made.items():
        answer = DesignSimulations(problem, compute).at(values, gradients=False)
        for condition, by in zip(problem.conditions, answer.by_condition, strict=True):
            found.append(
                {
                    "design": name,
                    "food": condition.base.food.kind,
                    "pickup_margin": round(by[problem.objective].value, 4) if by else None,
                    **{
                        variable.key: round(float(value), 4)
                        for variable, value in zip(problem.variables, values, strict=True)
                    },
                }
            )
            print(found[-1], flush=True)
    table.write(HERE / "design_gripper.csv", found)
    _draw_margins(found, list(made), PICTURES / "design_gripper.png")
    print(f"{one.ending}; {one.simulations} grasps, {one.seconds:.0f} s")
    return found


def _draw_margins(found: Sequence[dict[str, Any]], designs: Sequence[str], file: Path) -> None:
    foods = list(dict.fromkeys(row["food"] for row in found))
    with figure_theme():
        figure, axes = plt.subplots(figsize=(5.2, 3.0), layout="constrained")
        for i, (design, colour) in enumerate(zip(designs, (INK, ORANGE, BLUE), strict=True)):
            margins = [row["pickup_margin"] or 0.0 for row in found if row["design"] == design]
            places = np.arange(len(foods)) + 0.27 * (i - 1)
            bars = axes.bar(places, margins, 0.25, color=colour, label=design)
            axes.bar_label(bars, [f"{each:.2f}" for each in margins], fontsize=7, padding=1)
        axes.set_xticks(range(len(foods)), foods)
        axes.set_ylabel("pick-up margin (weights of the food)")
        axes.margins(y=0.12)
        axes.legend()
        figure.savefig(file, dpi=200)
        plt.close(figure)


def _said(trial: Trial, limits: Sequence[tuple[Constraint, float]]) -> None:
    margins = ", ".join(f"{-each:.3f}" for each in trial.signed)
    print(f"{trial.simulations} grasps: {margins or trial.failure}", flush=True)


PARTS = {"steps": steps, "starts": starts, "tube": tube, "gripper": gripper, "front": front}


def main(arguments: Sequence[str]) -> None:
    """Run one of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=list(PARTS))
    parser.add_argument("--out", type=Path, default=Path("out/designs"))
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args(arguments)
    with Pool(Where(workers=given.workers)) as pool:
        PARTS[given.what](given.out / given.what, pool)


if __name__ == "__main__":
    main(sys.argv[1:])
