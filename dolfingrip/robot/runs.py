"""Runs of finite elements that a chain is fitted to, and tested by."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyvista as pv

from dolfingrip.channels import ANGLE, FORCE, PRESSURE
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.rigs.tip_load import STIFFNESSES
from dolfingrip.experiments.simulate import compute
from dolfingrip.jobs.job import Data, Job, JobFailure, content_key
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, run, silent
from dolfingrip.jobs.store import Store, same

FUNCTION: Final = f"{__name__}:perform"
"""Import path of :func:`perform`."""

FORMAT: Final = 1
"""Version of what a stored run holds."""

SLICES: Final = 90
"""Slices along the finger whose backs are followed."""

READINGS: Final = 10
"""Pressures of a run after rest, of which every second one is fitted to."""

FITTED_GAPS: Final = (0.03, 0.22)
"""Gaps of the plate to which a chain is fitted, by the free tip's largest way along x."""

TESTED_GAPS: Final = (0.12,)
"""Gaps of the plate by which a chain is tested."""

LEAST_STOPS: Final = 5
"""Readings without which there is nothing to fit."""


@dataclass(frozen=True)
class FingerRun:
    """Readings of a run of finite elements, as far as a chain has them, too.

    Attributes:
        gap_mm: of the plate; None: the finger is free.
        pressure_kPa: (stops,).
        angle_rad: (stops,) of the tip.
        force_N: (stops,) on the plate; 0 where there is none.
        stiffness_x, stiffness_y: (stops,) of the free tip (N/mm); NaN where they were not read.
        back_rest_mm: (slices, 2) places x, z of the back at rest, by z.
        back_mm: (stops, slices, 2) present places.
        tip_mm: (1, 2) centre of the tip's face at rest.
        pressing_mm: (2, 2) ends of the back that faces a plate, at rest.
        depth_mm: of the finger, along x.
        wall_s: time that it took.
        failure: why it ended early, in words; "" where it did not.
    """

    gap_mm: float | None
    pressure_kPa: np.ndarray
    angle_rad: np.ndarray
    force_N: np.ndarray
    stiffness_x: np.ndarray
    stiffness_y: np.ndarray
    back_rest_mm: np.ndarray
    back_mm: np.ndarray
    tip_mm: np.ndarray
    pressing_mm: np.ndarray
    depth_mm: float
    wall_s: float
    failure: str

    @property
    def plate_mm(self) -> float:
        """Place of the plate along x; −∞ where there is none."""
        return -math.inf if self.gap_mm is None else float(self.pressing_mm[0, 0]) - self.gap_mm

    def at(self, stops: np.ndarray) -> FingerRun:
        """Return the run at some of its stops."""
        rows = ("pressure_kPa", "angle_rad", "force_N", "stiffness_x", "stiffness_y", "back_mm")
        return replace(self, **{name: getattr(self, name)[stops] for name in rows})

    @property
    def fitted(self) -> FingerRun:
        """The run at every second pressure, from rest on."""
        return self.at(np.arange(0, len(self.back_mm), 2))

    @property
    def kept_back(self) -> FingerRun:
        """The run at the other pressures."""
        return self.at(np.arange(1, len(self.back_mm), 2))


def prepared(config: Config) -> Config:
    """Return a configuration with the settings that all runs have.

    Args:
        config: of the user.

    Raises:
        ConfigError: one line, where no pressure bends the finger.
    """
    largest = config.experiment.max_pressure_kPa
    if largest <= 0:
        raise ConfigError(
            f"experiment.max_pressure_kPa = {largest:g}: allowed: above 0, as the chain is fitted "
            "to pressures from rest to there"
        )
    return config.changed(
        experiment={
            "control": "pressure", "step_kPa": largest / READINGS, "min_pressure_kPa": 0.0,
            "unload": False, "cycles": 1,
        },
        gravity={"acceleration_m_s2": 0.0},  # the simulator's own acts on the links
        plate={"tilt_deg": 0.0, "normal": (1.0, 0.0, 0.0)},
    )  # fmt: skip


def free_request(config: Config) -> Request:
    """Ask for the free finger, with the stiffness of its tip.

    Args:
        config: what :func:`prepared` gave.
    """
    return Request.of("push", config)


def blocked_request(config: Config, gap_mm: float) -> Request:
    """Ask for the finger that presses on a plate.

    Args:
        config: what :func:`prepared` gave.
        gap_mm: from the straight finger.
    """
    return Request.of("blocked_force", config.changed(plate={"gap_mm": gap_mm}))


def gaps_mm(free: FingerRun, shares: Sequence[float]) -> list[float]:
    """Return gaps that the tip crosses.

    Args:
        free: run of the free finger.
        shares: of the tip's largest way along x.

    Raises:
        ConfigError: one line, where the finger bends the other way or hardly at all.
    """
    way = float(-(free.back_mm[:, -1, 0] - free.back_mm[0, -1, 0]).min())
    if way < 0.01 * float(np.ptp(free.back_rest_mm[:, 1])):
        raise ConfigError(
            f"the free finger's tip moves {way:.3g} mm towards its back up to "
            f"{free.pressure_kPa[-1]:g} kPa; allowed: a finger that bends to its back (−x)"
        )
    return [round(share * way, 3) for share in shares]


def simulated(
    requests: Sequence[Request], folder: Path, pool: Pool, progress: Progress = silent
) -> list[FingerRun]:
    """Compute runs, unless they are in the folder's store.

    Args:
        requests: experiments on the finger.
        folder: of the store.
        pool: workers.
        progress: called with each run stored.

    Returns:
        The runs, in order, as far as each of them came.

    Raises:
        ConfigError: one line, where a run has no readings.
        Unfinished: the machine did not let some runs come to an end.
    """
    jobs = [
        Job(
            content_key({"format": FORMAT, "request": each.content()}),
            FUNCTION,
            {"request": each.plain()},
            {"experiment": each.experiment.name, "gap_mm": each.config.plate.gap_mm},
        )
        for each in requests
    ]
    run(jobs, folder, pool, same(function=FUNCTION), progress=progress)
    with Store(folder) as store:
        rows = {row["key"]: row for row in store.rows()}
    return [_run(rows[job.key], request) for job, request in zip(jobs, requests, strict=True)]


def _run(row: Mapping[str, Any], request: Request) -> FingerRun:
    """Read what :func:`perform` returned."""
    data, failure = row["result"] or row["partial"] or {}, row["failure"] or ""
    if len(data.get("back_mm", ())) < LEAST_STOPS:
        raise ConfigError(
            f"{request.experiment.command}: {len(data.get('back_mm', ()))} readings"
            f"{': ' if failure else ''}{failure}; a chain needs {LEAST_STOPS}"
        )
    columns = {name: np.array(each, float) for name, each in data["columns"].items()}
    pressure = columns[PRESSURE.name]
    blocked = request.experiment.name == "blocked_force"
    rest = np.array(data["back_rest_mm"])
    even = np.linspace(rest[0, 1], rest[-1, 1], SLICES + 1)

    def resampled(back: np.ndarray) -> np.ndarray:
        """The back at even heights, which are the same in runs of half a finger and of a whole."""
        return np.stack([np.interp(even, rest[:, 1], each) for each in back.T], axis=1)

    back_rest = resampled(rest)
    back = np.array([resampled(np.array(each)) for each in data["back_mm"]])
    length = back_rest[-1, 1] - min(request.config.plate.contact_length_mm, back_rest[-1, 1])
    ends = np.array([back_rest[-1, 1], length])
    nothing = np.full(len(pressure), np.nan)
    return FingerRun(
        gap_mm=request.config.plate.gap_mm if blocked else None,
        pressure_kPa=pressure,
        angle_rad=np.radians(columns[ANGLE.name]),
        force_N=columns[FORCE.name] if blocked else np.zeros(len(pressure)),
        stiffness_x=columns.get(STIFFNESSES[0].name, nothing),
        stiffness_y=columns.get(STIFFNESSES[1].name, nothing),
        back_rest_mm=back_rest,
        back_mm=back,
        tip_mm=np.array(data["tip_mm"]),
        pressing_mm=np.stack([np.interp(ends, back_rest[:, 1], back_rest[:, 0]), ends], axis=1),
        depth_mm=data["depth_mm"],
        wall_s=row["wall_s"] or 0.0,
        failure=failure,
    )


def perform(request: Data) -> Data:
    """Compute a run on a worker.

    Args:
        request: plain data of a :class:`~dolfingrip.experiments.request.Request`.

    Returns:
        Its readings, and the back's places at each of them.

    Raises:
        JobFailure: where the model did not come to the end; with what was read before.
    """
    with tempfile.TemporaryDirectory() as folder:
        asked = replace(Request.from_plain(request), fields=Path(folder))
        answer = compute(asked)
        found = {"columns": answer.plain()["columns"], **_backs(Path(folder), answer)}
    if answer.failure_class is not None:
        raise JobFailure(answer.failure_class, answer.failure or "", found)
    return found


def _backs(folder: Path, answer: Answer) -> Data:
    """Follow the nodes at the back of each slice through the fields of a run."""
    stops = len(answer.columns[PRESSURE.name])
    if not stops:
        return {}
    reader = pv.get_reader(folder / "fields.pvd")
    steps = []
    for stop in range(stops):
        reader.set_active_time_point(stop)
        steps.append(reader.read()[0])
    rest = np.asarray(steps[0].points)
    (x0, _, z0), (x1, _, z1) = rest.min(axis=0), rest.max(axis=0)
    height = z1 - z0
    slices = np.minimum(((rest[:, 2] - z0) / height * SLICES).astype(int), SLICES - 1)
    slices[rest[:, 2] > z1 - 1e-6 * height] = SLICES  # the tip's face and the clamp
    slices[rest[:, 2] < z0 + 1e-6 * height] = -1
    nodes = []
    for number in np.unique(slices):
        own = np.flatnonzero(slices == number)
        nodes.append(own[rest[own, 0] <= rest[own, 0].min() + 0.01 * (x1 - x0)])
    tip = rest[slices == SLICES]

    def means(points: np.ndarray) -> list[list[float]]:
        return [points[each][:, [0, 2]].mean(axis=0).tolist() for each in nodes]

    return {
        "back_rest_mm": means(rest),
        "back_mm": [means(rest + np.asarray(each["displacement_mm"])) for each in steps],
        "tip_mm": [[float(tip[:, 0].min() + tip[:, 0].max()) / 2, float(z1)]],
        "depth_mm": float(x1 - x0),
    }
