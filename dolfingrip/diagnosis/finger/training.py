"""Emulators of what causes change about fingers, from closed forms and simulations with slopes.

Those causes are simulated further that could be seen beside others. At first one simulation of the
model has its derivatives by the amplitudes of all causes that moduli scale, at which these do
nothing; any other cause is simulated once. What a cause changes there, and its derivatives, may be
taken in any amount: that says the most that it can explain, alone and beside each other cause.
Where that is too little to be seen, no further simulation can tell of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Final

import numpy as np
import scipy.linalg

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.emulator import (
    Coordinate,
    Emulator,
    PolynomialEmulator,
    SimulatedChanges,
    Stacked,
    Straight,
    places,
    principal,
    trained_on,
    turning,
)
from dolfingrip.diagnosis.core.evidence import (
    LEVELS,
    NONE,
    CovarianceModel,
    InferenceProblem,
    Key,
    Subset,
)
from dolfingrip.diagnosis.core.search import one_at_a_time
from dolfingrip.diagnosis.core.unknown import Cause, Unknown
from dolfingrip.diagnosis.finger import closed_forms
from dolfingrip.diagnosis.finger.model import (
    FingerSimulation,
    even,
    fitted_moduli,
    nodes_of,
    plain_fit,
    spread,
)
from dolfingrip.diagnosis.policy import MODEL, POLICY
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, SimulatedReadings, simulate
from dolfingrip.diagnosis.simulation.unknowns import IMPLAUSIBLE, TILTED
from dolfingrip.extensions.effect import Displaying, Energetic
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
    A pair is known well enough where what first simulations may miss of it hardly changes its
    likelihood. Last, what they may miss counts in favour of a pair.

    Args:
        plain: the model without causes.
        columns: what each cause changes, (n, k).
        finished: causes that have all their simulations.
    """
    explained, largest = _bounds(plain, columns)
    for count, in_favour in ((1, False), (2, False), (2, True)):
        tried = {each: value for each, value in largest.items() if len(each[0]) <= count}
        best = max(tried.values())
        found: set[str] = set()
        for (subset, size), value in tried.items():
            gain = explained[subset, size]
            known = tuple(name for name in subset if name in finished)
            missed = 0.5 * POLICY.first_error**2 * (gain - explained[known, size])
            if value < best - POLICY.hopeless - in_favour * missed:
                continue
            if len(subset) > 1 and missed < POLICY.indifferent:
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
    for size, level in plain.levels.items():
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
class CauseDesign:
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

    @property
    def straight(self) -> bool:
        """True if the change is taken as linear, so that derivatives tell all of it."""
        return effect(self.cause.name).by_slopes

    @property
    def expands(self) -> bool:
        """True if derivatives where the cause does nothing tell what it changes at first."""
        kind, nuisance = effect(self.cause.name), self.cause.name in IMPLAUSIBLE
        return self.scales and not (nuisance or kind.lopsided or kind.curved)

    @property
    def felt_in(self) -> frozenset[str]:
        """Experiments that can feel the cause."""
        return self.variants[0].only_in or frozenset()

    def first(self) -> CauseDesign:
        """The place nearest to the middle alone, on either side where these differ."""
        size = np.linalg.norm(self.zeta, axis=1)
        sides = [self.zeta[:, -1] >= 0, self.zeta[:, -1] < 0]
        if not effect(self.cause.name).lopsided:
            sides = [np.ones(len(size), dtype=bool)]
        some = sorted({int(np.where(side, size, np.inf).argmin()) for side in sides if side.any()})
        return replace(self, zeta=self.zeta[some], variants=[self.variants[i] for i in some])


@dataclass(eq=False)
class CauseTraining:
    """Simulations of causes, and emulators of what they change.

    Each is known by derivatives or one simulation at first. It is simulated further where it could
    be seen, and beyond the ordinary part of its prior where the readings ask for that.

    Attributes:
        simulation: of the model without them.
        causes: that may be named.
        plain: the model without causes.
        scale: noise of the readings, shape (n,).
        failed: why causes could not be simulated, by name.
        boxes: ranges of ζ that each emulator is read in, (d, 2), by name.
        nodes: ζ of the moduli that simulations are read at.
        designs: simulations of each cause that needs any, by name.
        changes: what is known of each cause, by name; None where it could not be simulated.
    """

    simulation: FingerSimulation
    causes: Sequence[Cause]
    plain: InferenceProblem
    scale: np.ndarray
    failed: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        simulation, plain = self.simulation, self.plain
        # where causes are simulated that moduli do not scale
        middle = np.log(fitted_moduli(plain, simulation, scaled=False)) / plain.factor.log_std
        self._middle = float(np.clip(middle, *plain.baseline_box[0]))
        self.nodes = nodes_of(plain.baseline_box[0])
        self.boxes = {each.name: box_of(each) for each in self.causes}
        self.designs: dict[str, CauseDesign] = {}
        self.changes: dict[str, SimulatedChanges | None] = {}
        self._trained: dict[str, tuple[SimulatedChanges, np.ndarray, Emulator]] = {}
        for each in self.causes:
            if closed_forms.known(simulation, each):
                self.changes[each.name] = self._closed_form(each)
            else:
                zeta = _zeta(each, None if _scales(simulation, each) else self._middle)
                self.designs[each.name] = _design(simulation, each, plain.factor, zeta)

    def run(self, say: Callable[[str], None], *, fully: bool) -> None:
        """Simulate all causes.

        Args:
            say: told what is being done.
            fully: simulate every cause as far as one that could be seen.

        Raises:
            ConfigError: one line, where nothing can be simulated.
        """
        designs, expanded = self.designs, self.expanded()
        self.changes |= expanded
        if not fully:
            self.compute({n: each.first() for n, each in designs.items() if n not in expanded})
        more = {
            name: each
            for name, each in designs.items()
            if not self.changes.get(name) or (fully and not each.straight)
        }
        further = {name for name, each in designs.items() if name not in more and each.straight}
        closed = set(self.changes) - set(designs)
        while True:
            self.compute(more)
            further |= set(more)
            if further == set(designs):
                break
            known = {
                name: columns_of(each, self.scale)
                for name, each in self.changes.items() if each is not None
            }  # fmt: skip
            wanted = worth_simulating(self.plain, known, further | closed)
            wanted = wanted or self._seen() - further  # a fit may see what bounds do not
            if not wanted:
                break
            say(f"simulating further what could be seen: {', '.join(sorted(wanted))}")
            more = {name: designs[name] for name in wanted}
        if not fully:
            self.refine(further, say)
            self._reach(say)

    def _seen(self) -> set[str]:
        """Names of causes that are seen by themselves in likely fits, by what is simulated."""
        posterior = one_at_a_time(self.problem.levels, {})
        least = POLICY.rival * posterior.probability.max()
        visible = {name for p, fit in posterior.weighed if p >= least for name in fit.visible}
        return visible & self.designs.keys()

    @property
    def problem(self) -> InferenceProblem:
        """The problem with those causes that some reading feels."""
        emulators = {each.name: self._emulator(each) for each in self.felt}
        return replace(
            self.plain, emulators=emulators, rig=frozenset(IMPLAUSIBLE) & frozenset(emulators),
            boxes={name: self.boxes[name] for name in emulators},
            tails={each.name: each.tails for each in self.felt},
        )  # fmt: skip

    @property
    def felt(self) -> list[Cause]:
        """Causes that some reading feels."""
        return [each for each in self.causes if self.changes[each.name] and not self._faint(each)]

    @property
    def unseen(self) -> tuple[str, ...]:
        """Names of those that no reading feels."""
        return tuple(e.name for e in self.causes if self.changes[e.name] and self._faint(e))

    def _faint(self, cause: Cause) -> bool:
        own = self.changes[cause.name]
        assert own is not None
        rms = np.sqrt(np.square(own.values / self.scale).mean(axis=2))
        return float(rms.max()) < POLICY.invisible

    def _closed_form(self, cause: Cause) -> SimulatedChanges:
        box, factor = self.boxes[cause.name], self.plain.factor
        return closed_forms.simulations(self.simulation, cause, box, self.nodes, factor)

    def compute(self, some: Mapping[str, CauseDesign]) -> None:
        """Simulate designs; what they tell takes the place of what was known of their causes.

        Args:
            some: designs by the name of their cause.
        """
        simulation, factor = self.simulation, self.plain.factor
        every = [variant for each in some.values() for variant in each.variants]
        runs = iter(simulate(simulation.measurement, simulation.config, every, simulation.workers))
        for name, each in some.items():
            own = [next(runs) for _ in each.variants]
            self.changes[name], why = _assembled(simulation, each, own, self.nodes, factor)
            self.failed.pop(name, None)
            if why:
                self.failed[name] = why

    def expanded(self) -> dict[str, SimulatedChanges | None]:
        """Changes by causes, expanded about the model without them, by one simulation of it."""
        simulation = self.simulation
        some = {name: each for name, each in self.designs.items() if each.expands}
        if not some:
            return {}
        about = closed_forms.Expansion.about(
            simulation, [each.cause for each in some.values()],
            frozenset[str]().union(*(each.felt_in for each in some.values())),
            self.nodes, self.plain.factor, self.scale,
        )  # fmt: skip
        return {name: _expanded(about, each) for name, each in some.items()}

    def _emulator(self, cause: Cause) -> Emulator:
        """The emulator of a cause, trained anew where its simulations or its ranges are others."""
        own, box = self.changes[cause.name], self.boxes[cause.name]
        assert own is not None
        known = self._trained.get(cause.name)
        if known is None or known[0] is not own or not np.array_equal(known[1], box):
            known = self._trained[cause.name] = own, box, self._trained_on(cause, own)
        return known[2]

    def _trained_on(self, cause: Cause, own: SimulatedChanges) -> Emulator:
        name = cause.name
        if name in self.designs and not self.designs[name].scales:
            return _by_moduli(
                self.simulation, cause, own, self.boxes[name], self.scale, self.plain.factor,
                self._middle,
            )  # fmt: skip
        degree = POLICY.curved_degree
        if name not in self.designs:
            degree = POLICY.closed_form_places - 1
        elif self.designs[name].straight:
            degree = 1
        own_coordinates = coordinates_of(cause, self.boxes[name])
        return trained_on(own, own_coordinates, self.scale, degree=degree)

    # -- between what was simulated ---------------------------------------------------------------

    def refine(self, some: Set[str], say: Callable[[str], None]) -> None:
        """Simulate causes of one number between places, where emulators miss more than the noise.

        It ends where that does not help: a finger that loses its equilibrium has no smooth curve.

        Args:
            some: names of causes that could be seen.
            say: told what is being done.
        """
        before: dict[str, float] = {}
        for _ in range(POLICY.finer):
            wanted: dict[str, CauseDesign] = {}
            for cause in self.felt:
                name, own, emulator = cause.name, self.changes[cause.name], self._emulator(cause)
                if own is None or name not in some & self.designs.keys():
                    continue
                if own.zeta.shape[1] > 1 or not isinstance(emulator, PolynomialEmulator):
                    continue
                if 1.0 < emulator.left < POLICY.helps * before.get(name, np.inf):
                    before[name] = emulator.left
                    (number,) = cause.numbers
                    zeta = turning(own, float(number.zeta(cause.neutral(number))), self.scale)
                    wanted[name] = _design(self.simulation, cause, self.plain.factor, zeta)
            if not wanted:
                break
            say(f"simulating between, where a change turns at once: {', '.join(sorted(wanted))}")
            for name in self._added(wanted):
                say(f"{name} could not be simulated there: {self.failed.pop(name)}")

    def _added(self, some: Mapping[str, CauseDesign]) -> list[str]:
        """Simulate designs beside those before; return the names of those that did not end."""
        before = {name: self.changes[name] for name in some}
        self.compute(some)
        lost = []
        for name, known in before.items():
            more = self.changes[name]
            self.changes[name] = known.beside(more) if known and more else known
            if more is None:
                lost.append(name)
        return lost

    # -- beyond what was simulated ----------------------------------------------------------------

    def _reach(self, say: Callable[[str], None]) -> None:
        """Simulate farther out causes whose best numbers lie beyond what was simulated."""
        given_up: set[str] = set()
        for _ in range(POLICY.farther):
            wanted = self.beyond(given_up)
            if wanted is None:
                break
            cause, zeta = wanted
            name, own = cause.name, zeta[1:]
            say(f"the best numbers of {name} lie beyond what was simulated; simulating there")
            self.boxes[name], before = _as_far_as(self.boxes[name], own), self.boxes[name]
            if name not in self.designs:
                self.changes[name] = self._closed_form(cause)
                continue
            place = own if self.designs[name].scales else zeta
            there = _design(self.simulation, cause, self.plain.factor, place[None])
            if self._added({name: there}):
                say(f"{name} could not be simulated there: {self.failed.pop(name)}")
                given_up.add(name)
                self.boxes[name] = before

    def beyond(self, given_up: Set[str]) -> tuple[Cause, np.ndarray] | None:
        """Find what may follow the readings best, by itself, beyond where it was simulated.

        It goes on straight there. No discrepancy is beside it, as that would follow in its place.

        Args:
            given_up: causes that could not be simulated farther.

        Returns:
            The cause and its numbers there, the moduli's ζ first, as far out as the readings leave
            them; None where none lies at such an end, or those that do are hopeless.
        """
        problem = self.problem
        alone = one_at_a_time(problem.levels, {}).fits
        best = max(fit.log_evidence + np.log(LEVELS[fit.level] / LEVELS[0.0]) for fit in alone)
        least, nearest = best - POLICY.hopeless, None
        fits = {fit.subset: fit for fit in alone if not fit.level}
        for cause in self.felt:
            name, fit = cause.name, fits.get((cause.name,))
            if fit is None or name in given_up or effect(name).by_slopes:
                continue
            own, before = problem.places((name,))[name], self.boxes[name]
            box = wider(cause, before, fit.zeta[own])
            if box is None:
                continue
            inside = np.vstack([[-np.inf, np.inf], before])
            straight = Straight.of(problem.emulators[name], inside)
            trial = replace(
                problem, emulators={**problem.emulators, name: straight},
                boxes={**problem.boxes, name: box},
            )  # fmt: skip
            found = CovarianceModel(trial, 0.0).of((name,)).fit([fit.zeta])
            out = np.sign(found.zeta[own] - np.clip(found.zeta[own], *before.T))
            if found.log_evidence > least and out.any():
                least = found.log_evidence
                std = np.sqrt(np.diag(np.linalg.inv(found.hessian)))[own]
                there = np.clip(found.zeta[own] + POLICY.visible_sigma * out * std, *box.T)
                nearest = cause, np.r_[found.zeta[0], there]
        return nearest


def _as_far_as(box: np.ndarray, zeta: np.ndarray) -> np.ndarray:
    """Ranges, (d, 2), as wide as a place, (d,), asks for."""
    low, high = box.T
    low = np.where(zeta < low, zeta - POLICY.read_beyond, low)
    return np.column_stack([low, np.where(zeta > high, zeta + POLICY.read_beyond, high)])


def _by_moduli(
    simulation: FingerSimulation,
    cause: Cause,
    simulated: SimulatedChanges,
    box: np.ndarray,
    scale: np.ndarray,
    factor: Unknown,
    middle: float,
) -> Emulator:
    """The emulator of a cause whose simulations the moduli do not scale."""
    by_moduli = Coordinate(lambda zeta: zeta - middle, amplitude=False, rate=1.0)
    own = (by_moduli, *coordinates_of(cause, box, 1))
    moduli = spread(even(middle) + 1.5 * MODEL.beside * np.array([-1.0, 1.0]))
    every = np.vstack([moduli, box])
    approximation = closed_forms.approximate(simulation, cause, every, scale, factor)
    if approximation is None:
        return trained_on(simulated, own, scale)
    return Stacked.of(approximation, trained_on(_without(simulated, approximation), own, scale))


def _scales(simulation: FingerSimulation, cause: Cause) -> bool:
    """Tell whether the moduli scale the model with a cause, too."""
    kind = effect(cause.name)
    remembers = kind.kind in ("dissipative", "loading") or kind.clock
    return simulation.scales and not remembers and cause.name != TILTED


def _design(
    simulation: FingerSimulation, cause: Cause, factor: Unknown, zeta: np.ndarray
) -> CauseDesign:
    """Simulations at places, the moduli's ζ first where these do not scale the cause."""
    scales = _scales(simulation, cause)
    experiments = _felt_in(cause.name, simulation.lab)
    flat = simulation.flat
    variants = []
    for z in zeta:
        c = simulation.centre if scales else float(factor.at(z[0]))
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
    return CauseDesign(cause, zeta, scales, variants)


def _zeta(cause: Cause, middle: float | None) -> np.ndarray:
    """Places of a cause's simulations, evenly spread; the moduli's first where these have one."""
    if effect(cause.name).by_slopes:
        neutral = [number.zeta(cause.neutral(number)) for number in cause.numbers]
        return np.array([neutral if middle is None else [middle, *neutral]])
    reach = POLICY.finger_reach / max(1.0, np.sqrt(len(cause.numbers) / 2))
    box = np.clip(box_of(cause), -reach, reach)
    if middle is not None:
        box = np.vstack([even(middle) + MODEL.beside * np.array([-1.0, 1.0]), box])
    d = len(box)
    count = POLICY.finger_places[min(d, len(POLICY.finger_places)) - 1]
    zeta = _places(box, POLICY.implausible_places if cause.name in IMPLAUSIBLE else count, cause)
    if middle is not None:
        zeta[:, 0] = spread(zeta[:, 0])
    return zeta


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
    signed = coordinates_of(cause, box)[0].signed
    # of either sign both ends count; of a positive amplitude the strong one does
    ends, count = (POLICY.signed_ends, count + 1) if signed else (POLICY.positive_ends, count)
    return np.asarray(low + (high - low) * np.linspace(*ends, count))[:, None]


def _assembled(
    simulation: FingerSimulation,
    design: CauseDesign,
    runs: Sequence[SimulatedReadings],
    nodes: np.ndarray,
    factor: Unknown,
) -> tuple[SimulatedChanges | None, str]:
    """Changes and their derivatives by ζ; None and why where too few simulations ended well."""
    numbers = design.cause.numbers
    felt = simulation.measurement.listed["experiment"].isin(design.felt_in).to_numpy()
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
            whole = float(factor.at(node))
            c = whole / simulation.centre
            # its own moduli are simulated at c, an elastic one is read there
            beside = simulation.centre if design.scales else whole
            by = c if design.scales else 1.0
            y = simulation.read(run, by)
            first: list[np.ndarray] = []
            for key, number, rate in zip(keys, numbers, rates, strict=True):
                per = rate * (beside if number.modulus else 1.0)
                slope = simulation.read(run, by, key) * per
                first.append(slope if key in known else np.full(len(slope), np.nan))
            if not design.scales:
                step = 1e-3
                by_log = run.by_log_modulus(simulation.measurement)
                for key, number, zi in zip(keys, numbers, own, strict=True):
                    if number.modulus:
                        value = float(number.at(zi)) * whole
                        by_log = by_log + simulation.read(run, 1.0, key) * value
                first = [by_log, *first]
            graded, jacobian = simulation.graded(y, whole, np.nan_to_num(np.column_stack(first)))
            base = simulation.graded_at(whole)
            jacobian[:, ~np.isfinite(np.column_stack(first)).all(axis=0)] = np.nan
            if not design.scales:
                ends = factor.at(node + step) / factor.at(node - step)
                log_slope = float(np.log(ends) / (2 * step))
                jacobian[:, 0] = (jacobian[:, 0] - simulation.graded_by_log(whole)) * log_slope
            told.append(np.where(felt, graded - base, 0.0))
            derived.append(np.where(felt, jacobian.T, 0.0))
        change = np.array(told)
        if np.isfinite(change).all():
            kept.append(place)
            values.append(change)
            slopes.append(np.array(derived))
    if kept and design.straight:
        return _tangent(design.zeta[0], slopes[0], at), ""
    least = 1 if len(runs) < 3 else max(2, len(numbers))
    if len(kept) < least:
        why = next((f.why for run in runs for f in run.failures), "no simulation ended")
        return None, why
    return (
        SimulatedChanges(
            design.zeta[kept], np.stack(values, axis=1), np.stack(slopes, axis=1), at
        ), "",
    )  # fmt: skip


def _expanded(about: closed_forms.Expansion, design: CauseDesign) -> SimulatedChanges | None:
    """Changes at a design's first place, or by its derivatives; None where these are not known."""
    cause, neutral = design.cause, design.zeta[0]
    if design.straight:
        rates = np.array([n.slope(z) for n, z in zip(cause.numbers, neutral, strict=True)])
        found = _tangent(neutral, about.slopes(cause) * rates[:, None], about.nodes)
    else:
        found = about.changes(cause, design.first().zeta, design.felt_in)
    return found if np.isfinite(found.values).all() else None


def _tangent(neutral: np.ndarray, slopes: np.ndarray, nodes: np.ndarray | None) -> SimulatedChanges:
    """Changes that are linear in a cause's numbers, by their slopes, (nodes or 1, d, n)."""
    first = int(nodes is None)  # the moduli's
    steps = np.eye(len(neutral))[first:]
    every = np.repeat(slopes[:, None], len(steps), axis=1)
    return SimulatedChanges(neutral + steps, slopes[:, first:], every, nodes)


def _without(simulated: SimulatedChanges, approximation: Emulator) -> SimulatedChanges:
    """Return what simulations change beyond an approximate law."""
    g, dg = approximation.with_slopes(simulated.zeta)
    by_zeta = (approximation.columns @ dg).transpose(0, 2, 1)
    return replace(
        simulated, values=simulated.values - g @ approximation.columns.T,
        slopes=simulated.slopes - by_zeta,
    )  # fmt: skip


def box_of(cause: Cause) -> np.ndarray:
    """Ranges of ζ, as far as a finger is simulated unless readings ask for more, (numbers, 2)."""
    # an instrument needs no simulation
    far = cause.tails if issubclass(effect(cause.name), Displaying) else np.ones(len(cause.numbers))
    reach = POLICY.finger_reach * far[:, None] + POLICY.read_beyond
    return np.clip(cause.box(), -reach, reach)


def wider(cause: Cause, box: np.ndarray, zeta: np.ndarray) -> np.ndarray | None:
    """Ranges as wide as the prior has any weight, where amplitudes lie at an end.

    Args:
        cause: the effect.
        box: ranges of ζ so far, (d, 2).
        zeta: its numbers, (d,).

    Returns:
        The ranges, (d, 2); None where no number lies at an end beyond which its effect is stronger.
    """
    found = box.copy()
    for place, (number, z, ends) in enumerate(zip(cause.numbers, zeta, box, strict=True)):
        far = number.reaching(POLICY.farthest * number.tail)
        for side, (sign, most) in enumerate(((-1.0, far.low), (1.0, far.high))):
            at_end = sign * (z - ends[side]) >= -POLICY.read_beyond
            stronger = sign * (float(number.at(ends[side])) - cause.neutral(number)) > 0
            if number.tail > 1 and at_end and stronger and sign * (most - ends[side]) > 0:
                found[place, side] = most
    return None if np.array_equal(found, box) else found


def coordinates_of(cause: Cause, box: np.ndarray, first: int = 0) -> tuple[Coordinate, ...]:
    """Return the coordinates that a cause's change is a polynomial of.

    Args:
        cause: whose numbers are ζ.
        box: ranges of these, (numbers, 2).
        first: place of the first of them in ζ.
    """
    found: list[Coordinate] = []
    for i, number in enumerate(cause.numbers, first):
        own = replace(_coordinate(cause, number, box[i - first]), of=i)
        found += _sides(own) if effect(cause.name).lopsided and own.amplitude else [own]
    return tuple(found)


def _sides(own: Coordinate) -> list[Coordinate]:
    """An amplitude that changes the readings in different ways to either side."""
    inner = own.value
    return [
        replace(own, value=lambda zeta: np.maximum(inner(zeta), 0.0), rate=None),
        replace(own, value=lambda zeta: np.minimum(inner(zeta), 0.0), rate=None),
    ]


def _coordinate(cause: Cause, number: Unknown, box: np.ndarray) -> Coordinate:
    if not number.amplitude:
        return Coordinate(lambda zeta: 0.5 * zeta, amplitude=False, rate=0.5)
    start, step = cause.start_and_step(number)
    reach = POLICY.finger_reach
    if not number.prior.positive:  # of ordinary size, however far that is
        step *= max(1.0, float(np.abs(box).max()) / (reach + POLICY.read_beyond))

    def value(zeta: np.ndarray) -> np.ndarray:
        return (number.at(zeta) - start) / step

    ends = np.asarray(value(np.array([-reach, reach])))
    straight = not number.prior.positive and not number.prior.least
    rate = float(number.slope(0.0)) / step if straight else None
    return Coordinate(value, amplitude=True, signed=bool(ends.min() < -1e-9), rate=rate)
