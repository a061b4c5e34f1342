"""Emulators of what causes change about fingers, from closed forms and simulations with slopes.

Those causes are simulated further that could be seen beside others. A cause is simulated once at
first. What it changes there, and its derivatives, may be taken in any amount: that says the most
that it can explain, alone and beside each other cause. Where that is too little to be seen, no
further simulation can tell of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np
import scipy.linalg

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.emulator import (
    Coordinate,
    Emulator,
    SimulatedChanges,
    Stacked,
    places,
    principal,
    trained_on,
)
from dolfingrip.diagnosis.core.evidence import (
    LEVELS,
    NONE,
    CovarianceModel,
    InferenceProblem,
    Subset,
    at_levels,
)
from dolfingrip.diagnosis.core.search import Key
from dolfingrip.diagnosis.core.unknown import Cause, Factor
from dolfingrip.diagnosis.finger import closed_forms
from dolfingrip.diagnosis.finger.model import FingerSimulation, even, nodes_of, plain_fit, spread
from dolfingrip.diagnosis.finger.unknowns import IMPLAUSIBLE, TILTED, box_of, coordinates_of
from dolfingrip.diagnosis.policy import MODEL, POLICY
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, SimulatedReadings, simulate
from dolfingrip.extensions.effect import Energetic
from dolfingrip.extensions.index import effect
from dolfingrip.parameter.nuisances import modulus_keys


def columns_of(simulated: SimulatedChanges, scale: np.ndarray) -> np.ndarray:
    """Return what a cause changes, and its derivatives, at the middle moduli, (n, k).

    Args:
        simulated: its simulations.
        scale: noise of the readings, shape (n,).
    """
    middle = len(simulated.values) // 2
    rows = np.vstack([simulated.values[middle], *np.moveaxis(simulated.slopes[middle], 1, 0)])
    rows = rows[np.isfinite(rows).all(axis=1)] / scale
    return np.asarray(principal(rows, len(rows)).T * scale[:, None])


def worth_simulating(
    plain: InferenceProblem, columns: Mapping[str, np.ndarray], finished: Set[str]
) -> set[str]:
    """The next causes to simulate further: each could be seen in a hypothesis that may be likely.

    A hypothesis may be likely where its largest likelihood is not hopelessly below that of any
    other. A cause is seen in it where the readings are so much better explained with it. Single
    causes come first, then pairs: these also mend what a first simulation of one of them misses.
    Last, what first simulations may miss counts, too.

    Args:
        plain: the model without causes.
        columns: what each cause changes, (n, k).
        finished: causes that have all their simulations.
    """
    explained, largest = _bounds(plain, columns)
    for count, share in ((1, 0.0), (2, 0.0), (2, POLICY.first_error)):
        tried = {each: value for each, value in largest.items() if len(each[0]) <= count}
        best = max(tried.values())
        found: set[str] = set()
        for (subset, size), value in tried.items():
            gain = explained[subset, size]
            known = tuple(name for name in subset if name in finished)
            missed = 0.5 * share**2 * (gain - explained[known, size])
            if value < best - POLICY.hopeless - missed:
                continue
            for name in set(subset) - finished:
                without = tuple(each for each in subset if each != name)
                by_chance = columns[name].shape[1]
                if gain - explained[without, size] > POLICY.visible_sigma**2 + by_chance:
                    found.add(name)
        if found:
            return found
    return set()


def _bounds(
    plain: InferenceProblem, columns: Mapping[str, np.ndarray]
) -> tuple[dict[Key, float], dict[Key, float]]:
    """How much χ² each hypothesis explains at most, and ln of its largest likelihood."""
    explained: dict[Key, float] = {}
    largest: dict[Key, float] = {}
    every: list[Subset] = [NONE, *((name,) for name in columns), *combinations(columns, 2)]
    for size, level in at_levels(plain).items():
        rest, own = _about_fit(plain, level)
        rest = rest - own @ (own.T @ rest)
        beside = {}
        for name, each in columns.items():
            white = level.whitened(each)
            beside[name] = _basis(white - own @ (own.T @ white))
        alone = -0.5 * float(rest @ rest) - 0.5 * level.log_det + float(np.log(LEVELS[size]))
        for subset in every:
            gain = 0.0
            if subset:
                white_columns = np.hstack([beside[name] for name in subset])
                white_columns = white_columns if len(subset) == 1 else _basis(white_columns)
                gain = float(np.square(white_columns.T @ rest).sum())
            explained[subset, size] = gain
            largest[subset, size] = alone + 0.5 * gain
    return explained, largest


def _about_fit(plain: InferenceProblem, level: CovarianceModel) -> tuple[np.ndarray, np.ndarray]:
    """Return the residual without causes, (n,), and a basis of what the model may change; white."""
    zeta = plain_fit(plain, level).zeta
    here = plain.predicted(NONE, zeta)
    ways = []
    for step in np.diag(np.full(plain.nuisance_count, POLICY.parabola)):
        more, less = (plain.predicted(NONE, zeta + by * step) - here for by in (1.0, -1.0))
        ways += [more - less, more + less]
    return level.whitened(plain.value - here), _basis(level.whitened(np.column_stack(ways)))


def _basis(white: np.ndarray) -> np.ndarray:
    """Orthonormal columns of the same span, without ways that change nothing."""
    if not white.size:
        return white
    left, sizes, _ = scipy.linalg.svd(white, full_matrices=False)
    return np.asarray(left[:, sizes > 1e-8 * max(sizes[0], 1e-300)])


FINGERS: Final = frozenset({"bending", "blocked_force"})


@dataclass(frozen=True, eq=False)
class _Design:
    """Simulations of a cause.

    Attributes:
        zeta: places, the moduli's first where these do not scale it.
        scales: whether they do.
        variants: one for each place.
    """

    cause: Cause
    zeta: np.ndarray
    scales: bool
    variants: list[ModelVariant]

    def first(self) -> _Design:
        """The place nearest to the middle alone, on either side where these differ."""
        size = np.linalg.norm(self.zeta, axis=1)
        sides = [self.zeta[:, -1] >= 0, self.zeta[:, -1] < 0]
        if not effect(self.cause.name).lopsided:
            sides = [np.ones(len(size), dtype=bool)]
        some = sorted({int(np.where(side, size, np.inf).argmin()) for side in sides if side.any()})
        return replace(self, zeta=self.zeta[some], variants=[self.variants[i] for i in some])


def trained_causes(
    simulation: FingerSimulation,
    causes: Sequence[Cause],
    scale: np.ndarray,
    plain: InferenceProblem,
    say: Callable[[str], None],
    *,
    fully: bool,
) -> tuple[dict[str, Emulator], tuple[str, ...], dict[str, str]]:
    """Simulate causes, and make emulators of what they change.

    Each is simulated once at first, and further where it could be seen.

    Args:
        simulation: of the model without them.
        causes: that may be named.
        scale: noise of the readings, shape (n,).
        plain: the model without causes.
        say: told what is being done.
        fully: simulate every cause further.

    Returns:
        Emulators by name, causes that no reading feels, and why others could not be simulated, by
        name.
    """
    factor = plain.factor
    # where causes are simulated
    middle = float(np.clip(np.log(simulation.centre) / factor.std, *plain.baseline_box[0]))
    nodes = nodes_of(plain.baseline_box[0])
    closed = {each.name: each for each in causes if closed_forms.known(simulation, each)}
    designs = {
        each.name: _design(simulation, each, factor, middle)
        for each in causes
        if each.name not in closed
    }
    told: dict[str, SimulatedChanges | None] = {
        name: closed_forms.simulations(simulation, each, nodes, factor)
        for name, each in closed.items()
    }
    failed: dict[str, str] = {}

    def compute(some: dict[str, _Design]) -> None:
        every = [variant for each in some.values() for variant in each.variants]
        workers = simulation.workers
        runs = iter(simulate(simulation.measurement, simulation.config, every, workers))
        for name, each in some.items():
            own = [next(runs) for _ in each.variants]
            told[name], failed[name] = _assembled(simulation, each, own, nodes, factor)

    more = designs
    if not fully:
        compute({name: each.first() for name, each in designs.items()})
        more = {name: each for name, each in designs.items() if told[name] is None}
    further = {name for name in designs if name not in more and effect(name).by_slopes}
    while True:
        compute(more)
        further |= set(more)
        if further == set(designs):
            break
        known = {name: columns_of(each, scale) for name, each in told.items() if each is not None}
        wanted = worth_simulating(plain, known, further | set(closed))
        if not wanted:
            break
        say(f"simulating further what could be seen: {', '.join(sorted(wanted))}")
        more = {name: designs[name] for name in wanted}

    emulators: dict[str, Emulator] = {}
    unseen: list[str] = []
    for cause in causes:
        own = told[cause.name]
        if own is None:
            continue
        if np.sqrt(np.square(own.values / scale).mean(axis=2)).max() < POLICY.invisible:
            unseen.append(cause.name)
            continue
        if cause.name in designs and not designs[cause.name].scales:
            emulator = _by_moduli(simulation, cause, own, scale, factor, middle)
        else:
            degree = POLICY.closed_form_places - 1 if cause.name in closed else POLICY.curved_degree
            degree = 1 if effect(cause.name).by_slopes else degree
            emulator = trained_on(own, coordinates_of(cause), scale, degree=degree)
        emulators[cause.name] = emulator
    return emulators, tuple(unseen), {name: why for name, why in failed.items() if why}


def _by_moduli(
    simulation: FingerSimulation,
    cause: Cause,
    simulated: SimulatedChanges,
    scale: np.ndarray,
    factor: Factor,
    middle: float,
) -> Emulator:
    """The emulator of a cause whose simulations the moduli do not scale."""
    by_moduli = Coordinate(lambda zeta: zeta - middle, amplitude=False)
    own = (by_moduli, *coordinates_of(cause, 1))
    low, high = spread(even(middle) + 1.5 * MODEL.beside * np.array([-1.0, 1.0]))
    moduli = (float(low), float(high))
    approximation = closed_forms.approximate(simulation, cause, scale, factor, moduli)
    if approximation is None:
        return trained_on(simulated, own, scale)
    return Stacked.of(approximation, trained_on(_without(simulated, approximation), own, scale))


def _design(simulation: FingerSimulation, cause: Cause, factor: Factor, middle: float) -> _Design:
    kind = effect(cause.name)
    scales = (
        simulation.scales
        and kind.kind not in ("dissipative", "loading")
        and not kind.clock
        and cause.name != TILTED
    )
    zeta = _zeta(cause, None if scales else middle)
    if not scales:
        zeta[:, 0] = spread(zeta[:, 0])
    experiments = _felt_in(cause.name, simulation.lab)
    flat = simulation.flat
    variants = []
    for z in zeta:
        c = simulation.centre if scales else float(factor(z[0]))
        own = z if scales else z[1:]
        overrides = {**flat, **simulation.moduli(c), **cause.overrides(own, c)}
        gradients = [number.gradient for number in cause.numbers]
        if not scales:
            gradients += modulus_keys(simulation.applied)
        tilt_deg = 0.0
        if cause.name == TILTED and simulation.lab.gravity.acceleration_m_s2:
            overrides, experiments = {**flat, **simulation.moduli(c)}, FINGERS
            gradients, tilt_deg = gradients[1:], float(cause.numbers[0].at(own[0]))
        variants.append(
            ModelVariant(
                overrides, tuple(gradients), headroom=simulation.headroom, only_in=experiments,
                tilt_deg=tilt_deg,
            )
        )  # fmt: skip
    return _Design(cause, zeta, scales, variants)


def _zeta(cause: Cause, middle: float | None) -> np.ndarray:
    """Places of a cause's simulations, evenly spread; the moduli's first where these have one."""
    if effect(cause.name).by_slopes:
        neutral = [number.zeta(cause.neutral(number)) for number in cause.numbers]
        return np.array([neutral if middle is None else [even(middle), *neutral]])
    reach = POLICY.finger_reach / max(1.0, np.sqrt(len(cause.numbers) / 2))
    box = np.clip(box_of(cause), -reach, reach)
    if middle is not None:
        box = np.vstack([even(middle) + MODEL.beside * np.array([-1.0, 1.0]), box])
    d = len(box)
    count = POLICY.finger_places[min(d, len(POLICY.finger_places)) - 1]
    return _places(box, POLICY.implausible_places if cause.name in IMPLAUSIBLE else count, cause)


def _felt_in(name: str, config: Config) -> frozenset[str]:
    """Experiments that can feel an effect: elsewhere it needs no simulation.

    A coupon feels what is in the material.
    """
    found = {"blocked_force"}
    if effect(name).felt_in_bending(config):
        found.add("bending")
    if issubclass(effect(name), Energetic):
        found.add("coupon")
    return frozenset(found)


def _places(box: np.ndarray, count: int, cause: Cause) -> np.ndarray:
    if len(box) > 1:
        return places(box, count)
    low, high = box[0]
    signed = coordinates_of(cause)[0].signed
    # of either sign both ends count; of a positive amplitude the strong one does
    ends, count = (POLICY.signed_ends, count + 1) if signed else (POLICY.positive_ends, count)
    return np.asarray(low + (high - low) * np.linspace(*ends, count))[:, None]


def _assembled(
    simulation: FingerSimulation,
    design: _Design,
    runs: Sequence[SimulatedReadings],
    nodes: np.ndarray,
    factor: Factor,
) -> tuple[SimulatedChanges | None, str]:
    """Changes and their derivatives by ζ; None and why where too few simulations ended well."""
    numbers = design.cause.numbers
    experiment = simulation.measurement.listed()["experiment"].to_numpy()
    felt = np.isin(experiment, list(design.variants[0].only_in or ()))
    values, slopes, kept = [], [], []
    at = nodes if design.scales else None
    keys = [number.gradient for number in numbers]
    known = set(design.variants[0].gradients)
    for place, run in enumerate(runs):
        z = design.zeta[place]
        own = z if design.scales else z[1:]
        rates = [float(number.slope(zi)) for number, zi in zip(numbers, own, strict=True)]
        told, derived = [], []
        for node in nodes if at is not None else [z[0]]:
            whole = float(factor(node))
            c = whole / simulation.centre
            # its own moduli are simulated at c, an elastic one is read there
            beside = simulation.centre if design.scales else whole
            by = c if design.scales else 1.0
            y = simulation.at(run, by)
            first: list[np.ndarray] = []
            for key, number, rate in zip(keys, numbers, rates, strict=True):
                per = rate * (beside if number.modulus else 1.0)
                slope = simulation.at(run, by, key) * per
                first.append(slope if key in known else np.full(len(slope), np.nan))
            if not design.scales:
                step = 1e-3
                by_log = run.by_log_modulus(simulation.measurement)
                for key, number, zi in zip(keys, numbers, own, strict=True):
                    if number.modulus:
                        value = float(number.at(zi)) * whole
                        by_log = by_log + simulation.at(run, 1.0, key) * value
                first = [by_log, *first]
            graded, jacobian = simulation.graded(y, whole, np.nan_to_num(np.column_stack(first)))
            base = simulation.graded_at(whole)
            jacobian[:, ~np.isfinite(np.column_stack(first)).all(axis=0)] = np.nan
            if not design.scales:
                log_slope = float(np.log(factor(node + step) / factor(node - step)) / (2 * step))
                more, less = (simulation.graded_at(whole * np.exp(w * step)) for w in (1, -1))
                jacobian[:, 0] = (jacobian[:, 0] - (more - less) / (2 * step)) * log_slope
            told.append(np.where(felt, graded - base, 0.0))
            derived.append(np.where(felt, jacobian.T, 0.0))
        change = np.array(told)
        if np.isfinite(change).all():
            kept.append(place)
            values.append(change)
            slopes.append(np.array(derived))
    if kept and effect(design.cause.name).by_slopes:
        return _tangent(design.zeta[0], slopes[0], at), ""
    least = 1 if len(runs) < 3 else max(2, len(numbers))
    if len(kept) < least:
        why = next((f.sentence for run in runs for f in run.failures), "no simulation ended")
        return None, why
    return (
        SimulatedChanges(
            design.zeta[kept], np.stack(values, axis=1), np.stack(slopes, axis=1), at
        ), "",
    )  # fmt: skip


def _tangent(neutral: np.ndarray, slopes: np.ndarray, nodes: np.ndarray | None) -> SimulatedChanges:
    """Changes that are linear in a cause's numbers, by their slopes, (nodes or 1, d, n)."""
    first = int(nodes is None)  # the moduli's
    steps = np.eye(len(neutral))[first:]
    every = np.repeat(slopes[:, None], len(steps), axis=1)
    return SimulatedChanges(neutral + steps, slopes[:, first:], every, nodes)


def _without(simulated: SimulatedChanges, approximation: Emulator) -> SimulatedChanges:
    """Return what simulations change beyond an approximate law."""
    values, slopes = simulated.values.copy(), simulated.slopes.copy()
    for place, z in enumerate(simulated.zeta):
        g, dg = approximation.with_slopes(z)
        values[0, place] -= approximation.columns @ g
        slopes[0, place] -= (approximation.columns @ dg).T
    return replace(simulated, values=values, slopes=slopes)
