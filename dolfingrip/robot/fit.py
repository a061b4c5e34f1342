"""Fit a chain to runs of finite elements: its joints, and the laws at them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from dolfingrip.robot.chain import (
    TERMS,
    Chain,
    Equilibrium,
    Plates,
    Points,
    equilibrium,
    stiffnesses,
    terms,
)
from dolfingrip.robot.runs import FingerRun
from dolfingrip.sections.errors import ConfigError

MOST_JOINTS: Final = 24
"""Joints of the longest chain that is tried."""

FIRST_JOINTS: Final = 8
"""Joints of the chain that tells the axis of bending."""


@dataclass(frozen=True)
class ChainPolicy:
    """Numbers that decide about a fit.

    Attributes:
        shape_error: root mean square distance of the back line of the free finger from that of a
            chain of as few joints as possible, relative to the length.
        angle_deg, place, force, stiffness: errors that weigh equally: of the angle, of places by
            the length, of the force by the largest one, of a stiffness by itself.
        scatter: standard deviation of a coefficient around its first value, relative to those of
            the other joints.
        gyration: radius of gyration of a section by the depth, for the first stiffness of slides.
        plate_N_per_mm: stiffness of the chain's contact with a plate.
    """

    shape_error: float = 1.2e-3
    angle_deg: float = 0.7
    place: float = 0.003
    force: float = 0.01
    stiffness: float = 0.04
    scatter: float = 1.0
    gyration: float = 1 / 6
    plate_N_per_mm: float = 50.0


POLICY: Final = ChainPolicy()


@dataclass(frozen=True)
class Sideways:
    """Stiffness of each joint against turning sideways and twisting, c + b p (N·mm/rad).

    Attributes:
        side: b and c of the hinge about x.
        twist: b and c of the hinge about z.
    """

    side: tuple[float, float]
    twist: tuple[float, float]


@dataclass(frozen=True)
class Fitted:
    """A chain with its laws.

    Attributes:
        chain: links and joints.
        laws: (coordinates, 4) coefficients of a p + b p w + c w + d p²: N·mm and rad of hinges, N
            and mm of slides, kPa.
        sideways: of every joint.
        shape_error_mm: of the back line in free bending, for this number of joints.
    """

    chain: Chain
    laws: np.ndarray
    sideways: Sideways
    shape_error_mm: float


def _chain(run: FingerRun, number: int, height_mm: float) -> Chain:
    """Put joints where equal parts of the free finger's turning at the last stop are reached."""
    z, back = run.back_rest_mm[:, 1], run.back_mm[-1]
    even = np.linspace(z[0], z[-1], 91)
    at = np.stack([np.interp(even, z, back[:, axis]) for axis in (0, 1)], axis=1)
    reach = 6  # smooths what bellows do to the back, over a seventh of the length
    chords = at[2 * reach :] - at[: -2 * reach]
    angles = np.unwrap(np.arctan2(-chords[:, 0], chords[:, 1]))
    turned = np.maximum.accumulate((angles - angles[0]) * np.sign(angles[-1] - angles[0]))
    shares = turned / turned[-1] + 1e-9 * np.arange(len(turned))
    places = np.interp((np.arange(number) + 0.5) / number, shares, even[reach:-reach])
    return Chain(np.stack([np.full(number, height_mm), places], axis=1))


def coordinates(chain: Chain, run: FingerRun) -> np.ndarray:
    """Return the coordinates for which a chain's back line lies nearest to that of a run.

    Args:
        chain: links and joints.
        run: of finite elements.

    Returns:
        (stops, coordinates) mm and rad.
    """
    points, stops = chain.fixed(run.back_rest_mm), len(run.back_mm)
    w: np.ndarray = np.zeros((stops, chain.size))
    w[:, chain.hinges] = (run.angle_rad / len(chain.joints_mm))[:, None]
    held = np.zeros(chain.size)
    held[chain.slides] = 0.04  # near 0, where the points leave them open
    for _ in range(15):
        apart = (run.back_mm - chain.places(w, points)).reshape(stops, -1)
        slopes = np.swapaxes(chain.slopes(w, points), 2, 3).reshape(stops, -1, chain.size)
        normal = np.einsum("smi,smj->sij", slopes, slopes) + np.diag(held)
        right = np.einsum("smi,sm->si", slopes, apart) - held * w
        w = w + np.linalg.solve(normal, right[..., None])[..., 0]
    return w


def _shape_error(chain: Chain, run: FingerRun) -> float:
    apart = chain.places(coordinates(chain, run), chain.fixed(run.back_rest_mm)) - run.back_mm
    return float(np.sqrt((apart**2).sum(axis=-1).mean()))


def joints(runs: Sequence[FingerRun], policy: ChainPolicy = POLICY) -> tuple[Chain, float]:
    """Find the height of the axis of bending, and the fewest joints that follow the free finger.

    The axis is the height at which the line from clamp to tip keeps its length as the finger bends.
    Pressure stretches it, so the runs must have different angles at equal pressures.

    Args:
        runs: of finite elements, the first one of the free finger.
        policy: what decides.

    Returns:
        The chain, and the root mean square error of its back line (mm).

    Raises:
        ConfigError: one line, where no chain follows the back.
    """
    free = runs[0]
    first = _chain(free, FIRST_JOINTS, 0.0)
    w = np.concatenate([coordinates(first, run) for run in runs])
    p = np.concatenate([run.pressure_kPa for run in runs])
    longer = w[:, first.slides].sum(axis=1)
    known = np.stack([w[:, first.hinges].sum(axis=1), p, p * p], axis=1)
    known /= np.abs(known).max(axis=0)
    height = -float(np.linalg.lstsq(known, longer, rcond=None)[0][0])
    height /= float(np.abs(w[:, first.hinges].sum(axis=1)).max())
    length = float(np.ptp(free.back_rest_mm[:, 1]))
    for number in range(2, MOST_JOINTS + 1):
        chain = _chain(free, number, height)
        error = _shape_error(chain, free)
        if error <= policy.shape_error * length:
            return chain, error
    raise ConfigError(
        f"a chain of {MOST_JOINTS} joints follows the free finger's back to {error:.2g} mm; "
        f"allowed: a finger whose back it follows to {policy.shape_error * length:.2g} mm, so one "
        "without folds there"
    )


@dataclass(frozen=True)
class _States:
    """States of several runs, with what finite elements say about them."""

    pressure_kPa: np.ndarray
    plates: Plates
    near: np.ndarray
    back_mm: np.ndarray
    angle_deg: np.ndarray
    force_N: np.ndarray
    stiffness_x: np.ndarray

    @classmethod
    def of(cls, chain: Chain, runs: Sequence[FingerRun], policy: ChainPolicy) -> _States:
        place = np.concatenate([np.full(len(run.back_mm), run.plate_mm) for run in runs])
        joined = np.concatenate
        return cls(
            joined([run.pressure_kPa for run in runs]),
            Plates(place, chain.fixed(runs[0].pressing_mm), policy.plate_N_per_mm),
            joined([coordinates(chain, run) for run in runs]),
            joined([run.back_mm for run in runs]),
            np.degrees(joined([run.angle_rad for run in runs])),
            joined([run.force_N for run in runs]),
            joined([run.stiffness_x for run in runs]),
        )


def _balanced(chain: Chain, states: _States, depth_mm: float, policy: ChainPolicy) -> np.ndarray:
    """Coefficients for which the laws bear the plate's force at the finite elements' shape."""
    w, p = states.near, states.pressure_kPa
    lever = chain.slopes(w, states.plates.points)[:, 0, :, 0]
    load = -lever * states.force_N[:, None]
    scale = np.array([1e-2, 1e-2, 1.0, 1e-4])
    laws = np.zeros((chain.size, TERMS))
    known = terms(w, p)
    for each in chain.hinges:
        laws[each] = scale * np.linalg.lstsq(known[:, each] * scale, load[:, each], rcond=None)[0]
    stiff = float(np.median(-laws[chain.hinges, 2])) / (policy.gyration * depth_mm) ** 2
    only = [0, 3]
    for each in chain.slides:
        laws[each, 2] = -stiff
        borne = load[:, each] + stiff * w[:, each]
        found = np.linalg.lstsq(known[:, each][:, only] * scale[only], borne, rcond=None)[0]
        laws[each, only] = scale[only] * found
    return laws


class _Errors:
    """Weighted errors of a chain in all states, and their derivatives by the coefficients."""

    def __init__(
        self, chain: Chain, states: _States, back: Points, tip: Points, policy: ChainPolicy
    ) -> None:
        self.chain, self.states, self.back, self.tip = chain, states, back, tip
        length = float(np.ptp(back.rest_mm[:, 1]))
        self.place = policy.place * length * np.sqrt(len(back.link))
        self.angle, self.stiff = policy.angle_deg, policy.stiffness
        self.force = policy.force * max(float(states.force_N.max()), 1e-9)

    def at(self, laws: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Errors (states · errors) and derivatives (states · errors, coefficients)."""
        chain, states = self.chain, self.states
        found = equilibrium(chain, laws, states.pressure_kPa, states.plates, states.near)
        w, count = found.w, len(states.near)
        moved = np.einsum(
            "sij,sjk->sijk", np.linalg.inv(found.stiffness), terms(w, states.pressure_kPa)
        )
        apart = chain.places(w, self.back) - states.back_mm
        turned = np.degrees(w[:, chain.hinges].sum(axis=1)) - states.angle_deg
        softness, by_law = _softness(chain, laws, states.pressure_kPa, found, self.tip, moved)
        wanted = np.nan_to_num(states.stiffness_x)
        errors = (
            apart.reshape(count, -1) / self.place,
            turned[:, None] / self.angle,
            (found.forces_N - states.force_N)[:, None] / self.force,
            np.where(wanted > 0, softness * wanted - 1, 0.0)[:, None] / self.stiff,
        )
        slopes = np.einsum("smid,sijk->smdjk", chain.slopes(w, self.back), moved)
        derived = (
            slopes.reshape(count, -1, chain.size * TERMS) / self.place,
            np.degrees(moved[:, chain.hinges].sum(axis=1)).reshape(count, 1, -1) / self.angle,
            np.einsum("si,sijk->sjk", found.pressing, moved).reshape(count, 1, -1) / self.force,
            (wanted[:, None, None] * by_law).reshape(count, 1, -1) / self.stiff,
        )
        together = np.concatenate(derived, axis=1)
        return np.concatenate(errors, axis=1).ravel(), together.reshape(-1, laws.size)


def _softness(
    chain: Chain,
    laws: np.ndarray,
    pressures_kPa: np.ndarray,
    found: Equilibrium,
    tip: Points,
    moved: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Displacement of the free tip along x for each N, and derivatives by the coefficients."""
    slopes = chain.slopes(found.w, tip)[:, 0]
    along, stiff = slopes[..., 0], stiffnesses(laws, pressures_kPa)
    by_law = np.einsum(
        "si,sij,sjkl->skl", 2 * along / stiff, chain.curvatures(slopes)[..., 0], moved
    )
    square = (along / stiff) ** 2
    by_law[..., 1] += square * pressures_kPa[:, None]
    by_law[..., 2] += square
    return (along**2 / stiff).sum(axis=1), by_law


def fit(runs: Sequence[FingerRun], policy: ChainPolicy = POLICY) -> Fitted:
    """Fit joints and laws to runs.

    Args:
        runs: of finite elements, the first one of the free finger, with stiffnesses of the tip.
        policy: what decides.

    Returns:
        The chain with its laws.

    Raises:
        ConfigError: one line, where no chain follows the back.
    """
    free = runs[0]
    chain, shape_error_mm = joints(runs, policy)
    states = _States.of(chain, runs, policy)
    first = _balanced(chain, states, free.depth_mm, policy)
    errors = _Errors(
        chain, states, chain.fixed(free.back_rest_mm), chain.fixed(free.tip_mm), policy
    )
    typical = np.empty_like(first)
    for rows in (chain.hinges, chain.slides):
        typical[rows] = np.median(np.abs(first[rows]), axis=0)
    # a law that has no term p w of a slide gets as much of it as its stiffness may change by
    largest = float(np.abs(states.pressure_kPa).max())
    typical[chain.slides, 1] = typical[chain.slides, 2] / largest
    unit = (policy.scatter * typical).ravel()

    def laws(x: np.ndarray) -> np.ndarray:
        return first + (unit * x).reshape(first.shape)

    def both(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        error, slopes = errors.at(laws(x))
        return np.concatenate([error, x]), np.vstack([slopes * unit, np.eye(len(x))])

    found = least_squares(
        lambda x: both(x)[0], np.zeros(first.size), lambda x: both(x)[1], max_nfev=30, xtol=1e-4,
        ftol=1e-4,
    )  # fmt: skip
    best = laws(found.x)
    return Fitted(chain, best, sideways(chain, best, free), shape_error_mm)


def sideways_softness(
    chain: Chain, w: np.ndarray, tip: Points, stiff: Sideways, pressures_kPa: np.ndarray
) -> np.ndarray:
    """Return the free tip's displacement along y for each N.

    Args:
        chain: links and joints.
        w: (states, coordinates) of the free chain.
        tip: the tip's centre.
        stiff: stiffness of the joints against turning sideways.
        pressures_kPa: (states,).
    """
    centres, angles = chain.frames(w)
    arms = chain.places(w, tip) - centres[:, 1:]
    cosine, sine = np.cos(angles[:, 1:]), np.sin(angles[:, 1:])
    side = sine * arms[..., 0] - cosine * arms[..., 1]
    twist = cosine * arms[..., 0] + sine * arms[..., 1]
    found = np.zeros(len(w))
    for lever, (rising, rest) in ((side, stiff.side), (twist, stiff.twist)):
        found += (lever**2).sum(axis=1) / (rest + rising * pressures_kPa)
    return found


def sideways(chain: Chain, laws: np.ndarray, free: FingerRun) -> Sideways:
    """Fit the stiffness of joints against turning sideways.

    Args:
        chain: links and joints.
        laws: in the plane of bending.
        free: run of the free finger with the stiffness of its tip along y.

    Returns:
        Stiffness that every joint has.
    """
    p, tip = free.pressure_kPa, chain.fixed(free.tip_mm)
    nowhere = Plates(np.full(len(p), -np.inf), tip, 0.0)
    w = equilibrium(chain, laws, p, nowhere, coordinates(chain, free)).w
    largest = float(np.abs(p).max())
    lever = float(np.square(free.tip_mm[0, 1] - chain.joints_mm[:, 1]).sum())
    start = np.log(lever * free.stiffness_y[0])

    def of(x: np.ndarray) -> Sideways:
        side, twist = np.exp(x[:2])
        return Sideways((side * x[2] / largest, side), (twist * x[3] / largest, twist))

    def errors(x: np.ndarray) -> np.ndarray:
        soft = sideways_softness(chain, w, tip, of(x), p)
        return np.concatenate([np.log(soft * free.stiffness_y), 0.05 * x[2:]])

    low, high = [start - 5, start - 5, -0.9, -0.9], [start + 5, start + 5, 3.0, 3.0]
    return of(least_squares(errors, [start, start, 0.0, 0.0], bounds=(low, high)).x)
