"""An analysis: readings with all that could explain them, and what they do not tell."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from typing import Self

import numpy as np

from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.answer.artefacts import Artefact, possible_artefacts
from dolfingrip.diagnosis.answer.errors import Errors, without_memory
from dolfingrip.diagnosis.answer.specimens import Individual, apart
from dolfingrip.diagnosis.core.blend import Tangents
from dolfingrip.diagnosis.core.covariance import taken
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.core.problem import NONE, InferenceProblem, Subset
from dolfingrip.diagnosis.core.search import ModelPosterior, pursued
from dolfingrip.diagnosis.core.unknown import Cause, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, largest, shows_memory
from dolfingrip.diagnosis.finger import Simulator
from dolfingrip.diagnosis.simulation.point import Point
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.extensions.index import NAMES, effect, fitted_effects
from dolfingrip.extensions.kinds import Elastic


@dataclass(frozen=True, eq=False)
class Analysis:
    """Everything that the inference needs of coupons, or of fingers.

    Attributes:
        problem: readings, simulations and covariance.
        causes: by name.
        errors: what the covariance is made of.
        simulation: of the model.
        unseen: causes that no reading feels.
        failed: why others could not be simulated, by name.
        not_tried: causes that nothing is known of yet.
    """

    problem: InferenceProblem
    causes: dict[str, Cause]
    errors: Errors
    simulation: Simulator
    unseen: Sequence[str]
    failed: Mapping[str, str]
    not_tried: Sequence[str]

    @property
    def closed_form(self) -> bool:
        """Tell whether simulations cost nothing."""
        return self.simulation.closed_form

    @property
    def configured(self) -> np.ndarray:
        """Readings (n,) of the model as configured; NaN where it does not come so far."""
        return self.simulation.configured

    @property
    def measurement(self) -> Measurement:
        """The readings, and how they were taken."""
        return self.simulation.measurement

    @property
    def applied(self) -> Config:
        """Configuration of the first test's set-up; its material is that of all."""
        return self.measurement.tests[0].applied(self.simulation.config)

    @property
    def mesh_errors(self) -> dict[str, float]:
        """Root mean square of what the mesh gets wrong, by channel; empty where it is not known."""
        sizes = self.measurement.rms(self.simulation.mesh)
        return {name: size for name, size in sizes.items() if size}

    def judged_by_shape(self) -> Self:
        """With the causes that have rivals by the shape of what they change.

        An elastic law has others. A cause with memory has any elastic curve, where readings tell
        its shape alone.
        """
        laws = frozenset(
            name for name in self.causes if name in NAMES and issubclass(effect(name), Elastic)
        )
        remembering = told_by_shape(self.causes, self.measurement)
        curves = without_memory(self.measurement, self.errors) if remembering else None
        listed = self.measurement.listed
        problem = replace(
            self.problem, elastic=laws, remembering=remembering, curves=curves,
            largest=largest(listed["value"].to_numpy(), listed["column"].to_numpy()),
        )  # fmt: skip
        return replace(self, problem=problem)

    def specimens_apart(self) -> tuple[tuple[str, ...], float] | None:
        """Find specimens that stand apart from the others, by some of the readings.

        Returns:
            Their names, and ln of the odds that they stand apart; None where none does, or where
            too few specimens could tell.
        """
        errors = self.errors
        if not errors.scatter.estimated:
            return None
        every = Individual(self.measurement, errors.covariance, errors.along, errors.signal)
        alike = errors.covariance - every.apart(errors.scatter.scale, errors.scatter.shape)
        sizes = [artefact.nuisance.change for artefact in errors.artefacts]
        alike += sum(np.outer(change, change) for change in sizes)
        some = np.arange(
            0, len(errors.signal), -(-len(errors.signal) // self.measurement.policy.some_readings)
        )
        return apart(Individual(self.measurement, alike, errors.along, errors.signal, some))

    # -- artefacts of instruments -----------------------------------------------------------------

    def artefacts(self, posterior: ModelPosterior) -> list[Artefact]:
        """Find those that the evidence asks for beside some hypothesis.

        Args:
            posterior: of all hypotheses without them.
        """
        have = {artefact.kind for artefact in self.errors.artefacts}
        along, steep = self.errors.along, self.errors.steep
        every = possible_artefacts(self.measurement, along, steep, have)
        changes = np.array([artefact.nuisance.change for artefact in every])
        columns = changes.reshape(len(every), len(self.errors.noise)).T
        log_prior = np.array([artefact.log_prior for artefact in every])
        of = np.unique([artefact.kind for artefact in every], return_inverse=True)[1]
        return [every[place] for place in pursued(posterior, columns, log_prior, of)]

    def beside(self, artefacts: Sequence[Artefact]) -> Self:
        """Return the analysis of readings that have some artefacts.

        Args:
            artefacts: that the readings have.
        """
        problem, sizes = self.problem, [artefact.nuisance for artefact in artefacts]
        problem = replace(
            problem, always=(*problem.always, *(size.unknown for size in sizes)),
            linear=np.column_stack([problem.linear, *(size.change for size in sizes)]),
        )  # fmt: skip
        errors = replace(self.errors, artefacts=(*self.errors.artefacts, *artefacts))
        return replace(self, errors=errors, problem=problem)

    # -- a fit as a configuration -----------------------------------------------------------------

    def factor(self, fit: MapFit) -> float:
        """Return the factor of all moduli, by those configured."""
        return float(self.problem.factor.at(fit.zeta[0]))

    def numbers(self, fit: MapFit) -> Iterator[tuple[Cause, Unknown, int]]:
        """Iterate over the numbers of a fit's causes: cause, number, and which of ζ it is."""
        for name, places in self.problem.places(fit.subset).items():
            for number, place in zip(self.causes[name].numbers, places, strict=True):
                yield self.causes[name], number, int(place)

    def overrides(self, fit: MapFit) -> Change:
        """Return the change of the configuration to the numbers of a fit."""
        problem, change = self.problem, dict(self.point(fit).change(self.applied))
        for cls in fitted_effects():
            if cls.told.each_time and cls.name() not in fit.subset:
                anew = cls.fitted(self.applied)
                change.pop(anew.key if anew else "", None)
        linear = enumerate(problem.always[problem.simulated_count :], problem.simulated_count)
        for place, number in linear:  # as told, but where they are far off
            if {*number.names} & {*NAMES} & {*fit.subset}:
                change |= number.change(float(number.at(fit.zeta[place])))
        return change

    # -- what is linear ---------------------------------------------------------------------------

    def fitted(self, fit: MapFit) -> np.ndarray:
        """Exact readings (n,) at a fit, with the specimens' own numbers as fitted."""
        exact = self.exact(fit)
        weighed = self.problem.levels[fit.level].weighed(self.problem.value - exact)
        return np.asarray(exact + self.errors.individual @ weighed)

    def nuisances(self, fit: MapFit) -> dict[str, float]:
        """The most probable numbers of the rig at a fit, by their standard deviations."""
        numbers = zip(self.problem.always, map(float, fit.zeta), strict=False)
        return {number.told_as: zeta for number, zeta in numbers}

    # -- exact simulations ------------------------------------------------------------------------

    def exact(self, fit: MapFit) -> np.ndarray:
        """Readings (n,) at a fit's numbers; those that no simulation is of left out."""
        return self.problem.predicted(fit.subset, fit.zeta)

    def free(self, fit: MapFit) -> Point | None:
        """Return a fit's error of an instrument where its other causes were simulated last.

        It follows from that simulation; None where there is none, or where nothing follows.
        """
        here, problem = self.point(fit), self.problem
        names = problem.causes(fit.subset)
        solid = tuple(name for name in names if name not in problem.displaying)
        runs = problem.runs.get(solid or names)
        # in the only simulation of a cause it does nothing
        if solid == names or runs is None or (solid and len(runs.u) < 2):
            return None
        zeta = self._zeta(solid, runs.u[-1])
        of_model = problem.always[: problem.simulated_count]
        ends = np.cumsum([len(problem.numbers[name]) for name in solid])
        there = dict(zip(solid, np.split(zeta[len(of_model) :], ends), strict=False))
        causes = [(cause, there.get(cause.name, at)) for cause, at in here.causes]
        return Point.of(of_model, zeta, causes)

    def _zeta(self, names: Iterable[str], u: np.ndarray) -> np.ndarray:
        """ζ of the model's own numbers and of causes at coordinates, which may have more."""
        numbers = zip(self.problem.simulated(names), u, strict=False)
        return np.array([number.zeta_of(float(at)) for number, at in numbers])

    def simulated(self, fits: Sequence[MapFit], *, free: bool = False) -> list[Tangents | None]:
        """Simulate fits: readings, and derivatives by the coordinates of their numbers.

        An error of an instrument is worked out all over its prior beside each simulation.

        Args:
            fits: the hypotheses.
            free: whether other numbers than those of errors of instruments are where they cost
                nothing.

        Returns:
            None for each that does not reach all readings.
        """
        every, problem = list[list[Point]](), self.problem
        for fit in fits:
            points = [(self.free(fit) if free else None) or self.point(fit)]
            here, anew = points[0], not free or problem.causes(fit.subset) not in problem.runs
            errors = [cause for cause, _ in here.causes if cause.name in problem.displaying]
            for error in errors if len(errors) == 1 and anew else ():
                for u in problem.runs[(error.name,)].u:
                    at = {error.name: self._zeta([error.name], u)[problem.simulated_count :]}
                    causes = tuple((c, at.get(c.name, zeta)) for c, zeta in here.causes)
                    points.append(replace(here, causes=causes))
            every.append(points)
        tangents = iter(self.simulation.at([*chain.from_iterable(every)]))
        return [
            Tangents.stacked(runs) if len(runs) == len(points) else None
            for points in every
            for runs in [[run for run in islice(tangents, len(points)) if run is not None]]
        ]

    def point(self, fit: MapFit) -> Point:
        """The numbers of a fit that a simulation is of."""
        problem = self.problem
        places = problem.places(fit.subset).items()
        causes = [(self.causes[name], fit.zeta[own_places]) for name, own_places in places]
        return Point.of(problem.always[: problem.simulated_count], fit.zeta, causes)

    def expected(
        self, fits: Sequence[MapFit], additions: Sequence[Proposal]
    ) -> list[tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray] | None]:
        """Simulate additions at fits: readings, (m,), and derivatives by ζ, (m, d), of each.

        Args:
            fits: the hypotheses, which are simulated side by side.
            additions: what may be measured, by a rig that is as reported; all on one mesh.

        Returns:
            Of each addition, with the covariance by what no hypothesis fits so far, (m, m); None
            where a hypothesis does not reach all its readings.
        """
        simulated = self.simulation.additions(
            [self.point(fit) for fit in fits],
            [addition.measurement for addition in additions], known_mesh=additions[0].known_mesh,
        )  # fmt: skip
        answers: list[tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray] | None] = []
        for runs, rig in simulated:
            changes = {number.name: number.change for number in rig}
            pairs = zip(fits, runs, strict=True)
            read = [self._expected(fit, run, changes) for fit, run in pairs if run is not None]
            answers.append(None if None in runs else (read, self.unfitted(changes, read[0][0])))
        return answers

    def _expected(
        self, fit: MapFit, tangents: Tangents, changes: Mapping[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Readings of an addition at a fit, and derivatives by ζ."""
        problem, count = self.problem, self.problem.simulated_count
        (columns,) = tangents.told
        numbers = zip(problem.unknowns(fit.subset), fit.zeta, strict=True)
        slopes = np.array([number.coordinate(np.array(zeta))[1] for number, zeta in numbers])
        slopes = np.tile(slopes, (len(columns), 1))
        slopes[:, np.r_[:count, problem.nuisance_count : len(fit.zeta)]] *= columns[:, 1:]
        for place in range(count, problem.nuisance_count):
            slopes[:, place] = changes.get(problem.always[place].told_as, 0.0)
        return columns[:, 0], slopes

    def unfitted(self, changes: Mapping[str, np.ndarray], readings: np.ndarray) -> np.ndarray:
        """Covariance (m, m) of an addition by what no hypothesis fits so far.

        Args:
            changes: of its readings by numbers of the rig, by name, (m,) each.
            readings: (m,) that are expected.
        """
        scatter, fitted = self.errors.scatter, {number.told_as for number in self.problem.always}
        # a new coupon is another specimen
        stiff = max(scatter.scale, scatter.prior_scale) if self.closed_form else 0.0
        others = [change for name, change in changes.items() if name not in fitted]
        every = np.column_stack([stiff * readings, *others])
        return np.asarray(every @ every.T)


def remembers_state(name: str) -> bool:
    """Tell whether a cause is an effect of what was before: a material remembers, a line lags.

    Args:
        name: of the cause.
    """
    return name in NAMES and effect(name).follows_path()


def told_by_shape(causes: Iterable[str], measurement: Measurement) -> frozenset[str]:
    """List causes with memory that readings tell by a shape that something else has, too.

    Along one loading an elastic law has it. Along the loop of a coupon friction in the testing
    machine has it. An elastic law is felt in all experiments. So it is no rival of a cause that one
    of them does not feel, as free bending does not feel a plate's friction.

    Args:
        causes: their names.
        measurement: with the experiments.
    """
    if shows_memory(measurement) and any(test.of_finger for test in measurement.tests):
        return frozenset()
    rigs = [EXPERIMENTS[test.experiment].parts for test in measurement.tests]
    return frozenset(
        name for name in causes if remembers_state(name) and all(map(effect(name).felt_on, rigs))
    )


@dataclass(frozen=True, eq=False)
class Alternative:
    """A cause that follows the readings about as well as none does, other numbers being others.

    Attributes:
        fit: the hypothesis.
        factor: its evidence by that of none, or by the best.
        behind: numbers that take its change over.
        stronger: the same where its cause does one standard deviation more.
    """

    fit: MapFit
    factor: float
    behind: tuple[str, ...]
    stronger: MapFit


def hidden_effects(analysis: Analysis, none: MapFit) -> dict[str, tuple[str, ...]]:
    """List the effects of which less than what counts as visible is seen.

    Args:
        analysis: the readings with all that could explain them.
        none: fit without causes.

    Returns:
        The numbers that take an effect's change over, by its name; none where it is faint by
        itself.
    """
    problem = analysis.problem
    rig = none.zeta[: problem.nuisance_count]
    hidden: dict[str, tuple[str, ...]] = dict.fromkeys(analysis.unseen, ())
    for name, cause in analysis.causes.items():
        zeta = cause.at_strength()
        if problem.strength(name, rig, zeta) < problem.policy.visible:
            _, hidden[name] = _taken(analysis, rig, problem.change(name, rig, zeta))
    return hidden


def _taken(
    analysis: Analysis, rig: np.ndarray, change: np.ndarray
) -> tuple[float, tuple[str, ...]]:
    """Length of a change, (n,), by the noise alone, and the numbers that take most of it over."""
    noise = analysis.errors.noise
    alone = float(np.linalg.norm(change / noise))
    if alone < analysis.problem.policy.visible:
        return alone, ()
    always, columns = analysis.problem.always, analysis.problem.slopes(NONE, rig) / noise[:, None]
    names = [number.names[0] if number.names else number.key for number in always]
    parts = np.abs(taken(change / noise, columns)) * np.linalg.norm(columns, axis=0)
    order = np.argsort(parts)[::-1]
    return alone, tuple(names[i] for i in order if parts[i] >= 0.5 * parts.max())


def alternatives(
    analysis: Analysis, posterior: ModelPosterior, *, off: bool = False
) -> list[Alternative]:
    """List single causes that the readings do not exclude beside none, the likeliest first.

    Prior odds do not count: that none acts needs evidence as strong as that a cause does. A cause
    whose own change could not be seen, whatever else is free, is none of them.

    Args:
        analysis: the readings with all that could explain them.
        posterior: of all hypotheses.
        off: whether something is off, so that the best evidence counts in the place of none's.
    """
    problem, evidence = posterior.problem, _evidence(posterior)
    against = max(evidence.values()) if off else evidence[NONE]
    fits = {(hypothesis.subset, hypothesis.level): hypothesis for hypothesis in posterior.fits}
    possible = []
    for subset, log in evidence.items():
        factor = float(np.exp(log - against))
        if len(subset) != 1 or problem.causes(subset) != subset or factor < 1 / problem.policy.odds:
            continue
        fit, count = fits[subset, 0.0], problem.nuisance_count
        rig = fit.zeta[:count]
        change = problem.change(*subset, rig, fit.zeta[count:])
        more = _room(analysis, fit, change)
        more_of_readings = problem.slopes(subset, fit.zeta)[:, count:] @ more[count:]
        alone, behind = _taken(analysis, rig, change + more_of_readings)
        if alone >= problem.policy.unlikely:
            stronger = replace(fit, zeta=np.clip(fit.zeta + more, *problem.box(fit.subset).T))
            possible.append(Alternative(fit, factor, behind, stronger))
    return sorted(possible, key=lambda other: -other.factor)


def _room(analysis: Analysis, fit: MapFit, change: np.ndarray) -> np.ndarray:
    """The step (d,) of ζ that changes most by a fit's causes, one standard deviation of these.

    Its sign is that of the change so far, (n,); the model's own numbers follow.
    """
    count = analysis.problem.nuisance_count
    slopes = analysis.problem.slopes(fit.subset, fit.zeta)[:, count:]
    covariance = np.linalg.inv(fit.hessian)
    lower = np.linalg.cholesky(covariance[count:, count:])
    white = slopes @ lower / analysis.errors.noise[:, None]
    way = np.linalg.svd(white, full_matrices=False)[2][0]
    step = covariance[:, count:] @ np.linalg.solve(lower.T, way)
    return np.asarray(step if (slopes @ lower @ way) @ change >= 0 else -step)


def _evidence(posterior: ModelPosterior) -> dict[Subset, float]:
    """ln p(y) of each set of causes, by all levels of a discrepancy."""
    logs: dict[Subset, list[float]] = defaultdict(list)
    prior = posterior.problem.policy.levels
    for fit in posterior.fits:
        logs[fit.subset].append(fit.log_evidence + float(np.log(prior[fit.level])))
    return {subset: float(np.logaddexp.reduce(terms)) for subset, terms in logs.items()}
