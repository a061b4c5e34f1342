"""Dimensions of the reconstructed finger by which it meets the paper's findings on its optima.

    scripts/run python -m benchmarks.geometry_fit --out out/fit --number 12 \\
        --parameter finger.gap_mm=0.8:2 --parameter finger.channel_width_mm=8:16
    scripts/run python -m benchmarks.geometry_fit --out out/fit \\
        --one finger.gap_mm=1,finger.wall_mm=1.4

A candidate is a set of dimensions. The plane d and the origin of the COG offset follow from the
paper's offsets in closed form; where they cannot be met it is dropped unsolved. Four fingers of the
others are pressed against the plate: the original and the three optima. All that was ever computed
in --out is ranked; a repeated call computes only what is missing.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.cli import progress
from dolfingrip.cli.reproduce_command import PAPER
from dolfingrip.config import Config, ConfigError, Finger
from dolfingrip.design import rows
from dolfingrip.design.campaign import campaign, space
from dolfingrip.design.campaign.cluster import Where
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.design.campaign.store import Store
from dolfingrip.experiments.results import turning_point
from dolfingrip.meshes.morph import Morph

OPTIMA = {limit: (xi1, xi2) for limit, (xi1, xi2, _) in PAPER.items()}
GAINS = {limit: gain for limit, (_, _, gain) in PAPER.items()} | {3.0: 12.1}
"""% at 250 kPa; simulated where the paper has that (section IV.C)."""

TURNING_KPA = 175.0
ORIGINAL_MM = (2.5, 3.0)
"""COG offset of the original: between a limit that lowers the force and one that does not."""

RESIDUAL_MM = 0.03
"""Allowed error of the three offsets (mm); it moves an optimum by 0.01 in ξ."""

PLANES_MM = np.arange(6.0, 13.0, 0.05)
XI = ("morph.xi1", "morph.xi2")


# -- centre of gravity in closed form ------------------------------------------------------------


def layers(finger: Finger) -> list[tuple[float, float, float]]:
    """Slabs of the finger along x: from, to (mm), and the solid's area across them (mm²)."""
    floor, wall, depth = finger.base_layer_mm, finger.wall_mm, finger.depth_mm
    roof = floor + finger.channel_mm
    bellows = finger.bellows_intervals()
    gaps = finger.width_mm * sum(end - start for start, end in finger.gap_intervals())
    inside = sum(end - start - 2 * wall for start, end in bellows)
    chambers = finger.chamber_width_mm * inside
    joint = finger.channel_width * (bellows[-1][1] - bellows[0][0] - 2 * wall - inside)
    found = []
    planes = sorted({0.0, floor, roof, roof + wall, depth - wall, depth})
    for low, high in pairwise(planes):
        middle = (low + high) / 2
        area = finger.width_mm * finger.length_mm
        if middle > roof + wall:
            area -= gaps
        if floor < middle < depth - wall:
            area -= chambers
        if floor < middle < roof:
            area -= joint
        found.append((low, high, area))
    return found


def centroid_mm(finger: Finger, morph: Morph) -> float:
    """x of the morphed solid's centroid."""
    volume = moment = 0.0
    for low, high, area in layers(finger):
        cuts = [low, *([morph.d_mm] if low < morph.d_mm < high else []), high]
        ends = morph.moved(np.array(cuts))
        volume += area * (ends[-1] - ends[0])
        moment += area * (ends[-1] ** 2 - ends[0] ** 2) / 2
    return float(moment / volume)


@dataclass(frozen=True)
class Offsets:
    """The fit of a plane d to the paper's COG offsets.

    Attributes:
        x_ref_mm: origin that fits the three optima best.
        residual_mm: largest miss of the three.
        original_mm: the unmorphed finger's.
    """

    d_mm: float
    x_ref_mm: float
    residual_mm: float
    original_mm: float


def offsets(finger: Finger, d_mm: float) -> Offsets:
    """From the closed form."""
    excess = [centroid_mm(finger, Morph(*xi, d_mm)) - limit for limit, xi in OPTIMA.items()]
    x_ref = float(np.mean(excess))
    residual = float(np.abs(np.array(excess) - x_ref).max())
    return Offsets(d_mm, x_ref, residual, centroid_mm(finger, Morph(0, 0, d_mm)) - x_ref)


def plane(finger: Finger) -> Offsets | None:
    """The plane with the smallest residual of those that meet all conditions."""
    every = (offsets(finger, round(float(d), 2)) for d in PLANES_MM)
    low, high = ORIGINAL_MM
    good = [o for o in every if o.residual_mm <= RESIDUAL_MM and low < o.original_mm < high]
    return min(good, key=lambda each: each.residual_mm, default=None)


# -- candidates ----------------------------------------------------------------------------------


def complete(base: Config, inputs: Inputs) -> Inputs | None:
    """A candidate with its plane and origin; None where it is no finger or misses the offsets."""
    data = base.model_dump(mode="json")
    for key, value in inputs.items():
        section, _, name = key.partition(".")
        data[section][name] = value
    try:
        finger = configuration.from_dict(data).finger
    except ConfigError:
        return None
    found = plane(finger)
    if found is None:
        return None
    return {**inputs, "morph.d_mm": found.d_mm, "cog.x_ref_mm": round(found.x_ref_mm, 4)}


def fingers(candidate: Inputs) -> list[Inputs]:
    """Original and optima of a candidate."""
    return [candidate | dict(zip(XI, xi, strict=True)) for xi in ((0.0, 0.0), *OPTIMA.values())]


# -- results -------------------------------------------------------------------------------------


def judged(base: Config, folder: Path) -> list[dict[str, Any]]:
    """All candidates of a campaign whose four fingers are done, the best first."""
    groups: dict[tuple[tuple[str, float], ...], dict[tuple[float, float], dict[str, Any]]] = {}
    with Store(folder) as store:
        for row in store.rows():
            inputs = dict(row["inputs"])
            xi = (inputs.pop(XI[0]), inputs.pop(XI[1]))
            if row["status"] == "done":
                groups.setdefault(tuple(sorted(inputs.items())), {})[xi] = row
    whole = [(dict(key), found) for key, found in groups.items() if len(found) == 1 + len(OPTIMA)]
    table = [_verdict(base, inputs, found) for inputs, found in whole]
    return sorted(table, key=lambda row: row["worst_miss_percent"])


def _verdict(
    base: Config, inputs: Inputs, found: dict[tuple[float, float], dict[str, Any]]
) -> dict[str, Any]:
    original = found[0.0, 0.0]
    force = original["outputs"]["force_N"]
    gain = {
        limit: 100 * (found[xi]["outputs"]["force_N"] / force - 1) for limit, xi in OPTIMA.items()
    }
    turning = _turning(base, original)
    finger = configuration.from_dict(original["config"]).finger
    cog = offsets(finger, float(inputs["morph.d_mm"]))
    return {
        **inputs,
        "cog_residual_mm": round(cog.residual_mm, 4),
        "cog_original_mm": round(cog.original_mm, 3),
        **{f"gain_OD{limit:g}_percent": round(value, 2) for limit, value in gain.items()},
        "worst_miss_percent": round(max(abs(gain[each] - GAINS[each]) for each in gain), 2),
        "turning_kPa": None if turning is None else round(turning.pressure_kPa, 1),
        "touch_kPa": None
        if turning is None or turning.touch_kPa is None
        else round(turning.touch_kPa, 1),
        "force_N": round(force, 4),
        "slope_at_OD3_percent": round(_slope(found[OPTIMA[3.0]]), 2),
    }


def _turning(base: Config, row: dict[str, Any]) -> turning_point.TurningPoint | None:
    curve = row["curve"]
    gaps = [math.inf if gap is None else gap for gap in curve["blocked_contact_gap_mm"]]
    return turning_point.find(
        curve["blocked_pressure_kPa"],
        curve["force_N"],
        [{"bellows": gap} for gap in gaps],
        base.contact.barrier_mm,
    )


def _slope(row: dict[str, Any]) -> float:
    """Change of the force (%) with 0.1 more of ξ1 at the same COG offset; 0 at an optimum."""
    force, cog = (row["gradients"][name] for name in ("force_N", "cog_offset_mm"))
    along = force[XI[0]] - force[XI[1]] * cog[XI[0]] / cog[XI[1]]
    return float(10 * along / row["outputs"]["force_N"])


def show(table: list[dict[str, Any]], console: Console) -> None:
    """The six best, a column each."""
    shown = Table(title="Candidates, best first")
    shown.add_column("", no_wrap=True)
    best = table[:6]
    for number in range(len(best)):
        shown.add_column(str(number + 1), justify="right")
    names = dict.fromkeys(name for row in best for name in row)
    for name in names:
        cells = [row.get(name) for row in best]
        shown.add_row(name, *("" if cell is None else f"{cell:g}" for cell in cells))
    console.print(shown)


def sampled(base: Config, parameters: Iterable[str], number: int, seed: int) -> list[Inputs]:
    """``number`` candidates that meet the offsets, from a Sobol sequence."""
    varied = [space.parse(text) for text in parameters]
    for longer in (4, 16, 64):
        points = space.points(varied, "sobol", longer * number, seed)
        good = [one for one in (complete(base, point) for point in points) if one is not None]
        if len(good) >= number:
            return good[:number]
    raise SystemExit(f"only {len(good)} of {len(points)} candidates meet the paper's COG offsets")


def main() -> None:
    """Compute what is missing, rank, print and write ``candidates.csv``."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder of the campaign")
    parser.add_argument("--parameter", action="append", default=[], metavar="KEY=LOW:HIGH")
    parser.add_argument("--number", type=int, default=0, help="of sampled candidates")
    parser.add_argument("--seed", type=int, default=0, help="of the samples")
    parser.add_argument("--one", action="append", default=[], metavar="KEY=VALUE,…")
    parser.add_argument("--size-mm", type=float, default=7.0, help="of the elements")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument("--workers", type=int, default=1)
    asked = parser.parse_args()
    console = Console()
    base = configuration.load(None, [f"mesh.size_mm={asked.size_mm}", *asked.overrides])
    wanted = sampled(base, asked.parameter, asked.number, asked.seed) if asked.number else []
    for text in asked.one:
        inputs = {key: float(value) for key, value in (p.split("=") for p in text.split(","))}
        if "finger.bellows" in inputs:
            inputs["finger.bellows"] = int(inputs["finger.bellows"])
        one = complete(base, inputs)
        if one is None:
            console.print(f"{text}: no finger with the paper's COG offsets")
        else:
            wanted.append(one)
    for one in wanted:  # a plan each: they need not vary the same
        plan = Plan(base, (*one, *XI), tuple(fingers(one)))
        with progress.designs(console) as advance:
            campaign.run(plan, asked.out, Where(workers=asked.workers), progress=advance)
    table = judged(base, asked.out)
    show(table, console)
    names = dict.fromkeys(name for row in table for name in row)
    rows.write(
        asked.out / "candidates.csv", [{name: row.get(name) for name in names} for row in table]
    )


if __name__ == "__main__":
    main()
