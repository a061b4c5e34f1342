"""From a configuration to a finger's reduced model: runs, fit, and what was not fitted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.experiments.results.record import versions
from dolfingrip.files.robot import Joint, JointCoordinate, QuantityError, RobotFile, Validity
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, silent
from dolfingrip.robot import runs
from dolfingrip.robot.fit import POLICY, Fitted, fit
from dolfingrip.robot.links import BoundSkin, links, skin, whole_solid
from dolfingrip.robot.robot import Robot
from dolfingrip.robot.runs import FingerRun

FOLDER: Final = "simulations"
"""Folder in ``--out`` that keeps the runs of finite elements."""

DAMPING_S: Final = 0.005
"""Damping by stiffness. No measurement of the material gives it; a finger that rings at 10 Hz has a
sixth of the critical damping with it."""

LINE_S: Final = 0.02
"""Time constant of the pressure's supply."""


@dataclass(frozen=True)
class Built:
    """A finger's reduced model and its skin."""

    robot: Robot
    skin: BoundSkin


def build(config: Config, folder: Path, pool: Pool, progress: Progress = silent) -> Built:
    """Run finite elements, fit a chain to them, and compare it with what was not fitted.

    Args:
        config: of the finger.
        folder: for the store of the runs.
        pool: workers.
        progress: called with each run stored.

    Returns:
        The reduced model, with the skin bound to its links.

    Raises:
        ConfigError: one line, where the finger does not bend to its back, or has too few readings.
        Unfinished: the machine did not let some runs come to an end; the others are kept.
    """
    asked, store = runs.prepared(config), folder / FOLDER
    (free,) = runs.simulated([runs.free_request(asked)], store, pool, progress)
    gaps = runs.gaps_mm(free, (*runs.FITTED_GAPS, *runs.TESTED_GAPS))
    requests = [runs.blocked_request(asked, gap) for gap in gaps]
    blocked = runs.simulated(requests, store, pool, progress)
    count = len(runs.FITTED_GAPS)
    fitted, tested = [free.fitted, *blocked[:count]], [free.kept_back, *blocked[count:]]
    found = fit(fitted)
    mesh = whole_solid(asked)
    joints = found.chain.joints_mm[:, 1]
    ends = [float(mesh.points[:, 2].min()), *joints.tolist(), float(mesh.points[:, 2].max())]
    levels = np.unique([*ends[:-1], *free.pressing_mm[:, 1]])  # corners of links, and the plate's
    back = np.interp(levels, free.back_rest_mm[:, 1], free.back_rest_mm[:, 0])
    file = RobotFile(
        config=asked.model_dump(mode="json"),
        links=links(mesh, asked, ends),
        joints=tuple(_joints(found)),
        tip_mm=(float(free.tip_mm[0, 0]), 0.0, float(free.tip_mm[0, 1])),
        pressing_mm=tuple((float(x), 0.0, float(z)) for x, z in zip(back, levels, strict=True)),
        facing_plate=int((levels >= free.pressing_mm[1, 1] - 1e-9).sum()),
        plate_N_per_mm=POLICY.plate_N_per_mm,
        damping_s=DAMPING_S,
        line_s=LINE_S,
        shape_error_mm=found.shape_error_mm,
        valid=Validity(
            pressure_kPa=(0.0, float(free.pressure_kPa[-1])),
            force_N=float(max(run.force_N.max() for run in blocked)),
            gaps_mm=tuple(gaps),
            ended=tuple(run.failure for run in (free, *blocked) if run.failure),
        ),
        comparisons=(),
        simulated_s=sum(run.wall_s for run in (free, *blocked)),
        versions=versions(),
    )
    compared = tuple(each for run in tested for each in compare(Robot(file), run))
    robot = Robot(file.model_copy(update={"comparisons": compared}))
    return Built(robot, skin(mesh, ends))


def _joints(found: Fitted) -> Iterator[Joint]:
    """Joints with their coordinates, as the simulators have them."""
    sideways = found.sideways
    for number, (x, z) in enumerate(found.chain.joints_mm):
        slide, bend = found.laws[2 * number : 2 * number + 2]
        side, twist = (
            (0.0, -rising, -rest, 0.0) for rising, rest in (sideways.side, sideways.twist)
        )
        given = (
            ("slide", "slide", (0.0, 0.0, 1.0), slide),
            ("bend", "hinge", (0.0, -1.0, 0.0), bend),
            ("side", "hinge", (1.0, 0.0, 0.0), side),
            ("twist", "hinge", (0.0, 0.0, 1.0), twist),
        )
        yield Joint(
            place_mm=(float(x), 0.0, float(z)),
            coordinates=tuple(
                JointCoordinate(name=f"{name}_{number + 1}", kind=kind, axis=axis, law=tuple(law))
                for name, kind, axis, law in given
            ),
        )


def compare(robot: Robot, run: FingerRun) -> Iterator[QuantityError]:
    """Compare a chain with a run of finite elements.

    Args:
        robot: the chain.
        run: states that were not fitted.

    Yields:
        Each quantity.
    """
    p, gap = run.pressure_kPa, run.gap_mm
    found = robot.state(p, gap)
    places = robot.chain.places(found.w, robot.chain.fixed(run.back_rest_mm[-1:]))[:, 0]
    apart = np.linalg.norm(places - run.back_mm[:, -1], axis=1)
    way = np.linalg.norm(run.back_mm[:, -1] - run.back_rest_mm[-1], axis=1)

    def one(quantity: str, unit: str, fem: np.ndarray, chain: np.ndarray, error: np.ndarray,
            relative: float) -> QuantityError:  # fmt: skip
        return QuantityError(
            quantity=quantity, unit=unit, gap_mm=gap, pressure_kPa=tuple(p),
            finite_elements=tuple(fem), chain=tuple(chain),
            rms=float(np.sqrt(np.square(error).mean())), largest=float(np.abs(error).max()),
            relative=relative,
        )  # fmt: skip

    def by_largest(
        quantity: str,
        unit: str,
        fem: np.ndarray,
        chain: np.ndarray,
        error: np.ndarray | None = None,
    ) -> QuantityError:
        differing = chain - fem if error is None else error
        most = max(float(np.abs(fem).max()), np.finfo(float).tiny)
        return one(quantity, unit, fem, chain, differing, float(np.abs(differing).max()) / most)

    angle = np.degrees(found.w[:, robot.chain.hinges].sum(axis=1))
    yield by_largest("angle", "deg", np.degrees(run.angle_rad), angle)
    moved = np.linalg.norm(places - run.back_rest_mm[-1], axis=1)
    yield by_largest("tip path", "mm", way, moved, apart)
    if gap is not None:
        yield by_largest("force on the plate", "N", run.force_N, found.forces_N)
        return
    stiff = robot.stiffness_N_per_mm(p)
    for axis, fem in (("x", run.stiffness_x), ("y", run.stiffness_y)):
        chain = stiff[:, "xy".index(axis)]
        largest = float(np.abs(chain / fem - 1).max())
        yield one(f"stiffness of the tip, {axis}", "N/mm", fem, chain, chain - fem, largest)
