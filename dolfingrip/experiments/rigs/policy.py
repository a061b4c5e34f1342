"""The numbers that decisions of the rigs rest on, those of each decision together."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class GraspPath:
    """How a gripper with its food is solved for, step by step in time.

    Attributes:
        guess_residual_ratio: 0: no state is predicted, as pairs in contact make it a bad start.
            With twice the residual of a step's start allowed, steps around a large potato fail
            that do not without; a cube's take somewhat fewer iterations.
        lag_tolerance: change of the nodes' normal forces, relative to their sum, that friction's
            may be behind by. Each step takes them anew: what one lags behind, the next has.
        close: part of the residual that a step may leave: with 1e-4 a grasp solves with the factors
            nearly twice as often for as many iterations.
        settling_s: time before the first stop, in which fingers and food come to rest.
        restraint_mm: see :class:`~dolfingrip.mechanics.model.rigid_body.RigidMotion`.
    """

    guess_residual_ratio: float = 0.0
    lag_tolerance: float = 0.05
    close: float = 1e-2
    settling_s: float = 0.1
    restraint_mm: float = 1.0


@dataclass(frozen=True, slots=True)
class FoodShape:
    """How finely the shape of food is represented, and how it may be put down.

    Attributes:
        margin_cells: cells of a sampled distance beyond the shape: what the grid's end disturbs is
            not felt.
        divisions: points of a skin along half of a body.
        least_spacing_mm: least distance of these points.
        largest_spacing_mm: largest distance of these points.
        tipped_deg: how far a body that does not lie still as it is drawn may turn to where it does.
        even_mm: difference of a shape from its mirror image that is not felt: a part of the
            barrier's width.
    """

    margin_cells: float = 4.0
    divisions: int = 15
    least_spacing_mm: float = 1.0
    largest_spacing_mm: float = 4.0
    tipped_deg: float = 40.0
    even_mm: float = 0.01


GRASP_PATH, FOOD_SHAPE = GraspPath(), FoodShape()
