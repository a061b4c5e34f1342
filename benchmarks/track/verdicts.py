"""Whether a video of a finger leads to the verdict that the truth leads to.

    scripts/run python -m benchmarks.track.verdicts [--only NUMBER …] [--out out/verdicts]

Short fingers with a hidden cause are rendered while their pressure stops six times. One reading
at each stop is diagnosed twice: as ``track`` reads it, and as it truly is with the noise that a
single frame has. The last video hides a camera's tilt of 8° beside a scale of two points. It writes
``benchmarks/track_verdicts.csv``. A case takes some two minutes of one core.
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import tomlkit
from support import small

from benchmarks.blind.answers import spent_s
from benchmarks.outcomes import commit
from benchmarks.track.render import Scene, render
from benchmarks.track.scenes import asked, scene
from benchmarks.track.shapes import shapes
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis, diagnosed
from dolfingrip.diagnosis.data import measurement
from dolfingrip.diagnosis.screening import analyse, simulator_of
from dolfingrip.diagnosis.simulation.runner import staying
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.files import table
from dolfingrip.jobs.run import silent
from dolfingrip.tracking import frames, track, watch
from dolfingrip.tracking.table import write as write_tables

TABLE: Final = Path(__file__).parents[1] / "track_verdicts.csv"
HIDDEN: Final[tuple[Mapping[str, Mapping[str, float]], ...]] = (
    {"base_layer_offset": {"offset_mm": 0.8}},
    {"base_layer_offset": {"offset_mm": -0.7}},
    {"wall_offset": {"offset_mm": 0.5}},
    {"uneven_stiffness": {"a_1": 0.5}},
    {"uneven_stiffness": {"a_1": -0.5}},
    {"uneven_stiffness": {"b_1": 0.6}},
    {"uneven_stiffness": {"b_1": -0.6}},
    {"uneven_stiffness": {"b_0": 0.6}},
    {"uneven_stiffness": {"b_0": -0.6}},
    {"uneven_stiffness": {"a_2": 0.6}},
    {},
)
"""Hidden causes by the number of the video; none beside the camera's tilt."""
BODY: Final = ("base_layer_offset", "wall_offset", "pressure_offset", "uneven_stiffness")
CAMERA: Final = ("camera_scale", "camera_tilt", "camera_zero", "camera_clock")
STOPS: Final = 5
"""Of the pressure above 0."""
FRAMES: Final = 6
"""Of each stop."""
TILT_DEG: Final = 8.0


def finger(number: int) -> Config:
    """The model that is diagnosed, on so few elements that it takes seconds.

    It has two bellows; eight where a tilt is hidden, as that is seen where a finger bends far.

    Args:
        number: of the video.
    """
    length = small.short if HIDDEN[number] else small.coarse
    return length(
        *small.FEW, "mesh.edge_size_mm=6", "solver.rtol=1e-9", "experiment.max_pressure_kPa=200",
        "experiment.step_kPa=20",
    )  # fmt: skip


def filmed(number: int) -> Scene:
    """The settings of a video: those of another one of the benchmark, of a stand and a lamp."""
    drawn = scene(3 * number if HIDDEN[number] else 29)
    tilt = {"tilt_deg": TILT_DEG, "tilt_way_deg": 80.0, "distance_mm": 250.0}
    rate_hz = 30.0
    return replace(
        drawn, finger=f"hidden_{number}", marks="dots", count=5, fingers=1, cable=False, lag_s=0.0,
        light=True, stops=STOPS, gauge_kPa=0.05, rate_hz=rate_hz,
        seconds=FRAMES * (STOPS + 1) / rate_hz, size_px=(1920, 1080),
        **({} if HIDDEN[number] else tilt),
    )  # fmt: skip


def written(number: int, stem: Path, out: Path) -> tuple[Path, Path]:
    """Track a video, and write its readings at the stops and the true ones."""
    own, config = filmed(number), finger(number)
    truth = dict(np.load(stem.with_suffix(".npz")))
    columns = {
        name: np.array(each, dtype=float)
        for name, each in table.read_csv(stem.with_suffix(".log.csv")).items()
    }
    columns["event"] = columns.pop("light")
    source, told = frames.open_frames([stem.with_suffix(".mp4")]), asked(own, truth)
    watched = watch.watch(source, told, lambda done, total: None)
    tracked = track.understand(watched, told, columns, config)
    (seen,) = write_tables(tracked, out, config, "video")
    read = table.read_csv(seen)
    stops_s = own.seconds * (np.arange(STOPS + 1) + 0.4) / (STOPS + 0.75)
    times_s = np.array(read["time_s"], dtype=float)
    at = np.abs(times_s - stops_s[:, None]).argmin(axis=1)
    rows = [{name: values[i] for name, values in read.items()} for i in at]
    table.write(seen, rows)
    setup = tomllib.loads(seen.with_suffix(".toml").read_text(encoding="utf-8"))
    noise = {name: std for name, std in setup["noise"].items() if name != "correlated"}
    rng = np.random.default_rng(own.seed)
    print("seed", own.seed)
    frame = np.abs(truth["time_s"] - stops_s[:, None]).argmin(axis=1)
    for i, row in zip(frame, rows, strict=True):
        for point, places in enumerate(truth["marks_mm"][0, i], 1):
            for axis, place in zip("xz", places, strict=True):
                name = f"marker_{point}_{axis}_mm"
                row[name] = f"{place + noise[name] * rng.standard_normal():.5f}"
    true = out / "true.csv"
    table.write(true, rows)
    at_rest = truth["marks_mm"][0, 0].round(4).tolist()
    text = {"experiment": "bending", "noise": noise, "camera": {"markers": at_rest}}
    true.with_suffix(".toml").write_text(tomlkit.dumps(text), encoding="utf-8")
    return seen, true


def answer(file: Path, config: Config, out: Path, tried: tuple[str, ...]) -> Diagnosis:
    """Diagnose a table up to its verdict."""
    read, _ = measurement.selected(measurement.read([file], config), config)
    with staying(out, 1, silent) as kept:
        analysis = analyse(
            simulator_of(read, config, kept), unknowns(read, config, tried), quick=True
        )
        return diagnosed(analysis, config)


def said(found: Diagnosis) -> str:
    """The verdict in a cell: each set of causes, or none or unknown."""
    sets = [found.decision.first, found.decision.second]
    named = " + ".join(" or ".join(sorted(each)) for each in sets if each)
    return named if found.decision.answer == "cause" else found.decision.answer


def seen_std(found: Diagnosis, number: int) -> str:
    """Standard deviations by which what is hidden changes the readings, after all else."""
    (hidden,) = HIDDEN[number] or ("camera_tilt",)
    return f"{max(found.none.misfit - found.member(hidden).misfit, 0) ** 0.5:.1f}"


def case(number: int, out: Path) -> dict[str, Any]:
    """The row of a video."""
    own, stem, folder = filmed(number), out / f"{number:02d}", out / f"{number:02d}"
    begun_s, config = spent_s(), finger(number)
    if not stem.with_suffix(".npz").exists():
        truth = config.changed(extensions=HIDDEN[number]) if HIDDEN[number] else config
        render(own, shapes(own.finger, out / "shapes", truth), stem)
    seen, true = written(number, stem, folder)
    simulations = folder / "simulations"
    video = answer(seen, config, simulations, BODY + CAMERA)
    hidden = " ".join(
        f"{name}.{key}={value:g}"
        for name, each in HIDDEN[number].items()
        for key, value in each.items()
    )
    row = {
        "video": number, "hidden": hidden or f"tilt of {TILT_DEG:g}°", "sheet": int(own.sheet),
        "tilt_deg": f"{own.tilt_deg:.1f}", "by_video": said(video),
        "probability_by_video": f"{video.probability:.3f}",
        "seen_std_by_video": seen_std(video, number),
    }  # fmt: skip
    if HIDDEN[number]:
        exact = answer(true, config, simulations, BODY)
        row |= {
            "by_truth": said(exact), "probability_by_truth": f"{exact.probability:.3f}",
            "seen_std_by_truth": seen_std(exact, number),
        }  # fmt: skip
    return row | {"processor_s": f"{spent_s() - begun_s:.0f}", "commit": commit()}


def main() -> None:
    """Render, track, diagnose, and write the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.track.verdicts")
    parser.add_argument("--only", type=int, nargs="*", default=list(range(len(HIDDEN))))
    parser.add_argument("--out", type=Path, default=Path("out/verdicts"))
    told = parser.parse_args()
    rows = []
    for number in told.only:
        file = told.out / f"{number:02d}.csv"
        if not file.exists():
            table.write(file, [case(number, told.out)])
        rows.append({name: each[0] for name, each in table.read_csv(file).items()})
        print(rows[-1], flush=True)
    table.write(TABLE, rows, list(dict.fromkeys(name for row in rows for name in row)))
    hidden = [row for row in rows if row.get("by_truth")]
    alike = sum(row["by_video"] == row["by_truth"] for row in hidden)
    print(f"{alike} of {len(hidden)} with a hidden cause alike")


if __name__ == "__main__":
    main()
