"""Linear effects that explain more beside a modulus of their own than the screen can tell.

The screen is linear about the base model's fit, whose modulus may be far from the truth
(:func:`dolfingrip.diagnosis.linear.beside_own_modulus`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from dolfingrip.diagnosis.conclude import Fits
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.screen import Score
from dolfingrip.diagnosis.linear import beside_own_modulus

GAIN: Final = 1.0
"""Log evidence beyond the screen's from which on a tangent did not reach."""


def remodulated(fitter: Fitter, scores: Sequence[Score], none: Hypothesis) -> Fits:
    """Fits of those effects, by their names; no simulation is made.

    Args:
        fitter: of the problem.
        scores: of the effects, in the screen about ``none``.
        none: the base model's fit.
    """
    problem = fitter.problem
    reference = none.log_evidence(problem)
    found: dict[frozenset[str], Hypothesis] = {}
    for score in scores:
        each = fitter.linear(score)
        if each is None or not score.visible:
            continue
        fit = beside_own_modulus(problem, none, score, each)
        if fit.log_evidence(problem) - reference > score.log_evidence + GAIN:
            found[frozenset([score.name])] = fit
    return found
