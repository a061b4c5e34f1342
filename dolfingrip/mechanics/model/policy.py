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


@dataclass(frozen=True, slots=True)
class CompilationPolicy:
    """When compiles tell how they go on, and how long they wait for one another.

    Attributes:
        silent_s: time after which a compile, or a wait, tells that it goes on.
        every_s: time from one such message to the next.
        line_s: time from one line to the next where nobody but the standard error listens.
        poll_s: time between two attempts to get the lock.
        patience_s: longest wait for a process that compiles the same; it may be suspended.
    """

    silent_s: float = 2.0
    every_s: float = 1.0
    line_s: float = 30.0
    poll_s: float = 0.05
    patience_s: float = 600.0


STEP_BOUNDS, COMPILATION = StepBounds(), CompilationPolicy()
