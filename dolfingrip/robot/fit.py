"""Fit a chain to runs of finite elements: its joints, and the laws at them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.optimize import isotonic_regression, least_squares

from dolfingrip.robot.chain import (
    TERMS,
    Chain,
    Plates,
    Points,
    equilibrium,
    stiffnesses,
    terms,
)
from dolfingrip.robot.runs import FingerRun

MOST_JOINTS: Final = 16
"""Joints of the longest chain that is tried."""

LEAST_LINK: Final = 0.02
"""Length of the shortest link by the whole; a light one would need short steps of time."""


@dataclass(frozen=True)
class ChainPolicy:
    """Numbers that decide about a fit.

    Attributes:
        shape_error: root mean square distance of the free finger's line from that of a chain of as
            few joints as possible, relative to the length.
        near_best: factor on the least error of all chains that is as good, where none is so near.
        angle_deg, place, force, stiffness: errors that weigh equally: of the angle, of places by
            the length, of the force by the largest one, of a stiffness by itself.
        stiffness_limit: error of a fitted stiffness above which the fit goes on with other weights.
        second_force, second_stiffness: errors that weigh equally in that fit.
        scatter: standard deviation of a coefficient around its first value, relative to those of
            the other joints.
        slide_scatter: the same of the stiffness of slides along the finger, as no load tells it.
        gyration: radius of gyration of a section by the depth, for the first stiffness of slides.
        shear: first stiffness of slides across the finger by that of slides along it.
        plate_N_per_mm: stiffness of the chain's contact with a plate.
    """

    shape_error: float = 1.6e-3
    near_best: float = 2.0
    angle_deg: float = 0.7
    place: float = 0.003
    force: float = 0.01
    stiffness: float = 0.04
    stiffness_limit: float = 0.07
    second_force: float = 0.02
    second_stiffness: float = 0.02
    scatter: float = 3.0
    slide_scatter: float = 0.5
    gyration: float = 1 / 6
    shear: float = 1 / 3
    plate_N_per_mm: float = 50.0


POLICY: Final = ChainPolicy()


@dataclass(frozen=True)
class Fitted:
    """A chain with its laws.

    Attributes:
        chain: links and joints.
        laws: (coordinates, 4) coefficients of a p + b p w + c w + d p²: N·mm and rad of hinges, N
            and mm of slides, kPa.
        shape_error_mm: of the line in free bending, for this number of joints.
    """

    chain: Chain
    laws: np.ndarray
    shape_error_mm: float


def _height_mm(free: FingerRun) -> float:
    """Height of the axis of bending, where the line from clamp to tip best keeps its length, which
    is counted along the sections' normals."""
    turn = (free.turn_rad[:, 1:] + free.turn_rad[:, :-1]) / 2
    along = np.stack([-np.sin(turn), np.cos(turn)], axis=-1)
    steps = np.einsum("tsi,tsi->ts", np.diff(free.place_mm, axis=1), along)
    longer, angle = steps.sum(axis=1) - free.length_mm, free.turn_rad[:, -1]
    return -float(longer @ angle / (angle @ angle))


def _chain(run: FingerRun, number: int, height_mm: float) -> Chain:
    """Put joints where equal parts of the free finger's turning at the last stop are reached."""
    turned = run.turn_rad[-1] * np.sign(run.turn_rad[-1, -1])
    shares = isotonic_regression(turned).x  # bellows turn sections to and fro
    shares = shares / shares[-1] + 1e-9 * np.arange(len(shares))
    places = np.interp((np.arange(number) + 0.5) / number, shares, run.levels_mm)
    return Chain(np.stack([np.full(number, height_mm), np.zeros(number), places], axis=1))


def coordinates(chain: Chain, run: FingerRun) -> np.ndarray:
    """Return the coordinates for which a chain's line lies nearest to that of a run.

    Args:
        chain: links and joints.
        run: of finite elements.

    Returns:
        (stops, coordinates) mm and rad.
    """
    height, stops = float(chain.joints_mm[0, 0]), len(run.pressure_kPa)
    points, line = chain.fixed(run.rest_line_mm(height)), run.line_mm(height)
    w: np.ndarray = np.zeros((stops, chain.size))
    w[:, chain.bends] = (run.angle_rad / len(chain.joints_mm))[:, None]
    held = np.full(chain.size, 0.04)  # near 0, where the points leave them open
    held[chain.bends] = 0.0
    for _ in range(15):
        apart = (line - chain.places(w, points)).reshape(stops, -1)
        slopes = np.swapaxes(chain.slopes(w, points), 2, 3).reshape(stops, -1, chain.size)
        normal = np.einsum("smi,smj->sij", slopes, slopes) + np.diag(held)
        right = np.einsum("smi,sm->si", slopes, apart) - held * w
        w = w + np.linalg.solve(normal, right[..., None])[..., 0]
    return w


def chains(free: FingerRun) -> Iterator[tuple[Chain, float]]:
    """Yield chains of one joint more each, up to :data:`MOST_JOINTS` or :data:`LEAST_LINK`.

    Args:
        free: run of the free finger.

    Yields:
        The chain, and the root mean square error of its line (mm).
    """
    height = _height_mm(free)
    rest_line, line = free.rest_line_mm(height), free.line_mm(height)
    for number in range(1, MOST_JOINTS + 1):
        chain = _chain(free, number, height)
        ends = [free.levels_mm[0], *chain.joints_mm[:, 2], free.levels_mm[-1]]
        if number > 1 and np.diff(ends).min() < LEAST_LINK * free.length_mm:
            return
        apart = chain.places(coordinates(chain, free), chain.fixed(rest_line)) - line
        yield chain, float(np.sqrt((apart**2).sum(axis=-1).mean()))


def joints(runs: Sequence[FingerRun], policy: ChainPolicy = POLICY) -> tuple[Chain, float]:
    """Find the height of the axis of bending, and the fewest joints that follow the free finger.

    Args:
        runs: of finite elements, the first one of the free finger.
        policy: what decides.

    Returns:
        The chain, and the root mean square error of its line (mm).
    """
    free = runs[0]
    allowed = policy.shape_error * free.length_mm
    tried: list[tuple[Chain, float]] = []
    for candidate in chains(free):
        tried.append(candidate)
        if candidate[1] <= allowed:
            break
    # walls that swell move sections to and fro, which no chain follows
    near = max(allowed, policy.near_best * min(error for _, error in tried))
    return next((chain, error) for chain, error in tried if error <= near)


@dataclass(frozen=True)
class _States:
    """States of several runs, with what finite elements say about them."""

    pressure_kPa: np.ndarray
    plates: Plates
    near: np.ndarray
    line_mm: np.ndarray
    angle_deg: np.ndarray
    force_N: np.ndarray
    stiffness: np.ndarray

    @classmethod
    def of(cls, chain: Chain, runs: Sequence[FingerRun], policy: ChainPolicy) -> _States:
        place = [np.full(len(run.pressure_kPa), run.plate_mm) for run in runs]
        joined, height = np.concatenate, float(chain.joints_mm[0, 0])
        return cls(
            joined([run.pressure_kPa for run in runs]),
            Plates(joined(place), chain.fixed(runs[0].pressing_mm), policy.plate_N_per_mm),
            joined([coordinates(chain, run) for run in runs]),
            joined([run.line_mm(height) for run in runs]),
            np.degrees(joined([run.angle_rad for run in runs])),
            joined([run.force_N for run in runs]),
            joined([np.stack([run.stiffness_x, run.stiffness_y], axis=1) for run in runs]),
        )


def _balanced(chain: Chain, states: _States, free: FingerRun, policy: ChainPolicy) -> np.ndarray:
    """Coefficients for which the laws bear the plate's force at the finite elements' shape.

    All joints have the same ones. Sideways, these give the tip's stiffness at rest, and so they do
    in bending where the plate's force leaves the stiffness open.
    """
    w, p = states.near, states.pressure_kPa
    lever = chain.slopes(w, states.plates.points)[:, -1, :, 0]
    load = -lever * states.force_N[:, None]
    basis = terms(w, p)

    def solved(rows: np.ndarray, columns: list[int], borne: np.ndarray) -> np.ndarray:
        scale = np.array([1e-2, 1e-2, 1.0, 1e-4])[columns]
        matrix = basis[:, rows][..., columns].reshape(-1, len(columns)) * scale
        return np.asarray(scale * np.linalg.lstsq(matrix, borne[:, rows].ravel(), rcond=None)[0])

    laws = np.zeros((chain.size, TERMS))

    def complete(rows: np.ndarray, stiffness: np.ndarray) -> None:
        """Set the coefficients of p w and w, and find the others."""
        laws[rows, 1:3] = stiffness
        laws[rows[:, None], [0, 3]] = solved(rows, [0, 3], load - basis[..., 1:3] @ stiffness)

    arms_mm2 = np.square(free.tip_mm[0, 2] - chain.joints_mm[:, 2]).sum()
    laws[chain.bends] = solved(chain.bends, [0, 1, 2, 3], load)
    if not (stiffnesses(laws[chain.bends], p) > 0).all():
        # plates press too little to tell a stiffness: the free tip's, if it bent alone
        finite = np.isfinite(free.stiffness_x)
        line = np.polyfit(free.pressure_kPa[finite], free.stiffness_x[finite], 1)
        complete(chain.bends, -arms_mm2 * line)
    along = laws[chain.bends[0], 2] / (policy.gyration * free.depth_mm) ** 2
    complete(chain.of("slide"), np.array([0.0, along]))
    complete(chain.of("shear"), np.array([0.0, policy.shear * along]))
    laws[chain.of("side", "twist"), 2] = -float(arms_mm2 * free.stiffness_y[0])
    return laws


class _Errors:
    """Weighted errors of a chain in all states, and their derivatives by the coefficients."""

    def __init__(self, chain: Chain, states: _States, free: FingerRun, policy: ChainPolicy) -> None:
        self.chain, self.states = chain, states
        self.line = chain.fixed(free.rest_line_mm(float(chain.joints_mm[0, 0])))
        self.tip = chain.fixed(free.tip_mm)
        self.place = policy.place * free.length_mm * np.sqrt(len(self.line.link))
        self.angle, self.stiff = policy.angle_deg, policy.stiffness
        self.force = policy.force * max(float(states.force_N.max()), 1e-9)

    def at(self, laws: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Errors (states · errors) and derivatives (states · errors, coefficients)."""
        chain, states = self.chain, self.states
        state = equilibrium(chain, laws, states.pressure_kPa, states.plates, states.near)
        w, count = state.w, len(states.near)
        moved = np.einsum(
            "sij,sjk->sijk", np.linalg.inv(state.stiffness), terms(w, states.pressure_kPa)
        ).reshape(count, chain.size, -1)
        apart = chain.places(w, self.line) - states.line_mm
        turned = np.degrees(w[:, chain.bends].sum(axis=1)) - states.angle_deg
        softness, by_law = self._softness(laws, w, moved)
        wanted = np.nan_to_num(states.stiffness)
        errors = (
            apart.reshape(count, -1) / self.place,
            turned[:, None] / self.angle,
            (state.forces_N - states.force_N)[:, None] / self.force,
            np.where(wanted > 0, softness * wanted - 1, 0.0) / self.stiff,
        )
        slopes = np.swapaxes(chain.slopes(w, self.line), 2, 3).reshape(count, -1, chain.size)
        derived = (
            slopes @ moved / self.place,
            np.degrees(moved[:, chain.bends].sum(axis=1))[:, None] / self.angle,
            (state.pressing[:, None] @ moved) / self.force,
            wanted[..., None] * by_law / self.stiff,
        )
        together = np.concatenate(derived, axis=1)
        return np.concatenate(errors, axis=1).ravel(), together.reshape(-1, laws.size)

    def stiffness(self, laws: np.ndarray) -> float:
        """Largest relative error of the tip's stiffnesses."""
        chain, states = self.chain, self.states
        p = states.pressure_kPa
        state = equilibrium(chain, laws, p, states.plates, states.near)
        wanted = np.nan_to_num(states.stiffness)
        ours = 1 / softness(chain, laws, state.w, self.tip, p)
        return float(np.abs(ours[wanted > 0] / wanted[wanted > 0] - 1).max(initial=0.0))

    def _softness(
        self, laws: np.ndarray, w: np.ndarray, moved: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Softness at the tip, and derivatives by the coefficients."""
        p, chain = self.states.pressure_kPa, self.chain
        slopes = chain.slopes(w, self.tip)[:, 0]
        along = np.swapaxes(slopes[..., :2], 1, 2) / stiffnesses(laws, p)[:, None]
        bent = np.moveaxis(chain.curvatures(w, slopes)[..., :2], -1, 1)
        by_law = 2 * np.einsum("sai,saij,sjk->sak", along, bent, moved)
        by_law = by_law.reshape(*along.shape, TERMS)
        by_law[..., 1] += along**2 * p[:, None, None]
        by_law[..., 2] += along**2
        return softness(chain, laws, w, self.tip, p), by_law.reshape(len(w), 2, -1)


def softness(
    chain: Chain, laws: np.ndarray, w: np.ndarray, tip: Points, pressures_kPa: np.ndarray
) -> np.ndarray:
    """Return the free tip's displacements along x and y for each N along them.

    Args:
        chain: links and joints.
        laws: (coordinates, 4) coefficients.
        w: (states, coordinates) of the free chain.
        tip: the tip's centre.
        pressures_kPa: (states,).

    Returns:
        (states, 2) in mm/N.
    """
    along = chain.slopes(w, tip)[:, 0, :, :2]
    soft: np.ndarray = (along**2 / stiffnesses(laws, pressures_kPa)[..., None]).sum(axis=1)
    return soft


def fit(
    runs: Sequence[FingerRun],
    policy: ChainPolicy = POLICY,
    chosen: tuple[Chain, float] | None = None,
) -> Fitted:
    """Fit joints and laws to runs.

    Args:
        runs: of finite elements, the first one of the free finger, with stiffnesses of the tip.
        policy: what decides.
        chosen: one of :func:`chains`; None: what :func:`joints` finds.

    Returns:
        The chain with its laws.
    """
    free = runs[0]
    chain, shape_error_mm = chosen or joints(runs, policy)
    states = _States.of(chain, runs, policy)
    first = _balanced(chain, states, free, policy)
    errors = _Errors(chain, states, free, policy)
    typical = np.abs(first)
    largest = float(np.abs(states.pressure_kPa).max())
    # a law that has no term p w gets as much of it as its stiffness may change by
    lacking = typical[:, 1] == 0
    typical[lacking, 1] = typical[lacking, 2] / largest
    unit = policy.scatter * typical
    slides = chain.of("slide")
    unit[slides, 1:3] = policy.slide_scatter * typical[slides, 1:3]
    unit = unit.ravel()

    def laws(x: np.ndarray) -> np.ndarray:
        return first + (unit * x).reshape(first.shape)

    def solved(errors: _Errors, x: np.ndarray) -> np.ndarray:
        def both(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            error, slopes = errors.at(laws(x))
            return np.concatenate([error, x]), np.vstack([slopes * unit, np.eye(len(x))])

        return np.asarray(least_squares(
            lambda x: both(x)[0], x, lambda x: both(x)[1], max_nfev=30, xtol=1e-4, ftol=1e-4
        ).x)  # fmt: skip

    x = solved(errors, np.zeros(first.size))
    if errors.stiffness(laws(x)) > policy.stiffness_limit:
        other = replace(policy, force=policy.second_force, stiffness=policy.second_stiffness)
        x = solved(_Errors(chain, states, free, other), x)
    return Fitted(chain, laws(x), shape_error_mm)
