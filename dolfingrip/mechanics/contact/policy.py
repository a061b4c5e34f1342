"""The numbers behind decisions of contact and friction, in one policy for each decision."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Advance:
    """The bound on the approach of points to a shape in a step of Newton's method.

    Attributes:
        kept: part of its distance that each point keeps in a step.
        pieces: largest number of pieces of a step; each is as long as is safe from the end of the
            last one.
    """

    kept: float = 0.1
    pieces: int = 16


@dataclass(frozen=True, slots=True)
class Nearness:
    """The points that a contact with a shape evaluates, in widths of the barrier.

    Attributes:
        around: distance from a ball around the shape beyond which no point is evaluated: twice that
            of an exact distance, because a sampled distance is only nearly as steep.
        within: distance from the shape up to which its barrier is evaluated; it is 0 from 1 on.
        bounded_cells: distance from a sampled shape's surface, in cells, within which second
            derivatives are bounded.
    """

    around: float = 2.0
    within: float = 1 + 1e-6
    bounded_cells: float = 2.0


@dataclass(frozen=True, slots=True)
class Memory:
    """How friction remembers where points stick.

    Attributes:
        slip_mm: ε: the elastic displacement of a point that sticks is smaller. It is a numerical
            choice and not a property of a material: small compared with the motion of fingers
            (mm), large enough for Newton's method.
        same: relative change of the nodes' normal forces that counts as none: far above that in a
            load step in which nothing happens but Newton's method ending elsewhere within its
            tolerance.
        most_growth: growth of a normal force in a load step up to which a point's memory stays. If
            forces grow less, like those of fingers, it must not fade, or shorter steps would give
            other results.
    """

    slip_mm: float = 0.02
    same: float = 1e-6
    most_growth: float = 10.0


@dataclass(frozen=True, slots=True)
class Pairs:
    """How pairs of a surface with itself are found and differentiated.

    Attributes:
        unaligned: part of an edge's length by which vertices are moved at random, so that no edges
            lie on one line.
        moved: part of the barrier's width by which points move for derivatives that are taken by
            differences.
    """

    unaligned: float = 3e-7
    moved: float = 1e-4


@dataclass(frozen=True, slots=True)
class Closure:
    """The size of the problem whose solution is a force-closure margin.

    Attributes:
        edges: number of edges of the pyramid that replaces a friction cone.
        contacts: number of contacts that are used; they have the largest normal forces.
    """

    edges: int = 8
    contacts: int = 40


ADVANCE, NEARNESS, MEMORY, PAIRS, CLOSURE = Advance(), Nearness(), Memory(), Pairs(), Closure()
