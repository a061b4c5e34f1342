"""Which further experiment would tell tied causes apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.additions.worth import Comparison, Tied, tied
from dolfingrip.diagnosis.core.case import Case
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.files.diagnosis import NextExperiment

Then = tuple[Sequence[Tied], np.ndarray, float | np.ndarray, bool | np.ndarray]
"""What :meth:`Comparison.worth` asks of an addition: each hypothesis at its readings, covariances,
and which pairs do not show there what they differ in."""


def next_experiments(
    posterior: Posterior,
    decision: Decision,
    measurement: Measurement,
    config: Config,
    noise: np.ndarray,
    then: Callable[[Proposal, Sequence[Fit]], Then],
    say: Callable[[str], None],
) -> tuple[list[NextExperiment], list[str]]:
    """Additions that tell the tied hypotheses apart, the best first, and why some failed.

    Nothing where no other hypothesis is tied with the leading one.

    Args:
        posterior: of all hypotheses.
        decision: the answer.
        measurement: so far.
        config: the model that is diagnosed.
        noise: of the readings so far, shape (n,).
        then: of an addition, with the tied hypotheses; it may raise a ``ConfigError``.
        say: told what is being done.
    """
    likely = tied(posterior, decision)
    if len(likely) < 2:
        return [], []
    fits = [fit for _, fit in likely]
    comparison = Comparison(
        measurement, noise, posterior.case.covariance, np.array([p for p, _ in likely]),
        [_here(posterior.case, fit) for fit in fits],
    )  # fmt: skip
    found, failed = [], []
    for proposal in proposals(measurement, config):
        say(f"next experiment: {proposal.name}")
        try:
            after, shared, cross, unseen = then(proposal, fits)
        except ConfigError as error:
            failed.append(f"{proposal.name} could not be judged: {error}")
            continue
        if not all(np.isfinite(each.slopes).all() for each in after):
            failed.append(
                f"{proposal.name} could not be judged: a likely law has no equilibrium there"
            )
            continue
        found.append(comparison.worth(proposal, after, shared, cross, unseen))
    return sorted(found, key=lambda worth: worth.rank), failed


def _here(case: Case, fit: Fit) -> Tied:
    """A hypothesis at the readings so far."""
    told = case.predicted(fit.subset, fit.zeta)
    return Tied(fit.zeta, told, case.slopes(fit.subset, fit.zeta))
