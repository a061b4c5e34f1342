"""Which specimens stand apart from the others: the evidence of all readings, with them and without.

A specimen that stands apart has a curve of its own, up to a tenth of the signal away from the
others'. The curve that the others share is taken out first, so that no hypothesis about it matters
(restricted likelihood, as where their scatter is estimated).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy.special import logsumexp

from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.errors import Individual
from dolfingrip.diagnosis.policy import ADDITIONS, POLICY


@dataclass(frozen=True, slots=True)
class Apart:
    """Specimens that stand apart.

    Attributes:
        names: of them.
        log_odds: ln of the odds that they do, and no others.
    """

    names: tuple[str, ...]
    log_odds: float

    @property
    def sentence(self) -> str:
        """Statement that they do, with the odds."""
        who = f"specimen {self.names[0]} stands" if len(self.names) == 1 else (
            f"specimens {' and '.join(self.names)} stand"
        )  # fmt: skip
        odds = np.exp(min(self.log_odds, 99.0))
        return f"{who} apart from the others (odds {odds:.2g} to 1)"


def apart(analysis: Analysis[Any]) -> Apart | None:
    """Find the specimens whose readings are far likelier apart from those of the others.

    Args:
        analysis: readings of specimens, of which two may stand apart where there are four.

    Returns:
        None where none does, or where too few specimens could tell.
    """
    if not analysis.errors.scatter.estimated:
        return None
    some = np.arange(0, len(analysis.problem.value), -(-len(analysis.problem.value) // POLICY.some))
    own = Individual.of(analysis.measurement, analysis.errors, some)
    names = sorted(set(own.specimen))
    # two at least share a curve; which two, four specimens tell where the others differ
    log = {
        each: own.evidence(each) + len(each) * float(np.log(POLICY.implausible_odds))
        for count in range(min(POLICY.apart, len(names) - 2) + 1)
        for each in combinations(names, count)
    }
    best = max(log, key=log.__getitem__)
    rest = [value for each, value in log.items() if each != best]
    found = Apart(best, log[best] - float(logsumexp(rest)) if rest else 0.0)
    return found if best and found.log_odds > ADDITIONS.tied else None
