"""The numbers behind decisions of the rigs, in one policy for each decision."""

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


GRASP_PATH = GraspPath()
