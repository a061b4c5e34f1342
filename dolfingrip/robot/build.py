"""From a configuration to a finger's reduced model: runs, fit, and what was not fitted."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.experiments.results.record import versions
from dolfingrip.extensions.effect import Relaxing
from dolfingrip.files.robot import (
    Accuracy,
    FreeShape,
    Joint,
    JointCoordinate,
    QuantityError,
    RobotFile,
    Validity,
)
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, silent
from dolfingrip.meshes.solid import SolidMesh
from dolfingrip.robot import runs
from dolfingrip.robot.chain import COORDINATES, TERMS, Points
from dolfingrip.robot.fit import MOST_JOINTS, POLICY, Fitted, chains, fit
from dolfingrip.robot.links import BoundSkin, links, skin, whole_solid
from dolfingrip.robot.robot import Robot
from dolfingrip.robot.runs import FingerRun
from dolfingrip.sections.supply import AirLine, with_valve

SHOWN: Final = 5
"""Each of so many sections is drawn; both ends are."""

FOLDER: Final = "simulations"
"""Folder in ``--out`` that keeps the runs of finite elements."""

DAMPING_S: Final = dict.fromkeys((name for name, _, _ in COORDINATES), 0.005) | {"bend": 0.002}
"""Damping by stiffness of each kind of coordinate where the material does not relax. No measurement
gives it. Bending at 10 Hz has a sixteenth of the critical damping; with as little of it in the
stiffer coordinates, contacts of light links tremble, and a long sausage slips out."""

LINE_S: Final = 0.02
"""Time constant of the pressure's supply where none is configured."""


CONSTANTS: Final = 3
"""Time constants after which a first-order lag has 95 %."""


@dataclass(frozen=True)
class Built:
    """A finger's reduced model and its skin.

    Attributes:
        robot: the reduced model.
        skin: of the mesh, bound to its links.
        tried: number of joints of the longest chain that was compared.
    """

    robot: Robot
    skin: BoundSkin
    tried: int


@dataclass(frozen=True)
class Simulated:
    """Runs of finite elements of a finger.

    Attributes:
        config: of the runs.
        free: the free finger, from the highest suction on.
        loaded: the finger against plates, and with its weight; the last ones test a chain.
        supply: of air, where one is configured.
    """

    config: Config
    free: FingerRun
    loaded: Sequence[FingerRun]
    supply: AirLine | None = None

    @property
    def fitted(self) -> list[FingerRun]:
        """Runs that a chain is fitted to, first the free finger."""
        return [self.free.fitted, *self.loaded[: len(runs.FITTED_GAPS)]]

    @property
    def tested(self) -> list[FingerRun]:
        """Runs that a chain is compared with."""
        return [self.free.kept_back, *self.loaded[len(runs.FITTED_GAPS) :]]


def simulate(config: Config, folder: Path, pool: Pool, progress: Progress = silent) -> Simulated:
    """Run the finite elements that a chain is fitted to, and compared with.

    Args:
        config: of the finger.
        folder: for the store of the runs.
        pool: workers.
        progress: called with each run stored.

    Returns:
        The runs.

    Raises:
        ConfigError: one line, where the finger does not bend to its back, or has too few readings,
            or its supply is a syringe.
        Unfinished: the machine did not let some runs come to an end; the others are kept.
    """
    supply = config.supply and with_valve(config.supply)
    setup, store = runs.prepared(config), folder / FOLDER
    suction = config.experiment.min_pressure_kPa
    alone = [runs.free_request(setup)]
    if suction < 0:
        alone.append(runs.suction_request(setup, suction))
    free, *drawn = runs.simulated(alone, store, pool, progress)
    gaps = runs.gaps_mm(free, (*runs.FITTED_GAPS, *runs.TESTED_GAPS))
    requests = [*(runs.blocked_request(setup, gap) for gap in gaps), runs.hanging_request(setup)]
    loaded = runs.simulated(requests, store, pool, progress)
    for run in drawn:
        free = free.beside(run)
    return Simulated(setup, free, loaded, supply)


def build(
    simulated: Simulated,
    accuracy: Accuracy | None = None,
    tried: Callable[[int, int, str], None] = lambda number, most, note: None,
) -> Built:
    """Fit a chain to finite elements, and compare it with what was not fitted.

    Args:
        simulated: runs of finite elements.
        accuracy: errors within which the chain of the fewest joints is taken, or the nearest one;
            None: it has as few joints as follow the free finger's shape.
        tried: called with the number of joints of each chain that is compared with ``accuracy``,
            the most that are tried, and how near it comes.

    Returns:
        The reduced model, with the skin bound to its links.
    """
    mesh, fitted = whole_solid(simulated.config), simulated.fitted
    chosen = [None] if accuracy is None else chains(fitted[0])
    nearest, least = None, np.inf
    for number, candidate in enumerate(chosen, 1):
        robot = _robot(fit(fitted, chosen=candidate), simulated, mesh, accuracy)
        excess = robot.file.excess
        if excess < least:
            nearest, least = robot, excess
        tried(number, MOST_JOINTS, f"{excess:.2g} of the error asked for")
        if excess <= 1:
            break
    assert nearest is not None
    first, *others = nearest.file.links
    ends = [first.from_mm, first.to_mm, *(link.to_mm for link in others)]
    return Built(nearest, skin(mesh, ends), number)


def _robot(
    fitted: Fitted, simulated: Simulated, mesh: SolidMesh, accuracy: Accuracy | None
) -> Robot:
    """The reduced model that a fitted chain makes, compared with what was not fitted."""
    config, free, loaded = simulated.config, simulated.free, simulated.loaded
    joints = fitted.chain.joints_mm[:, 2]
    ends = [float(mesh.points[:, 2].min()), *joints.tolist(), float(mesh.points[:, 2].max())]
    levels = np.unique([*ends[:-1], *free.pressing_mm[:, 2]])  # corners of links, and the plate's
    file = RobotFile(
        config=config.model_dump(mode="json"),
        links=links(mesh, config, ends),
        joints=tuple(_joints(fitted, DAMPING_S)),
        tip_mm=tuple(free.tip_mm[0]),
        pressing_mm=tuple(map(tuple, free.back_points_mm(levels))),
        facing_plate=int((levels >= free.pressing_mm[0, 2] - 1e-9).sum()),
        plate_N_per_mm=POLICY.plate_N_per_mm,
        line_s=LINE_S,
        supply=simulated.supply and simulated.supply.model_dump(mode="json"),
        shape_error_mm=fitted.shape_error_mm,
        valid=Validity(
            pressure_kPa=(float(free.pressure_kPa[0]), float(free.pressure_kPa[-1])),
            force_N=float(max(run.force_N.max() for run in loaded)),
            gaps_mm=tuple(run.gap_mm for run in loaded if run.gap_mm is not None),
            ended=tuple(run.failure for run in (free, *loaded) if run.failure),
        ),
        free_kPa=tuple(free.pressure_kPa),
        volume_mm3=tuple(free.volume_mm3[np.isfinite(free.volume_mm3)]),
        comparisons=(),
        accuracy=accuracy,
        simulated_s=sum(run.wall_s for run in (free, *loaded)),
        versions=versions(),
    )
    robot = Robot(file)
    found_out = {
        "line_s": LINE_S if simulated.supply is None else robot.fills_s() / CONSTANTS,
        "levels_mm": tuple(free.levels_mm[::SHOWN]),
        "shapes": tuple(_shapes(robot, free)),
        "comparisons": tuple(error for run in simulated.tested for error in compare(robot, run)),
        "joints": tuple(_joints(fitted, damping_s(config, robot))),
    }
    return Robot(file.model_copy(update=found_out))


def _shapes(robot: Robot, free: FingerRun) -> Iterator[FreeShape]:
    """The free finger at each pressure of a run."""
    w = robot.state(free.pressure_kPa).w
    starts = [(0.0, 0.0, link.from_mm) for link in robot.file.links]
    points = Points(np.array(starts), np.arange(len(starts)))
    places = robot.chain.places(w, points)[..., [0, 2]]
    bends = w[:, robot.chain.bends]
    turns = np.pad(np.cumsum(bends, axis=1), ((0, 0), (1, 0)))
    chains = np.dstack([places, turns]).tolist()
    sections = np.dstack([free.place_mm, free.turn_rad])[:, ::SHOWN].tolist()
    for pressure, section, chain in zip(free.pressure_kPa, sections, chains, strict=True):
        yield FreeShape(pressure_kPa=pressure, finite_elements=section, chain=chain)


def damping_s(config: Config, robot: Robot) -> dict[str, float]:
    """Return damping by stiffness: where the material relaxes, that of the first vibration.

    The complex modulus of branches g, τ of the instantaneous one is, by ω,
    1 − Σ g + Σ g iωτ/(1 + iωτ); damping is its imaginary part by ω and its real part.

    Args:
        config: of the finger.
        robot: its chain.

    Returns:
        Time by which the stiffness of each kind of coordinate is multiplied.
    """
    branches = [
        pair
        for effect in config.extensions.active()
        if isinstance(effect, Relaxing)
        for pair in zip(*effect.branches(), strict=True)
    ]
    if not branches:
        return DAMPING_S
    omega = 2 * np.pi * float(robot.frequencies_Hz(0.0)[0])
    modulus = 1 - sum(g / (1 + 1j * omega * tau) for g, tau in branches)
    return dict.fromkeys(DAMPING_S, float(modulus.imag / modulus.real / omega))


def _joints(fitted: Fitted, damping_s: Mapping[str, float]) -> Iterator[Joint]:
    """Joints with their coordinates, as the simulators have them."""
    laws = fitted.laws.reshape(-1, len(COORDINATES), TERMS)
    for number, (place, of_joint) in enumerate(zip(fitted.chain.joints_mm, laws, strict=True), 1):
        yield Joint(
            place_mm=tuple(place),
            coordinates=tuple(
                JointCoordinate(name=f"{name}_{number}", kind=kind, axis=axis, law=tuple(law),
                                damping_s=damping_s[name])
                for (name, kind, axis), law in zip(COORDINATES, of_joint, strict=True)
            ),
        )  # fmt: skip


def compare(robot: Robot, run: FingerRun) -> Iterator[QuantityError]:
    """Compare a chain with a run of finite elements.

    Args:
        robot: the chain.
        run: states that were not fitted.

    Yields:
        Each quantity.
    """
    p, gap, gravity = run.pressure_kPa, run.gap_mm, run.gravity_m_s2
    state = robot.state(p, gap, gravity_m_s2=gravity)
    tip = robot.tip.rest_mm
    turned = np.stack([np.cos(run.turn_rad[:, -1]), np.sin(run.turn_rad[:, -1])], axis=1)
    theirs = run.place_mm[:, -1] + tip[0, 0] * turned
    ours = robot.chain.places(state.w, robot.tip)[:, 0, [0, 2]]
    way, moved = (np.linalg.norm(place - tip[0, [0, 2]], axis=1) for place in (theirs, ours))

    def one(quantity: str, unit: str, fem: np.ndarray, chain: np.ndarray, error: np.ndarray,
            relative: float) -> QuantityError:  # fmt: skip
        return QuantityError(
            quantity=quantity, unit=unit, gap_mm=gap, gravity_m_s2=gravity, pressure_kPa=tuple(p),
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

    rest_deg = robot.angle_deg(0.0, gap, gravity)
    angle = np.degrees(state.w[:, robot.chain.bends].sum(axis=1)) - rest_deg
    yield by_largest("angle", "deg", np.degrees(run.angle_rad), angle)
    apart = np.linalg.norm(ours - theirs, axis=1)
    yield by_largest("tip path", "mm", way, moved, apart)
    if gap is not None:
        yield by_largest("force on the plate", "N", run.force_N, state.forces_N)
    if not np.isfinite(run.stiffness_x).all():
        return
    stiff = robot.stiffness_N_per_mm(p)
    for axis, fem in (("x", run.stiffness_x), ("y", run.stiffness_y)):
        chain = stiff[:, "xy".index(axis)]
        largest = float(np.abs(chain / fem - 1).max())
        yield one(f"stiffness of the tip, {axis}", "N/mm", fem, chain, chain - fem, largest)
