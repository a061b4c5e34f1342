"""Pressure against volume of a thin-walled bellows finger, under pressure and under volume control.

    scripts/run python docs/pictures/thin_bellows.py

draws ``docs/thin_bellows.png``.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from dolfingrip import config
from dolfingrip.charts import theme
from dolfingrip.experiments import Result, run
from dolfingrip.sections.tables import assignments

HERE = Path(__file__).resolve().parent
PICTURE = HERE.parent / "thin_bellows.png"
EXAMPLE = HERE.parents[1] / "examples" / "thin_bellows.toml"


def bend(*overrides: str) -> Result:
    """The example, with other settings."""
    settings = config.load(EXAMPLE, assignments(overrides))

    def tell(row: dict[str, float]) -> None:
        print(f"{row['cavity_volume_mm3']:8.0f} mm³ {row['pressure_kPa']:7.2f} kPa", flush=True)

    result = run("bending", settings, progress=tell)
    if result.failure is not None:
        print(result.failure.sentence())
    return result


def draw(by_volume: Result, by_pressure: Result, path: Path) -> None:
    """Pressure and angle against the cavity's volume."""
    with theme.figure_theme():
        figure, panels = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained")
        rest = by_volume.column("cavity_volume_mm3")[0]
        for result, style, label in (
            (by_volume, {"color": theme.BLUE, "marker": "o", "ms": 3}, "volume control"),
            (
                by_pressure,
                {"color": theme.ORANGE, "marker": "s", "ms": 5, "ls": ""},
                "pressure control",
            ),
        ):
            ratio = result.column("cavity_volume_mm3") / rest
            for axes, name in zip(panels, ("pressure_kPa", "angle_deg"), strict=True):
                axes.plot(ratio, result.column(name), label=label, **style)
        if by_pressure.failure is not None:
            last = by_pressure.failure.last_good["pressure_kPa"]
            panels[0].axhline(last, color=theme.GREY, lw=0.8, ls="--")
            panels[0].annotate(
                f"pressure control stops: {last:.1f} kPa ({by_pressure.failure.kind})",
                (panels[0].get_xlim()[1], last),
                (-2, 4),
                textcoords="offset points",
                ha="right",
                fontsize=7,
            )
            panels[0].set_ylim(top=1.12 * last)
        panels[0].set_ylabel("pressure (kPa)")
        panels[1].set_ylabel("tip angle (°)")
        for axes in panels:
            axes.set_xlabel("cavity volume / volume at rest")
        panels[1].legend()
        figure.savefig(path)
        plt.close(figure)


if __name__ == "__main__":
    by_volume = bend()
    stopped = bend(
        "experiment.control=pressure", "experiment.max_pressure_kPa=300", "experiment.step_kPa=10"
    )
    draw(by_volume, stopped, PICTURE)
    print(f"wrote {PICTURE}")
