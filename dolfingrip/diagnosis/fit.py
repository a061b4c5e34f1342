"""Nonlinear fits: the modulus and the parameters of effects, with nuisances free.

A fit starts at the best place between the screen's simulations
(:mod:`dolfingrip.diagnosis.surface`) and goes on with simulations on the ungraded mesh. Their
readings are corrected by what grading changes (:mod:`dolfingrip.diagnosis.simulation.mesh_map`). It
ends with one or two on the graded mesh, and begins there where the surface is close to what a
simulation gives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis import contact_shift
from dolfingrip.diagnosis.departure import Departure, by_descent, by_surface
from dolfingrip.diagnosis.descent import Descent, Visited, descend
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.laplace import to_values
from dolfingrip.diagnosis.inference.screen import Score
from dolfingrip.diagnosis.linear import beside_own_modulus, with_linear
from dolfingrip.diagnosis.model import (
    EffectModel,
    FitFailure,
    FreeParameter,
    can_be_fitted,
    free_parameters,
)
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation import meshes
from dolfingrip.diagnosis.simulation.mesh_map import MeshMap
from dolfingrip.diagnosis.simulation.nuisances import WALL
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.diagnosis.step import Evaluate, hypothesis_at, stepped, visit
from dolfingrip.diagnosis.surface import SurfacePoint
from dolfingrip.diagnosis.surfaces import surface_of

MOST_EVALUATIONS: Final = 20
"""Simulations of the whole measurement in a fit; each is one step of the least squares. Most fits
take two to five; what ends earlier than that would be said to explain less than it does."""

SETTLED: Final = 0.01
"""Increase of the log likelihood that is not worth another simulation."""

ROUGH: Final = 1.0
"""The same on the ungraded mesh, as steps on the graded one follow."""

SMALL_STEP: Final = 0.7
"""A step, in standard deviations, along which the readings are linear enough."""

STRAIGHT: Final = 1.5
"""How far all readings together may leave the tangent along the last step, in standard deviations:
about one in the log likelihood."""

BEHIND: Final = 30.0
"""A fit is given up where its log evidence will be this much below that of a known one, …"""

PROMISE: Final = 0.5
"""… and by this part of what the next step promises to gain."""

ROUNDS: Final = 3
"""Times that the error of the mesh is taken anew, for the walls that were found."""

SAME_WALLS: Final = 0.003
"""Relative difference of walls that does not matter to it."""

ANEW: Final = 2
"""Times that the base model is taken anew at the modulus and walls found beside an effect."""


@dataclass
class Fitter:
    """Fits hypotheses to a problem.

    Attributes:
        problem: the readings.
        workers: where simulations are computed and kept.
        say: told what is being done.
        failures: fits that were given up, a sentence each.
    """

    problem: Problem
    workers: Workers
    say: Callable[[str], None]
    failures: list[str] = field(default_factory=list)
    _points: dict[tuple[str, Hypothesis], SurfacePoint | None] = field(default_factory=dict)

    def none(self) -> Hypothesis:
        """The base model, its modulus and walls fitted."""
        base = self.problem.base
        if self.problem.shifts:
            moved = self._model()
            start = contact_shift.start(self.problem)
            return self._fitted((), moved, [start[p.key] for p in moved.parameters])
        model = self._model(base=base.simulated, scales=base.scales)
        if not model.parameters:
            return self._at((), model, np.zeros(0))
        found = self._descend(model.evaluate, model, model.start(), SETTLED)
        return self._at((), model, found.stepped)

    def settled(self) -> Hypothesis:
        """The same, with the error of the mesh for the walls that are found.

        :attr:`problem` has that error from then on.
        """
        none = self.none()
        for _ in range(ROUNDS):
            walls = none.by_key.get(WALL)
            if walls is None or abs(walls - self.problem.walls_at) < SAME_WALLS:
                break
            self.problem = replace(self.problem, walls_at=walls)
            none = self.none()
        return none

    def effects(
        self,
        scores: Sequence[Score],
        fits: Mapping[frozenset[str], Hypothesis],
        best: Hypothesis | None = None,
    ) -> Hypothesis | None:
        """One effect or several; None where no simulation of it succeeds.

        Args:
            scores: of the effects in the screen, which say where to start.
            fits: that are known, by their effects; that without an effect among them.
            best: a fit; one that stays far behind it is given up on the way.
        """
        found = [(score, self._candidate(score.name)) for score in scores]
        config = self._config()
        simulated = [
            (score, each)
            for score, each in found
            if can_be_fitted(each.name, each.overrides[score.shape], config)
        ]
        linear = [pair for pair in found if pair not in simulated]
        names = tuple(score.name for score in scores)
        known = frozenset(score.name for score, _ in simulated)
        if known in fits:
            if not known and len(linear) == 1:
                return beside_own_modulus(self.problem, fits[known], *linear[0])
            return with_linear(self.problem, names, fits[known], linear)
        parameters: list[FreeParameter] = []
        held: list[str] = []
        for score, each in simulated:
            own = free_parameters(each.name, each.overrides[score.shape], config)
            parameters += own
            held += [
                text for text in each.overrides[score.shape]
                if text.partition("=")[0] not in {p.key for p in own}
            ]  # fmt: skip
        model = self._model(effects=parameters, held=held)
        self.say(f"fitting {' with '.join(names)}")
        try:
            alone = [score for score, _ in simulated]
            values = self._start(alone, fits)
            start = [values[p.key] for p in model.parameters]
            hypothesis = self._fitted(names, model, start, best, self._close(alone, fits))
        except FitFailure as failure:
            self.failures.append(f"{' with '.join(names)} could not be fitted: {failure}")
            return None
        return with_linear(self.problem, names, hypothesis, linear) if linear else hypothesis

    def _model(self, **own: Any) -> EffectModel:
        """A model of the problem's readings."""
        problem, base = self.problem, self.problem.base
        return EffectModel(
            base.measurement, base.config, self.workers, problem.scale,
            wall=problem.wall, curves=problem.walls, shifts=problem.shifts, **own,
        )  # fmt: skip

    def linear(self, score: Score) -> Candidate | None:
        """The candidate of an effect that no parameter needs a simulation for; else None."""
        each = self._candidate(score.name)
        if can_be_fitted(each.name, each.overrides[score.shape], self._config()):
            return None
        return each

    def again(self, fit: Hypothesis) -> Hypothesis:
        """A fit for the present problem, a step along its tangent away."""
        return fit if fit.model is None or not fit.parameters else stepped(self.problem, fit)

    def on_surface(self, score: Score, beside: Hypothesis) -> SurfacePoint | None:
        """The best fit between the screen's simulations of an effect; None where it has no numbers.

        Without the effect, modulus and walls may be far from where they are beside it. Where the
        other fit needs no simulation there, its tangent is taken anew.

        Args:
            score: of the effect, in the screen.
            beside: a fit whose parameters are free, too.
        """
        key = score.name, beside
        if key not in self._points:
            self._points[key] = self._searched(score, beside)
        return self._points[key]

    def _searched(self, score: Score, beside: Hypothesis) -> SurfacePoint | None:
        surface = surface_of(self.problem, self._candidate(score.name), score.shape)
        if surface is None:
            return None
        starts = [int(i) for i in np.argsort(score.shape_weights)[::-1]]
        point = surface.best(self.problem, beside, starts)
        model, count = beside.model, len(beside.parameters)
        if model is None or not model.in_closed_form or not count:
            return point
        for _ in range(ANEW):
            place = visit(self.problem, model.evaluate, model, point.zeta[:count])
            about = hypothesis_at(beside.effects, model, place)
            point = surface.best(self.problem, about, starts)
        return point

    def _start(
        self, scores: Sequence[Score], fits: Mapping[frozenset[str], Hypothesis]
    ) -> dict[str, float]:
        """Values to start from: beside the most that is fitted already, on the others' surfaces."""
        names = {score.name for score in scores}
        inside = [key for key in fits if key <= names and fits[key].model is not None]
        beside = fits[max(inside, key=lambda key: fits[key].log_evidence(self.problem))]
        found = dict(beside.by_key)
        for score in scores:
            if score.name in beside.effects:
                continue
            point = self.on_surface(score, beside)
            assert point is not None
            found |= dict(zip((p.key for p in point.parameters), point.values, strict=True))
            zeta = point.zeta[: len(beside.parameters)]
            first = to_values((p.prior for p in beside.parameters), zeta)
            found |= dict(zip((p.key for p in beside.parameters), first, strict=True))
        return found

    def _close(
        self, scores: Sequence[Score], fits: Mapping[frozenset[str], Hypothesis]
    ) -> Departure | None:
        """Of an effect whose surface is nearly what a simulation gives; None where it is not."""
        base = fits[frozenset()].model
        if len(scores) > 1 or base is None or not base.in_closed_form:
            return None
        (score,) = scores
        surface = surface_of(self.problem, self._candidate(score.name), score.shape)
        if surface is None or not surface.close:
            return None
        return by_surface(self.problem, surface, base)

    def _config(self) -> Config:
        tests = self.problem.measurement.tests
        return tests[0].setup.applied(self.problem.base.config)

    def _candidate(self, name: str) -> Candidate:
        return next(each for each in self.problem.base.candidates if each.name == name)

    def _fitted(
        self,
        names: tuple[str, ...],
        model: EffectModel,
        start: Sequence[float],
        best: Hypothesis | None = None,
        close: Departure | None = None,
    ) -> Hypothesis:
        """Least squares on the ungraded mesh where there is one, then steps on the graded one.

        On the graded mesh at once where the start is ``close``: a surface tells how far readings
        leave their tangent from there.
        """
        base = self.problem.base
        flat = meshes.ungraded(self._config())

        def promised(place: Visited, gain: float = 0.0) -> bool:
            """Whether a fit will stay behind."""
            assert best is not None
            here = stepped(self.problem, hypothesis_at(names, model, place))
            behind = best.log_evidence(self.problem) - here.log_evidence(self.problem)
            return behind > max(BEHIND, PROMISE * gain)

        hopeless = promised if best is not None else None
        if not flat or base.plain is None or not base.mesh.size:
            found = self._descend(model.evaluate, model, start, SETTLED, hopeless)
            fit = hypothesis_at(names, model, found.last)
            ended = found.stepped is found.last.zeta
            return fit if ended else stepped(self.problem, fit)
        rough = replace(model, held=(*model.held, *flat), _known={})
        corrected = MeshMap(base.measurement, base.simulated, base.plain)

        def evaluate(values: Sequence[float]) -> tuple[Vector, Matrix]:
            factor = values[0] if self.problem.scale is not None else 1.0
            return corrected.to_graded(*rough.evaluate(values), factor)

        if close is not None:
            at = np.array([p.prior.zeta(v) for p, v in zip(model.parameters, start, strict=True)])
            fit = self._refined(names, model, rough.evaluate, at, close)
            return replace(fit, evaluations=model.count + rough.count)
        found = self._descend(evaluate, model, start, ROUGH, hopeless)
        fit = stepped(self.problem, hypothesis_at(names, model, found.last))
        if not found.hopeless and not (hopeless and promised(found.last)):
            self.say(f"{' with '.join(names) or 'no effect'}: on the graded mesh")
            leaves = by_descent(self.problem, found)
            fit = self._refined(names, model, rough.evaluate, found.stepped, leaves)
        return replace(fit, evaluations=model.count + rough.count)

    def _refined(
        self,
        names: tuple[str, ...],
        model: EffectModel,
        rough: Evaluate,
        start: Vector,
        leaves: Departure,
    ) -> Hypothesis:
        """On the graded mesh: one simulation, and a step along its tangent.

        Where the readings leave the tangent on the way, by what the ungraded mesh tells of it, they
        do so on the graded one, too; a second simulation is for a step that still is large then.
        """
        here = self._at(names, model, start)
        fit = stepped(self.problem, here)
        if self._small(here, fit) or leaves(here, fit) < STRAIGHT:
            return fit
        before, after = (visit(self.problem, rough, model, zeta) for zeta in (here.zeta, fit.zeta))
        moved = replace(
            here, zeta=fit.zeta, readings=here.readings + after.readings - before.readings,
            jacobian=here.jacobian + after.jacobian - before.jacobian, overrides=fit.overrides,
        )  # fmt: skip
        better = stepped(self.problem, moved)
        if self._small(moved, better):
            return better
        return stepped(self.problem, self._at(names, model, better.zeta))

    def _small(self, before: Hypothesis, after: Hypothesis) -> bool:
        step = (after.zeta - before.zeta) / before.std(self.problem)
        return bool(np.abs(step).max() < SMALL_STEP)

    def _descend(
        self,
        evaluate: Evaluate,
        model: EffectModel,
        start: Sequence[float],
        settled: float,
        hopeless: Callable[[Visited, float], bool] | None = None,
    ) -> Descent:
        def kept(values: Sequence[float]) -> tuple[Vector, Matrix]:
            readings, slopes = evaluate(values)
            return self.problem.take(readings), slopes[self.problem.kept]

        return descend(
            kept, model.parameters, self.problem.value, self.problem.covariance, start, settled,
            MOST_EVALUATIONS, hopeless, STRAIGHT if settled >= ROUGH else 0.0,
        )  # fmt: skip

    def _at(self, names: tuple[str, ...], model: EffectModel, zeta: Vector) -> Hypothesis:
        """The hypothesis at given parameters."""
        return hypothesis_at(names, model, visit(self.problem, model.evaluate, model, zeta))
