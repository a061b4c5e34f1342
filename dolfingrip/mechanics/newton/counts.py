"""What solvers of one run count."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Counts:
    """Counts since the start of a run.

    Attributes:
        iterations: Newton iterations, those of failed solves included.
        factorisations: of tangents.
        damped: damped solves that converged.
    """

    iterations: int = 0
    factorisations: int = 0
    damped: int = 0
