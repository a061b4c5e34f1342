"""The numbers that decisions of a model rest on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StepBounds:
    """How far one step of Newton's method may go, whatever the terms allow.

    Attributes:
        kept_jacobian: part of the smallest det F that a step keeps, so that no element inverts.
        shortest: smallest fraction of a step that is tried.
        rigid_mm: largest step of a rigid body's centre, and of its turn at the radius of gyration.
            A linear prediction would throw a nearly free body metres away.
    """

    kept_jacobian: float = 0.1
    shortest: float = 1e-6
    rigid_mm: float = 8.0


STEP_BOUNDS = StepBounds()
