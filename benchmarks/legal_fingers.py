"""Random legal fingers of every kind: how they end, and whether ranks and threads agree.

    scripts/run python -m benchmarks.legal_fingers [--number 40] [--seed 0] [--only NUMBER…]
                                                   [--folder out/legal_fingers] [--out FILE.csv]

Each finger is drawn until the configuration allows it: kind of geometry with its dimensions, cells
and element, law of the material and of its regions, films, pressures, weight, experiment. The
meshes are coarse, and forms are compiled as for tests. Each finger is simulated in four ways: on
one rank with one thread and with four, and on two and three ranks. Answers are kept in the folder,
so a call resumes one that was killed.

The table has a row for each finger: how it ended in each way, the smallest det F at the integration
points over all steps, and the largest difference of a reading between the ways, as a part of the
largest value of its column. A finger is well if it came to its end or its failure has a class, if
det F is above 0, and if the difference is at most 1e-8 where no way met a limit point: neither a
failure, nor a damped step, by which a load path jumps to another equilibrium.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any, Final

import numpy as np
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import MORE_RANKS_THAN_CORES, compute
from dolfingrip.files import table, whole
from dolfingrip.jobs.job import REFUSED
from dolfingrip.report import printable
from dolfingrip.report.page import finger, trust
from dolfingrip.sections.geometry.index import NAMES

WAYS: Final = ((1, 1), (1, 4), (2, 1), (3, 1))
"""Ranks and threads; the first is the reference."""

ALLOWED: Final = 1e-8
ENTRIES: Final = ("angle_deg", "chord_angle_deg", "tip_x_mm", "tip_z_mm", "force_N",
                  "cavity_volume_mm3", "stiffness_x_N_per_mm")  # fmt: skip
"""Readings that are compared, where the experiment has them."""

SEEN: Final = 1e-3
"""Least size of a reading that counts (N, mm or degrees)."""

Changes = dict[str, Any]


def _range(rng: random.Random, low: float, high: float) -> float:
    return round(rng.uniform(low, high), 3)


def _bellows(rng: random.Random) -> Changes:
    bellows, gap = rng.randint(1, 3), _range(rng, 1.5, 3.0)
    block, tip = _range(rng, 4.0, 10.0), _range(rng, 3.0, 6.0)
    return {
        "finger.bellows": bellows, "finger.gap_mm": gap, "finger.base_block_mm": block,
        "finger.tip_mm": tip, "finger.width_mm": _range(rng, 12.0, 24.0),
        "finger.length_mm": round(block + tip + bellows * (gap + _range(rng, 6.0, 10.0)), 3),
        "finger.depth_mm": _range(rng, 12.0, 20.0), "finger.wall_mm": _range(rng, 1.0, 2.4),
        "finger.base_layer_mm": _range(rng, 2.0, 4.5), "finger.channel_mm": _range(rng, 2.0, 4.0),
    }  # fmt: skip


def _cast(rng: random.Random) -> Changes:
    height, width = _range(rng, 5.0, 12.0), _range(rng, 5.0, 12.0)
    return {
        "cast.chambers": rng.randint(1, 3), "cast.chamber_height_mm": height,
        "cast.chamber_width_mm": width, "cast.chamber_length_mm": _range(rng, 2.0, 6.0),
        "cast.wall_mm": _range(rng, 2.0, 6.0), "cast.tunnel_height_mm": _range(rng, 1.5, height),
        "cast.tunnel_width_mm": _range(rng, 1.5, width), "cast.film_mm": _range(rng, 0.3, 2.0),
        "cast.tube": rng.random() < 0.5, "cast.cup_mm": rng.choice((0.0, 5.0)),
    }  # fmt: skip


def _pneunet(rng: random.Random) -> Changes:
    width, height = _range(rng, 12.0, 22.0), _range(rng, 6.0, 12.0)
    return {
        "pneunet.chambers": rng.randint(1, 3), "pneunet.chamber_length_mm": _range(rng, 3.0, 7.0),
        "pneunet.width_mm": width, "pneunet.chamber_width_mm": _range(rng, 0.6, 0.85) * width,
        "pneunet.chamber_height_mm": height, "pneunet.wall_mm": _range(rng, 1.0, 2.5),
        "pneunet.roof_mm": _range(rng, 1.0, 3.0), "pneunet.gap_mm": _range(rng, 0.8, 2.0),
        "pneunet.tunnel_height_mm": _range(rng, 1.0, 3.0), "pneunet.base_mm": _range(rng, 1.0, 3.0),
        "pneunet.paper_mm": _range(rng, 0.1, 0.5), "pneunet.cover_mm": rng.choice((0.0, 1.0)),
        "pneunet.tip_mm": rng.choice((0.0, 2.0)), "pneunet.tube": rng.random() < 0.5,
    }  # fmt: skip


def _round_bellows(rng: random.Random) -> Changes:
    gap, wall = _range(rng, 1.5, 3.0), _range(rng, 0.8, 1.5)
    return {
        "round_bellows.convolutions": rng.randint(1, 2), "round_bellows.gap_mm": gap,
        "round_bellows.crown_radius_mm": _range(rng, 7.0, 12.0), "round_bellows.wall_mm": wall,
        "round_bellows.neck_radius_mm": _range(rng, 2.5, 5.0),
        "round_bellows.pitch_mm": round(gap + 2 * wall + _range(rng, 1.5, 4.0), 3),
        "round_bellows.block_mm": _range(rng, 2.0, 5.0),
        "cavity.cavity_2.pressure_ratio": rng.choice((0.0, 0.5, 1.0, -0.2)),
    }  # fmt: skip


DIMENSIONS: Final[Mapping[str, Callable[[random.Random], Changes]]] = {
    "bellows": _bellows, "cast": _cast, "pneunet": _pneunet, "round_bellows": _round_bellows,
    "adopted": lambda rng: {**_bellows(rng), "finger.wall_mm": _range(rng, 1.8, 2.6)},
}  # fmt: skip
"""What draws the dimensions of each kind; an adopted part is the STEP file of a bellows finger."""


def _law(rng: random.Random, mu_MPa: float) -> Changes:
    """A law of this initial shear modulus, whose energy grows with each invariant."""
    law = rng.choice(("neo-hooke", "ogden", "polynomial"))
    found: Changes = {"law": law, "nu": _range(rng, 0.4, 0.495)}
    if law == "neo-hooke":
        return {**found, "mu_MPa": mu_MPa}
    if law == "ogden":
        shares = [1.0, rng.choice((0.02, 0.1))]
        return {**found, "ogden_mu_MPa": [round(mu_MPa * each, 6) for each in shares],
                "ogden_alpha": rng.choice(([1.6, 4.2], [3.0, -2.0], [1.2, 5.0]))}  # fmt: skip
    second = rng.choice((0.0, 0.2))
    return {**found, "C10_MPa": mu_MPa / 2 * (1 - second), "C01_MPa": mu_MPa / 2 * second,
            "C20_MPa": mu_MPa * rng.choice((0.0, 0.02))}  # fmt: skip


def _film(rng: random.Random, kind: str) -> Changes:
    """A film, or another material of a region, or neither."""
    stiffness = _range(rng, 0.5, 60.0)
    choices: list[Changes] = [{}, {"film.sheet.Et_N_per_mm": stiffness}]
    fibres = rng.choice(([0.0], [90.0], [30.0, -30.0]))
    choices.append({
        "film.cloth.Et_N_per_mm": _range(rng, 0.0, 2.0),
        "film.cloth.fibre_Et_N_per_mm": [stiffness] * len(fibres),
        "film.cloth.fibre_deg": fibres, "film.cloth.compression": rng.choice((0.0, 0.1, 1.0)),
    })  # fmt: skip
    region = {"cast": "film", "pneunet": "paper"}.get(kind)
    if region:
        other = "body" if kind == "cast" else "base"
        choices += [
            {"film.layer.model": "layer", "film.layer.region": region,
             "film.layer.Et_N_per_mm": stiffness},
            {"film.between.between": [region, other], "film.between.Et_N_per_mm": stiffness},
            {f"material.{region}": _law(rng, _range(rng, 1.0, 30.0))},
        ]  # fmt: skip
    return rng.choice(choices)


def _steps(highest_kPa: float) -> Changes:
    """Short steps under suction, where walls touch.

    Walls that touch have several equilibria. A long step ends in one of them by round-off.
    """
    if highest_kPa > 0:
        return {}
    longest = max(round(-highest_kPa / 16, 6), 1e-3)
    return {"solver.max_step_kPa": longest, "solver.min_step_kPa": longest / 250}


def drawn(number: int, seed: int, folder: Path) -> tuple[str, Config]:
    """Draw a legal finger.

    Args:
        number: of the finger, which sets its kind.
        seed: of all fingers.
        folder: for the files of adopted parts.

    Returns:
        Name of the experiment, and the configuration.
    """
    kind = NAMES[number % len(NAMES)]
    for attempt in count():
        rng = random.Random(f"{seed} {number} {attempt}")
        tetrahedra = kind == "round_bellows" or (kind == "bellows" and rng.random() < 0.5)
        elements = ("P2", "P1", "P1") if tetrahedra or kind == "adopted" else ("S2",)
        mu_MPa = round(10 ** rng.uniform(-1.5, 0.8), 4)
        size_kPa = round(1e3 * mu_MPa * 10 ** rng.uniform(-2.3, -0.9), 3)
        highest = rng.choice((size_kPa, size_kPa, -min(size_kPa, 101.0)))
        size = 5.0 if tetrahedra else 8.0
        experiment = rng.choice(("bending", "bending", "blocked_force", "push"))
        dimensions = DIMENSIONS[kind](rng)
        changes: Changes = {
            "solver.element": rng.choice(elements), "solver.rtol": 1e-12, "solver.atol_N": 1e-11,
            "solver.time_limit_s": 3600.0, **_steps(highest),
            "mesh.size_mm": size, "mesh.edge_size_mm": size, "plate.contact_length_mm": 5.0,
            "material": _law(rng, mu_MPa), **_film(rng, kind), "finger.kind": kind,
            "experiment.max_pressure_kPa": highest, "experiment.step_kPa": abs(highest) / 2,
            "experiment.unload": rng.random() < 0.3,
            "gravity.acceleration_m_s2": rng.choice((0.0, 9.81)),
            "gravity.direction": rng.choice(([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [-0.6, 0.0, 0.8])),
        }  # fmt: skip
        try:
            if kind == "adopted":
                part = configuration.load(None, {**dimensions, "mesh.half": False})
                # half a finger has no stiffness sideways
                whole_part = ("--whole",) if experiment == "push" else ()
                return experiment, _adopted(part, changes, folder / f"adopted{number}", *whole_part)
            return experiment, configuration.load(None, {**changes, **dimensions})
        except ConfigError:
            continue
    raise AssertionError


def _adopted(part: Config, changes: Changes, folder: Path, *options: str) -> Config:
    """The part of a STEP file as a finger, adopted with these options."""
    if not (folder / "adopted.toml").exists():
        printable.write(part, folder / "part.step")
        command = [sys.executable, "-m", "dolfingrip", "adopt", folder / "part.step", "--out",
                   folder, "--size-mm", "4", *options]  # fmt: skip
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    of_dimensions = ("finger.kind", "mesh.size_mm", "mesh.edge_size_mm")
    own = {key: value for key, value in changes.items() if key not in of_dimensions}
    return configuration.load(folder / "adopted.toml", own)


def requests(asked: argparse.Namespace) -> dict[int, Request]:
    """The request for each finger."""
    found = {}
    for number in asked.only or range(asked.number):
        experiment, config = drawn(number, asked.seed, asked.folder)
        found[number] = Request.of(experiment, config)
    return found


def _answer(asked: argparse.Namespace, ranks: int, threads: int, number: int) -> Path:
    return asked.folder / f"ranks{ranks}-threads{threads}" / f"{number}.json"


def answer_all(asked: argparse.Namespace, threads: int) -> None:
    """Answer all requests on all ranks of an mpirun, those apart that are answered already."""
    world = MPI.COMM_WORLD
    for number, request in requests(asked).items():
        file = _answer(asked, world.size, threads, number)
        if world.bcast(file.exists()):
            continue
        began_s = time.monotonic()
        if (world.size, threads) == WAYS[0]:
            request = replace(request, fields=asked.folder / "fields" / str(number))
        try:
            answer = compute(request, world)
        except ConfigError as error:
            answer = Answer(failure_class=REFUSED, failure=str(error))
        if world.rank == 0:
            whole.write(file, json.dumps(answer.plain()))
            took = f"{time.monotonic() - began_s:.0f} s"
            sys.stdout.write(f"{file.parent.name}, finger {number}: {took}, {answer.failure}\n")
            sys.stdout.flush()


def least_det_F(folder: Path) -> float:
    """The smallest det F of a run at the integration points, over all steps."""
    steps = finger.read(folder / "fields.pvd", sys.maxsize)
    return min(float(trust.volume_ratios(steps.mesh, u).min()) for u in steps.displacements)


def apart(found: Sequence[Answer]) -> float:
    """The largest difference of a reading from the first answer's, by its column's largest value.

    Readings that no instrument tells from 0 (1e-3 N, mm or degrees) are no scale. It is infinite
    where one has other readings.
    """
    worst = 0.0
    for name in ENTRIES:
        every = [each.columns.get(name) for each in found]
        first = every[0]
        if first is None or not np.isfinite(first).any():
            continue
        for other in every[1:]:
            if other is None or other.shape != first.shape:
                return float("inf")
            scale = max(float(np.nanmax(np.abs(first))), SEEN)
            worst = max(worst, float(np.nanmax(np.abs(other - first))) / scale)
    return worst


def row(
    asked: argparse.Namespace, number: int, request: Request, found: Sequence[Answer]
) -> dict[str, Any]:
    """A row of the table."""
    config = request.config
    ended = [each.failure_class or "completed" for each in found]
    failed = any(each != "completed" for each in ended)
    folder = asked.folder / "fields" / str(number)
    jumps = json.loads((folder / "run.json").read_text("utf-8"))["newton"]["damped_steps"]
    least = least_det_F(folder)
    difference = apart(found)
    return {
        "finger": number,
        "kind": config.finger.kind,
        "element": config.solver.element,
        "law": config.material.law,
        "films": " ".join([*config.film.all, *config.material.own]) or "none",
        "experiment": request.experiment.name,
        "max_pressure_kPa": config.experiment.max_pressure_kPa,
        **{f"ended_{r}_ranks_{t}_threads": e for (r, t), e in zip(WAYS, ended, strict=True)},
        "least_det_F": f"{least:.4g}",
        "damped_steps": jumps,
        "apart": "" if failed else f"{difference:.1e}",
        "well": least > 0
        and REFUSED not in ended
        and (failed or jumps > 0 or difference <= ALLOWED),
    }


def main() -> None:
    """Draw the fingers, simulate them in all ways, and write the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.legal_fingers")
    parser.add_argument("--number", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", type=int, default=[])
    parser.add_argument("--folder", type=Path, default=Path("out/legal_fingers"))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--threads", type=int, help="answer alone, on the ranks of an mpirun")
    asked = parser.parse_args()
    asked.folder = asked.folder.resolve()
    if asked.threads:
        answer_all(asked, asked.threads)
        return
    sys.stdout.write(f"seed {asked.seed}\n")
    sys.stdout.flush()
    every = requests(asked)  # adopts parts before many ranks ask for them
    for ranks, threads in WAYS:
        command = ["mpirun", "-n", str(ranks), sys.executable, "-m", "benchmarks.legal_fingers",
                   *sys.argv[1:], "--threads", str(threads)]  # fmt: skip
        environment = {"OMP_NUM_THREADS": str(threads), "DOLFINGRIP_OPTIMISATION": "1"}
        subprocess.run(
            command, check=True, env={**os.environ, **MORE_RANKS_THAN_CORES, **environment}
        )
    rows = []
    for number, request in every.items():
        files = [_answer(asked, *way, number) for way in WAYS]
        found = [Answer.from_plain(json.loads(file.read_text("utf-8"))) for file in files]
        rows.append(row(asked, number, request, found))
    for each in rows:
        sys.stdout.write(f"{each}\n")
    if asked.out is not None:
        table.write(asked.out, rows)
    raise SystemExit(0 if all(each["well"] for each in rows) else 1)


if __name__ == "__main__":
    main()
