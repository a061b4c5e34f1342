"""The numbers that a descent by gradients rests on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DescentPolicy:
    """How steps are chosen and judged. Variables are scaled to their ranges, 0 to 1.

    Attributes:
        largest_radius, least_radius: of the box around a design in which the model is
            trusted.
        failed, rejected: factor of the radius after a solve that failed, and after a step that did
            not improve.
        good, poor: ratio of a gain to the expected one above which the radius grows twofold, and
            below which it halves.
        enough: expected gain, as a part of the objective, below which a descent ends.
        broken: part of a limit's size by which a simulated limit may be exceeded.
        kept: part of its size by which a limit of the unloaded shape may be.
        corrections: largest number of times that limits of the shape are linearised anew for one
            step.
        aimed, nearest: the same where no simulated limit is held, and further ones in which the
            nearest step within the limits is sought: the best one may jump from one to another.
        shorter: factor of the step that the nearest one is sought to; no step at all keeps them.
        least_cell_quality: which every cell of the mesh keeps: its scaled Jacobian, and half of it
            its edges, by those at the start.
        near_cell_quality: cells within this of it are among the limits of a step.
        near_mm: walls and gaps within this distance of their limit are among the limits of a step.
        most_rows: largest number of pairs of faces among them at first.
        bundle: number of earlier designs whose simulated limits, made linear there, count too.
        penalty: price of breaking a limit in a step's model, in sizes of the objective.
        ridge: of the mean curvature of a sum of squares, added in every direction: what its parts
            do not tell has some.
        digits: decimals of a scaled variable; its value has two fewer. So a run that goes on
            computes the same designs.
    """

    largest_radius: float = 1.0
    least_radius: float = 1e-3
    failed: float = 0.4
    rejected: float = 0.5
    good: float = 0.7
    poor: float = 0.25
    enough: float = 2e-4
    broken: float = 1e-4
    kept: float = 1e-6
    corrections: int = 8
    aimed: int = 8
    nearest: int = 11
    shorter: float = 0.9
    least_cell_quality: float = 0.15
    near_cell_quality: float = 0.5
    near_mm: float = 1.5
    most_rows: int = 400
    bundle: int = 8
    penalty: float = 20.0
    ridge: float = 1e-4
    digits: int = 12
