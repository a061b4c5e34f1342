"""How well ``track`` reads rendered videos whose truth is known.

    scripts/run python -m benchmarks.track [--only NUMBER …] [--out out/track]

renders 38 videos with settings drawn by seed, the last 8 without marks, tracks them, and writes
``benchmarks/track.csv``.
Videos and answers are kept in ``--out``, so that a second call goes on. A video takes one to four
minutes of one core.

    scripts/run python -m benchmarks.track --example examples/film

renders the video of the example, its log and its truth.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.spatial.distance import cdist

from benchmarks.track.render import Scene, render
from benchmarks.track.scenes import asked, scene
from benchmarks.track.shapes import shapes
from dolfingrip.config import Config
from dolfingrip.files import table
from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking import frames, track, watch

TABLE: Final = Path(__file__).parents[1] / "track.csv"
COUNT: Final = 38
WIDE_90: Final = 1.645
"""Half the width of a 90 % interval, by the standard deviation."""


def judged(own: Scene, stem: Path) -> list[dict[str, Any]]:
    """Rows of the table: each finger's errors, and whether 90 % intervals hold the truth."""
    truth = dict(np.load(stem.with_suffix(".npz")))
    log = table.read_csv(stem.with_suffix(".log.csv"))
    columns = {name: np.array(each, dtype=float) for name, each in log.items()}
    columns["event"] = columns.pop("light")
    source = frames.open_frames([stem.with_suffix(".mp4")])
    told = asked(own, truth)
    begun = time.process_time()
    watched = watch.watch(source, told, lambda done, total: None)
    took = time.process_time() - begun
    tracked = track.understand(watched, told, columns, Config())
    shown = truth["marks_px"]
    in_picture = np.argsort([each[0, :, 0].mean() for each in shown])
    rows = []
    assert tracked.clock is not None
    for body, own_points, which in zip(tracked.bodies, watched.fingers, in_picture, strict=True):
        marks = truth["marks_mm"][which]
        way = np.sign(marks[0, -1, 0] - marks[len(marks) * 3 // 5, -1, 0])
        px = watched.points.px[:, own_points]
        # a tag that is hidden in the first frame is not followed
        there = cdist(px[0], shown[which][0]).argmin(axis=1)
        off = np.linalg.norm(px - shown[which][:, there], axis=2)
        marks = marks[:, there]
        if own.marks == "tags":
            turns = truth["turns"][which][:, there[-1]]
            angle = np.degrees(way * (turns - turns[0]))
        else:
            arm = marks[:, -1] - marks[:, -2]
            angle = np.degrees(np.unwrap(np.arctan2(-way * arm[:, 0], arm[:, 1])))
            angle -= angle[0]
        spacing = np.linalg.norm(np.diff(shown[which][0], axis=0), axis=1).min()
        errors = {"angle": body.readings["angle_deg"] - angle}
        last = marks.shape[1]
        errors["x"] = body.readings[f"marker_{last}_x_mm"] - way * marks[:, -1, 0]
        errors["z"] = body.readings[f"marker_{last}_z_mm"] - marks[:, -1, 1]
        if own.fingers == 2:  # places count from one clamp's mark: from rest
            errors["x"] -= np.nanmedian(errors["x"][:5])
            errors["z"] -= np.nanmedian(errors["z"][:5])
        length = [np.linalg.norm(each[-1] - each[0]) for each in (body.rest_mm, marks[0])]
        spread = tracked.camera.scale(shown[which][0].mean(axis=0))[1]
        late = tracked.clock.shift_s - own.shift_s
        pressures = truth["pressure_kPa"]
        rise = int(np.argmax(pressures))
        held: dict[str, float] = {}
        for label, at in (("half", rise // 2 + 3), ("top", rise)):
            for short, name in (
                ("angle", "angle_deg"), ("x", f"marker_{last}_x_mm"), ("z", f"marker_{last}_z_mm"),
            ):  # fmt: skip
                std = float(np.hypot(body.noise[name][at], body.common[name][at]))
                if np.isfinite(errors[short][at]):
                    held[f"{short}_{label}"] = float(errors[short][at]) / std
        ends_mm = np.hypot(*(body.noise[f"marker_{i}_z_mm"][0] for i in (1, last)))
        held["scale"] = (length[0] / length[1] - 1) / float(np.hypot(spread, ends_mm / length[1]))
        held["shift"] = late / tracked.clock.std_s
        rows.append({
            "video": own.seed, "sheet": int(own.sheet), "marks": own.marks,
            "tilt_deg": f"{own.tilt_deg:.1f}", "light": int(own.light), "lag_s": f"{own.lag_s:.2f}",
            "angle_deg": _rms(errors["angle"]),
            "place_mm": _rms(np.hypot(errors["x"], errors["z"])),
            "swapped": int((off > 0.5 * spacing).sum()),
            "lost_percent": f"{100 * np.isnan(off).mean():.1f}",
            "scale_percent": f"{100 * (length[0] / length[1] - 1):.2f}",
            "shift_frames": f"{late * own.rate_hz:.2f}",
            "s_per_frame": f"{took / len(off):.3f}",
            **{f"by_std_{name}": f"{value:.2f}" for name, value in held.items()},
        })  # fmt: skip
    return rows


def _rms(values: np.ndarray) -> str:
    return f"{np.sqrt(np.nanmean(values**2)):.3f}"


def summary(rows: list[dict[str, Any]]) -> str:
    """The targets' rows over all videos that are done."""
    seen = [row for row in rows if not row.get("refused")]

    def numbers(name: str, kept: list[dict[str, Any]]) -> np.ndarray:
        return np.array([float(row[name]) for row in kept])

    sheet = [row for row in seen if int(row["sheet"])]
    lit = [row for row in seen if int(row["light"])]
    every = np.array(
        [float(v) for row in seen for k, v in row.items() if k.startswith("by_std_") and v]
    )
    lines = [f"{len(seen)} fingers, {len(rows) - len(seen)} refused"]
    if sheet:
        for name in ("angle_deg", "place_mm"):
            own = numbers(name, sheet)
            lines.append(
                f"{name} with a sheet: rms {np.sqrt((own**2).mean()):.3f}, median "
                f"{np.median(own):.3f}, largest {own.max():.3f}"
            )
    if lit:
        lines.append(
            f"shift with a light: largest {np.abs(numbers('shift_frames', lit)).max():.2f} frames"
        )
    lines.append(f"swapped or invented: {numbers('swapped', seen).sum():.0f}")
    lines.append(
        f"90 % intervals that hold: {(np.abs(every) < WIDE_90).mean():.3f} of {len(every)}"
    )
    return "\n".join(lines)


def example(folder: Path, out: Path) -> None:
    """Write a video that is small enough for a repository, its log and its truth.

    Args:
        folder: target.
        out: folder of the shapes.
    """
    own = Scene(rate_hz=20.0, seconds=3.0, tilt_deg=6.0, tilt_way_deg=40.0, k1=-0.04,
                in_front_mm=14.0, decoys=2, bits_per_px=0.04, noise=1.5, shift_s=1.3,
                extra={"target": (12.0, 97.0, 0.0)})  # fmt: skip
    truth = render(own, shapes(own.finger, out / "shapes"), folder / "finger")
    (folder / "finger.log.csv").replace(folder / "log.csv")
    (folder / "finger.npz").unlink()
    x, z = truth["marks_mm"][0].transpose(2, 1, 0)
    angle = np.degrees(np.arctan2(-(x[-1] - x[-2]), z[-1] - z[-2]))
    columns = {
        "time_s": (truth["time_s"], 2), "tip_x_mm": (x[-1], 3), "tip_z_mm": (z[-1], 3),
        "angle_deg": (angle - angle[0], 3),
    }  # fmt: skip
    rows = [
        {name: f"{values[i]:.{digits}f}" for name, (values, digits) in columns.items()}
        for i in range(len(x[-1]))
    ]
    table.write(folder / "truth.csv", rows)


def main() -> None:
    """Render, track and judge."""
    parser = argparse.ArgumentParser(prog="benchmarks.track")
    parser.add_argument("--only", type=int, nargs="*", default=list(range(COUNT)))
    parser.add_argument("--out", type=Path, default=Path("out/track"))
    parser.add_argument("--again", action="store_true", help="track what was tracked before")
    parser.add_argument("--example", type=Path, help="folder of the example that is rendered")
    told = parser.parse_args()
    if told.example is not None:
        example(told.example, told.out)
        return
    rows: list[dict[str, Any]] = []
    for number in told.only:
        own, stem = scene(number), told.out / "videos" / f"{number:02d}"
        if not stem.with_suffix(".npz").exists():
            render(own, shapes(own.finger, told.out / "shapes"), stem)
            table.write(
                stem.with_suffix(".scene.csv"), [{k: str(v) for k, v in asdict(own).items()}]
            )
        file = stem.with_suffix(".judged.csv")
        if told.again or not file.exists():
            try:
                found = judged(own, stem)
            except ConfigError as error:
                found = [{"video": number, "refused": str(error)}]
            table.write(file, found, list(dict.fromkeys(k for row in found for k in row)))
        columns = table.read_csv(file)
        rows += [
            dict(zip(columns, each, strict=True)) for each in zip(*columns.values(), strict=True)
        ]
        print(rows[-1], flush=True)
    names = list(dict.fromkeys(name for row in rows for name in row))
    table.write(TABLE, rows, names)
    print(summary(rows))


if __name__ == "__main__":
    main()
