"""The numbers behind decisions of the rigs, in one policy for each decision."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class GraspPath:
    """The numbers with which a gripper and its food are solved, step by step in time.

    Attributes:
        guess_residual_ratio: pairs in contact make a predicted state a bad start, so its residual
            must be half of that of the step's start or less. If twice is allowed, more steps around
            a large potato fail.
        shortest, patience: as :class:`~dolfingrip.mechanics.newton.policy.StepPolicy` has them: a
            step that a bound cuts so short, as where the food is first touched, goes astray, and
            half a step in time is easy.
        lag_tolerance: largest change of the nodes' normal forces, relative to their sum, that
            friction's forces may lag behind by. Each step updates them, so the next step has it.
        close: part of the residual that a step may leave. With 1e-4 a grasp solves nearly twice as
            often with the factors and takes as many iterations.
        settling_s: time before the first stop, in which fingers and food come to rest.
        restraint_mm: see :class:`~dolfingrip.mechanics.model.rigid_body.RigidMotion`.
    """

    guess_residual_ratio: float = 0.5
    shortest: float = 0.05
    patience: int = 0
    lag_tolerance: float = 0.05
    close: float = 1e-2
    settling_s: float = 0.1
    restraint_mm: float = 1.0


GRASP_PATH = GraspPath()
