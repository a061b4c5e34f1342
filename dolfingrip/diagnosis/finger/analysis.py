"""An analysis of fingers: emulators of the model and of all causes, and errors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.answer.analysis import Analysis, told_error
from dolfingrip.diagnosis.core.decision import sensitivity
from dolfingrip.diagnosis.core.evidence import MapFit, Subset
from dolfingrip.diagnosis.core.search import ModelPosterior, search
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.model import FingerSimulation, model, not_reached
from dolfingrip.diagnosis.finger.training import CauseTraining
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import base_variant, nuisances
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import simulate
from dolfingrip.diagnosis.simulation.unknowns import WALLS
from dolfingrip.jobs.run import silent


@dataclass(frozen=True, eq=False)
class FingerAnalysis(Analysis[FingerSimulation]):
    """Fingers, coupons beside them, and what could explain their readings."""

    def exact(self, fit: MapFit) -> np.ndarray:
        """(n,) readings by the emulators, which simulations at fits have corrected."""
        return self.problem.predicted(fit.subset, fit.zeta)

    def covariances(
        self, addition: Proposal, readings: np.ndarray
    ) -> tuple[np.ndarray, float | np.ndarray]:
        measurement, mesh = addition.measurement, addition.known_mesh
        other = self.simulation.of(measurement, known_mesh=mesh)
        wanted = base_variant(measurement, other.config)
        (base,) = simulate(measurement, other.config, [wanted], other.workers)
        old = {each.name: each.change for each in self.errors.shared}
        n, m = len(self.problem.value), len(base.readings)
        shared, cross = np.zeros((m, m)), np.zeros((n, m))
        for each in nuisances(measurement, base):
            if each.name in self.fitted_names:
                continue
            change = np.nan_to_num(each.change)
            shared += np.outer(change, change)
            if each.name in old and not each.name.startswith("plate_gap"):  # that is set once more
                cross += np.outer(old[each.name], change)
        return shared, cross

    def verified(
        self, posterior: ModelPosterior, say: Callable[[str], None]
    ) -> tuple[FingerAnalysis, ModelPosterior, float]:
        """Simulate the leading fit; what its emulators missed they learn.

        Where they still promise more than a simulation gives, the causes are as likely as it tells,
        and others lead; so they do where it fails. A fit near to a simulated one is not simulated.

        Args:
            posterior: of all hypotheses.
            say: told what is being done.
        """
        finger, worst, plain = self, float("nan"), posterior
        short: dict[Subset, float] = {}
        known = defaultdict[Subset, list[tuple[MapFit, float]]](list)
        for _ in range(POLICY.simulated_fits):
            fit = _leading(posterior, short)
            causes = finger.problem.causes(fit.subset)
            if (told := told_error(known[causes], fit)) <= POLICY.surer:
                worst = told
                break
            name = " with ".join(causes) or "the model"
            try:
                exact = np.column_stack(finger.simulated(fit))
            except ConfigError as error:
                say(f"a simulation of {name} at its fitted numbers failed: {error}")
                # at these numbers no emulator tells what the readings would be
                short[causes], worst = np.inf, float("nan")
                posterior = plain.weakened(short, finger.problem.causes)
                continue
            worst = finger.emulator_error(fit, exact[:, 0])
            known[causes].append((fit, worst))
            say(
                f"a simulation of {name} at its fitted numbers differs by {worst:.2g} standard "
                "deviations of the noise at most"
            )
            leading = sensitivity(posterior)[0].best
            again, good = causes in short, worst <= 1.0
            ends = good and (again or not finger.problem.causes(leading.subset))
            missing = again and not good
            short[causes] = finger.promised_too_much(fit, exact[:, 0]) if missing else 0.0
            if not ends:
                corrected = finger.problem.corrected([(fit.subset, fit.zeta, exact)])
                finger = replace(finger, problem=corrected)
                plain = search(
                    finger.problem, np.random.default_rng(0), before=plain, changed=[causes]
                )
            posterior = plain.weakened(short, finger.problem.causes)
            if ends:
                break
        if np.isinf([*short.values()]).all():  # nothing could be simulated: the screen's answer
            posterior = plain
        return finger, posterior, worst

    def promised_too_much(self, fit: MapFit, exact: np.ndarray) -> float:
        """Return ln of how much more probable the readings are by the emulators than they are.

        Args:
            fit: the hypothesis.
            exact: its simulated readings, shape (n,).
        """
        rest = self.problem.value[:, None] - np.column_stack([exact, self.exact(fit)])
        true, told = np.square(self.problem.levels[fit.level].whitened(rest)).sum(axis=0)
        return max(0.5 * float(true - told), 0.0)


def _leading(posterior: ModelPosterior, known: Collection[Subset]) -> MapFit:
    """The fit that is to be simulated: of a pair first its stronger cause alone."""
    best = sensitivity(posterior)[0].best
    causes = posterior.problem.causes(best.subset)
    if len(causes) < 2:
        return best
    alone = (max(causes, key=dict(zip(best.subset, best.strengths, strict=True)).__getitem__),)
    return best if alone in known else posterior.best(alone, level=0.0)


def analyse_fingers(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    causes: Sequence[Cause],
    say: Callable[[str], None] = silent,
    *,
    fully: bool = False,
) -> FingerAnalysis:
    """Simulate the model and what causes change, and make emulators of it.

    Args:
        measurement: of fingers, and of coupons beside them.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        causes: that are tried, walls only where these are not fitted in every hypothesis.
        say: told what is being done.
        fully: simulate every cause as far as one that the readings may have.

    Raises:
        ConfigError: one line, where nothing can be simulated.
    """
    simulation, off, plain = model(measurement, config, workers, say)
    causes = [each for each in causes if not (simulation.walls and each.name == WALLS)]
    say(f"simulating what {len(causes)} causes change")
    training = CauseTraining(simulation, causes, plain, off.noise)
    training.run(say, fully=fully)
    return FingerAnalysis(
        training.problem, {each.name: each for each in training.felt}, off, simulation,
        training.unseen, training.failed,
        not_reached=not_reached(
            measurement, simulation.measurement, simulation.base.readings,
            simulation.failures or simulation.base.failures,
        ),
    )  # fmt: skip
