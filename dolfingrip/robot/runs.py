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

from dolfingrip.channels import ANGLE, CAVITY_VOLUME, FORCE, PRESSURE
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

FORMAT: Final = 3
"""Version of what a stored run holds."""

SECTIONS: Final = 91
"""Sections along the finger whose rigid motions are followed."""

WINDOW: Final = 0.06
"""Half the length of finger, by the whole, whose nodes tell a section's motion: over bellows it is
smooth."""

_FEWEST: Final = 6
"""Nodes that a section has at least."""

READINGS: Final = 10
"""Pressures of a run after rest, of which every second one is fitted to."""

FITTED_GAPS: Final = (0.03, 0.22)
"""Gaps of the plate to which a chain is fitted, by the free tip's largest way along x."""

TESTED_GAPS: Final = (0.12,)
"""Gaps of the plate by which a chain is tested."""

HANGING: Final = {"acceleration_m_s2": 9.81, "direction": (0.0, 0.0, 1.0)}
"""Gravity by which a chain is tested: from clamp to tip."""

_ROWS: Final = ("pressure_kPa", "angle_rad", "force_N", "volume_mm3", "stiffness_x",
                "stiffness_y", "place_mm", "turn_rad")  # fmt: skip
"""Attributes of a run that have its stops as first axis."""

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
        volume_mm3: (stops,) of the cavity; NaN where there are several.
        stiffness_x, stiffness_y: (stops,) of the free tip (N/mm); NaN where they were not read.
        levels_mm: (sections,) places z of the sections at rest, from clamp to tip.
        back_mm: (sections,) least x of the finger at rest near each section.
        place_mm: (stops, sections, 2) present places x, z of the sections' points x = 0.
        turn_rad: (stops, sections) how far the sections have turned.
        tip_mm: (1, 3) centre of the tip's face at rest.
        contact_mm: length of the back that faces a plate, from the tip.
        depth_mm: of the finger, along x.
        wall_s: time that it took.
        failure: why it ended early, in words; "" where it did not.
        gravity_m_s2: acceleration along x, y, z; angles are since rest in it.
    """

    gap_mm: float | None
    pressure_kPa: np.ndarray
    angle_rad: np.ndarray
    force_N: np.ndarray
    volume_mm3: np.ndarray
    stiffness_x: np.ndarray
    stiffness_y: np.ndarray
    levels_mm: np.ndarray
    back_mm: np.ndarray
    place_mm: np.ndarray
    turn_rad: np.ndarray
    tip_mm: np.ndarray
    contact_mm: float
    depth_mm: float
    wall_s: float
    failure: str
    gravity_m_s2: tuple[float, ...] = (0.0, 0.0, 0.0)

    @property
    def length_mm(self) -> float:
        """From clamp to tip."""
        return float(np.ptp(self.levels_mm))

    @property
    def plate_mm(self) -> float:
        """Place of the plate along x; −∞ where there is none."""
        return -math.inf if self.gap_mm is None else float(self.back_mm[-1]) - self.gap_mm

    def rest_line_mm(self, height_mm: float) -> np.ndarray:
        """Return the line of the sections' points at a height x, at rest, (sections, 3)."""
        return np.stack([np.full_like(self.levels_mm, height_mm), 0 * self.levels_mm,
                         self.levels_mm], axis=1)  # fmt: skip

    def line_mm(self, height_mm: float) -> np.ndarray:
        """Return where these points are, (stops, sections, 3)."""
        x, z = np.moveaxis(self.place_mm, -1, 0)
        turned = height_mm * np.cos(self.turn_rad), height_mm * np.sin(self.turn_rad)
        return np.stack([x + turned[0], 0 * x, z + turned[1]], axis=-1)

    def back_points_mm(self, levels_mm: np.ndarray) -> np.ndarray:
        """Return points of the back at levels z, at rest, (levels, 3)."""
        back = np.interp(levels_mm, self.levels_mm, self.back_mm)
        return np.stack([back, 0 * back, levels_mm], axis=1)

    @property
    def pressing_mm(self) -> np.ndarray:
        """Ends (2, 3) of the back that faces a plate, at rest."""
        top = self.levels_mm[-1]
        return self.back_points_mm(np.array([top - min(self.contact_mm, self.length_mm), top]))

    def at(self, stops: np.ndarray) -> FingerRun:
        """Return the run at some of its stops."""
        return replace(self, **{name: getattr(self, name)[stops] for name in _ROWS})

    def beside(self, suction: FingerRun) -> FingerRun:
        """Return the run from the highest suction over rest to the highest pressure."""
        drawn = suction.at(np.arange(len(suction.pressure_kPa))[:0:-1])  # rest is in both
        rows = {name: np.concatenate([getattr(drawn, name), getattr(self, name)]) for name in _ROWS}
        failure, wall_s = suction.failure or self.failure, suction.wall_s + self.wall_s
        return replace(self, **rows, failure=failure, wall_s=wall_s)

    @property
    def fitted(self) -> FingerRun:
        """The run at every second pressure, from rest on."""
        return self.at(np.arange(0, len(self.pressure_kPa), 2))

    @property
    def kept_back(self) -> FingerRun:
        """The run at the other pressures."""
        return self.at(np.arange(1, len(self.pressure_kPa), 2))


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
    unmoved = config.changed(experiment={"dynamic": False})  # refuses what needs inertia
    return unmoved.at_rest().changed(
        experiment={"step_kPa": largest / READINGS, "min_pressure_kPa": 0.0},
        gravity={"acceleration_m_s2": 0.0},  # the simulator's own acts on the links
        plate={"tilt_deg": 0.0, "normal": (1.0, 0.0, 0.0)},
    )


def free_request(config: Config) -> Request:
    """Ask for the free finger, with the stiffness of its tip.

    Args:
        config: what :func:`prepared` gave.
    """
    return Request.of("push", config)


def suction_request(config: Config, suction_kPa: float) -> Request:
    """Ask for the free finger under suction.

    Args:
        config: what :func:`prepared` gave.
        suction_kPa: below 0.
    """
    steps = {"max_pressure_kPa": suction_kPa, "step_kPa": -suction_kPa / READINGS}
    return free_request(config.changed(experiment=steps))


def blocked_request(config: Config, gap_mm: float) -> Request:
    """Ask for the finger that presses on a plate.

    Args:
        config: what :func:`prepared` gave.
        gap_mm: from the straight finger.
    """
    return Request.of("blocked_force", config.changed(plate={"gap_mm": gap_mm}))


def hanging_request(config: Config) -> Request:
    """Ask for the free finger that hangs from its clamp.

    Args:
        config: what :func:`prepared` gave.
    """
    return Request.of("bending", config.changed(gravity=HANGING))


def gaps_mm(free: FingerRun, shares: Sequence[float]) -> list[float]:
    """Return gaps that the tip crosses.

    Args:
        free: run of the free finger.
        shares: of the tip's largest way along x.

    Raises:
        ConfigError: one line, where the finger bends the other way or hardly at all.
    """
    way = float((free.place_mm[0, -1, 0] - free.place_mm[:, -1, 0]).max())
    if way < 0.01 * free.length_mm:
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
            content_key({"format": FORMAT, "request": r.content()}),
            FUNCTION,
            {"request": r.plain()},
            {"experiment": r.experiment.name, "gap_mm": r.config.plate.gap_mm},
        )
        for r in requests
    ]
    run(jobs, folder, pool, same(function=FUNCTION), progress=progress)
    with Store(folder) as store:
        rows = {row["key"]: row for row in store.rows()}
    return [_run(rows[job.key], request) for job, request in zip(jobs, requests, strict=True)]


def _run(row: Mapping[str, Any], request: Request) -> FingerRun:
    """Read what :func:`perform` returned."""
    data, failure = row["result"] or row["partial"] or {}, row["failure"] or ""
    stops = len(data.get("turn_rad", ()))
    if stops < LEAST_STOPS:
        raise ConfigError(
            f"{request.experiment.command}: {stops} readings{': ' if failure else ''}{failure}; "
            f"a chain needs {LEAST_STOPS}"
        )
    columns = {name: np.array(values, float) for name, values in data["columns"].items()}
    blocked, gravity = request.experiment.name == "blocked_force", request.config.gravity
    nothing = np.full(stops, np.nan)
    return FingerRun(
        gap_mm=request.config.plate.gap_mm if blocked else None,
        pressure_kPa=columns[PRESSURE.name],
        angle_rad=np.radians(columns[ANGLE.name]),
        force_N=columns[FORCE.name] if blocked else np.zeros(stops),
        volume_mm3=columns.get(CAVITY_VOLUME.name, nothing),
        stiffness_x=columns.get(STIFFNESSES[0].name, nothing),
        stiffness_y=columns.get(STIFFNESSES[1].name, nothing),
        levels_mm=np.array(data["levels_mm"]),
        back_mm=np.array(data["back_mm"]),
        place_mm=np.array(data["place_mm"]),
        turn_rad=np.array(data["turn_rad"]),
        tip_mm=np.array(data["tip_mm"]),
        contact_mm=request.config.plate.contact_length_mm,
        depth_mm=data["depth_mm"],
        wall_s=row["wall_s"] or 0.0,
        failure=failure,
        gravity_m_s2=tuple(gravity.acceleration_m_s2 * part for part in gravity.direction),
    )


def perform(request: Data) -> Data:
    """Compute a run on a worker.

    Args:
        request: plain data of a :class:`~dolfingrip.experiments.request.Request`.

    Returns:
        Its readings, and the sections' motions at each of them.

    Raises:
        JobFailure: where the model did not come to the end; with what was read before.
    """
    with tempfile.TemporaryDirectory() as folder:
        with_fields = replace(Request.from_plain(request), fields=Path(folder))
        answer = compute(with_fields)
        readings = {"columns": answer.plain()["columns"], **_followed(Path(folder), answer)}
    if answer.failure_class is not None:
        raise JobFailure(answer.failure_class, answer.failure or "", readings)
    return readings


def _followed(folder: Path, answer: Answer) -> Data:
    """Sections in the fields of a run."""
    stops = len(answer.columns.get(PRESSURE.name, ()))
    if not stops:
        return {}
    reader = pv.get_reader(folder / "fields.pvd")
    steps = []
    for stop in range(stops):
        reader.set_active_time_point(stop)
        steps.append(reader.read()[0])
    rest_mm = np.asarray(steps[0].points)
    return sections(rest_mm, rest_mm + np.array([step["displacement_mm"] for step in steps]))


def sections(rest_mm: np.ndarray, moved: np.ndarray) -> Data:
    """Follow a finger's sections: the motions nearest to those of the nodes around them.

    A section moves as a rigid body and swells evenly along x. Its place is that of a rigid body at
    the finger's back, which plates and food touch.

    Args:
        rest_mm: (nodes, 3) places at rest (mm).
        moved: (stops, nodes, 3) present places (mm).

    Returns:
        Attributes of a :class:`FingerRun`, as lists.
    """
    (x0, _, z0), (x1, _, z1) = rest_mm.min(axis=0), rest_mm.max(axis=0)
    levels = np.linspace(z0, z1, SECTIONS)
    back, places, turns = [], [], []
    for level in levels:
        apart = np.abs(rest_mm[:, 2] - level)
        least = np.partition(apart, _FEWEST)[_FEWEST] + 1e-6 * (z1 - z0)
        window = max(WINDOW * (z1 - z0), least)
        near = np.flatnonzero(apart <= max(min(window, level - z0, z1 - level), least))
        back.append(float(rest_mm[apart <= window, 0].min()))
        # x + i z
        before, after = (xyz[..., near, 0] + 1j * xyz[..., near, 2] for xyz in (rest_mm, moved))
        middle, middles = before.mean(), after.mean(axis=-1)
        spin = ((after - middles[:, None]) * (before - middle).conj()).sum(axis=-1)
        spin /= np.abs(spin)
        across = (before - middle).real
        swollen = ((after - middles[:, None]) * spin.conj()[:, None]).real @ across
        swollen = swollen / max(across @ across, np.finfo(float).tiny) - 1
        outwards = swollen * (back[-1] - middle.real)
        place = middles + spin * (1j * level - middle + outwards)
        places.append(np.stack([place.real, place.imag], axis=-1))
        turns.append(np.unwrap(np.angle(spin)))
    tip = rest_mm[rest_mm[:, 2] > z1 - 1e-6 * (z1 - z0), 0]
    return {
        "levels_mm": levels.tolist(),
        "back_mm": back,
        "place_mm": np.stack(places, axis=1).tolist(),
        "turn_rad": np.stack(turns, axis=1).tolist(),
        "tip_mm": [[float(tip.min() + tip.max()) / 2, 0.0, float(z1)]],
        "depth_mm": float(x1 - x0),
    }
