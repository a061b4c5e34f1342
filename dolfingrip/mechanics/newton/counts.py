"""Counts that the solvers of one run share."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Counts:
    """Counts since the start of a run.

    Attributes:
        iterations: Newton iterations, also those of failed solves.
        factorisations: factorisations of tangents.
        damped: number of damped solves that converged.
    """

    iterations: int = 0
    factorisations: int = 0
    damped: int = 0
