"""The meaning of a load path's failure in an experiment, in words of the configuration."""

from __future__ import annotations

from dataclasses import replace

from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.mechanics.path.failure import Failure, FailureKind

WORDS = {
    FailureKind.INVERTED_ELEMENT: (
        "an element turned inside out; refine the mesh or lower the {quantity}"
    ),
    FailureKind.CONTACT: (
        "contact kept Newton's steps short; widen contact.barrier_mm or lower its stiffness"
    ),
    FailureKind.LIMIT_POINT: (
        "the {specimen} goes soft here (its stiffness vanishes): {quantity} control cannot follow "
        "it"
    ),
    FailureKind.ITERATION_LIMIT: "Newton's method did not converge within solver.max_iterations",
    FailureKind.TIME_LIMIT: "solver.time_limit_s is over",
}


def explained(failure: Failure, rig: Rig) -> Failure:
    """The failure with its meaning for the rig's specimen and with the rig's advice."""
    words = WORDS[failure.kind].format(specimen=rig.specimen_name, quantity=rig.quantity)
    return replace(failure, words=words, advice=rig.advice(failure))
