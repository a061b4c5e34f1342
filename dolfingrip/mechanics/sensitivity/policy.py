"""The numbers that derivatives of states rest on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SensitivityPolicy:
    """How derivatives are taken.

    Attributes:
        change: part of a parameter's scale by which a model is perturbed. The residual of a
            solution is 0 to Newton's tolerance, so that a one-sided difference is good to this
            part, and rounding to 1e-6.
        adjoint_change: likewise for the adjoint, whose differences are of second order. They are of
            two points on one side, since some parameters allow smaller values only.
        along_mm: largest motion of a node along the adjoint state for the derivative by all
            coordinates, a central difference. It is small against the distances of contact; ten
            times smaller, rounding of the contact's part is 1e-5 of a force's derivative.
        corrections: largest number of corrections where terms have lagged quantities, as friction
            has normal forces, whose change the tangent leaves out; each is a solve with the present
            tangent.
        close: part of the first residual's derivative that may be left then.
        stalled: part of a correction's residual from which on the next one gains nothing.
    """

    change: float = 1e-7
    adjoint_change: float = 1e-5
    along_mm: float = 1e-5
    corrections: int = 30
    close: float = 1e-6
    stalled: float = 0.9


SENSITIVITY = SensitivityPolicy()
