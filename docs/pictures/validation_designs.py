"""Blocked force of the paper's optima and of the original, to 250 kPa (the paper's section IV.C).

    scripts/run python docs/pictures/validation_designs.py

draws ``docs/validation_designs.png`` and prints each design's gain over the original.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from dolfingrip import config
from dolfingrip.charts import theme
from dolfingrip.design.optimum import study_file
from dolfingrip.experiments import Result, run
from dolfingrip.sections.tables import assignments

HERE = Path(__file__).resolve().parent
PICTURE = HERE.parent / "validation_designs.png"
FINGER = HERE.parents[1] / "examples" / "paper_finger.toml"
STUDY = FINGER.with_name("paper_study.toml")
STYLES = (
    ("OD3.5", theme.BLUE, "o"),
    ("OD3", theme.GREEN, "^"),
    ("original", theme.INK, "s"),
    ("OD2.5", theme.ORANGE, "v"),
)


def designs() -> dict[str, tuple[float, ...]]:
    """ξ1 and ξ2 by name."""
    published = study_file.read(STUDY).published
    assert published is not None
    optima = {f"OD{each.limit:g}": each.inputs for each in published.designs}
    return {"original": (0.0, 0.0), **optima}


def blocked(xi: tuple[float, ...]) -> Result:
    """Blocked force of one design of the paper's finger."""
    overrides = ["experiment.step_kPa=12.5", f"morph.xi1={xi[0]}", f"morph.xi2={xi[1]}"]
    return run("blocked_force", config.load(FINGER, assignments(overrides)))


def draw(found: dict[str, Result], path: Path) -> None:
    """Force against pressure, a line each."""
    with theme.figure_theme():
        figure, axes = plt.subplots(figsize=(4.6, 3.4), layout="constrained")
        last = found["original"].column("force_N")[-1]
        for name, colour, marker in STYLES:
            result = found[name]
            force = result.column("force_N")
            gain = "" if name == "original" else f" ({100 * (force[-1] / last - 1):+.1f} %)"
            axes.plot(
                result.column("pressure_kPa"), force, marker + "-", color=colour, ms=3.5,
                label=name + gain,
            )  # fmt: skip
        axes.set(
            xlabel="Pressure (kPa)", ylabel="Blocked force (N)", xlim=(0, None), ylim=(0, None)
        )
        axes.legend(title="design (gain at 250 kPa)", title_fontsize=8)
        figure.savefig(path)
        plt.close(figure)


def main() -> None:
    """Compute, draw and print."""
    found = {}
    for name, xi in designs().items():
        found[name] = result = blocked(xi)
        if result.failure is not None:
            raise SystemExit(f"{name}: {result.failure.sentence()}")
        force = result.column("force_N")[-1]
        gain = 100 * (force / found["original"].column("force_N")[-1] - 1)
        turn = (
            ""
            if result.turning_point is None
            else f", turns at {result.turning_point.pressure_kPa:.0f} kPa"
        )
        print(f"{name}: {force:.3f} N at 250 kPa, {gain:+.1f} %{turn}", flush=True)
    draw(found, PICTURE)


if __name__ == "__main__":
    main()
