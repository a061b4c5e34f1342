"""A function of two numbers with its first and second derivatives, carried through arithmetic.

UFL can differentiate any expression. But its derivatives take minutes to sort and to compile if
each value enters the next one twice, as in repeated squaring. Here each operation makes six
expressions, and each of them once. UFL is given the result as a function whose derivatives are
known, which :mod:`dolfingrip.forms.chain_rule` then uses. The parts may also be numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ufl.core.expr import Expr


@dataclass(frozen=True, slots=True)
class Jet:
    """A function f of x and y with its first and second derivatives.

    Attributes:
        f: value.
        x, y: first derivatives.
        xx, xy, yy: second derivatives.
    """

    f: Expr
    x: Expr
    y: Expr
    xx: Expr
    xy: Expr
    yy: Expr

    def __add__(self, other: Jet | float) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.f + other, self.x, self.y, self.xx, self.xy, self.yy)
        return Jet(*(a + b for a, b in zip(self.parts(), other.parts(), strict=True)))

    __radd__ = __add__

    def __sub__(self, other: Jet | float) -> Jet:
        if not isinstance(other, Jet):
            return self + -1 * other
        return Jet(*(a - b for a, b in zip(self.parts(), other.parts(), strict=True)))

    def __mul__(self, other: Jet | Expr | float) -> Jet:
        if not isinstance(other, Jet):
            return Jet(*(other * part for part in self.parts()))
        f, g = self, other
        return Jet(
            f.f * g.f,
            f.x * g.f + f.f * g.x,
            f.y * g.f + f.f * g.y,
            f.xx * g.f + 2 * (f.x * g.x) + f.f * g.xx,
            f.xy * g.f + f.x * g.y + f.y * g.x + f.f * g.xy,
            f.yy * g.f + 2 * (f.y * g.y) + f.f * g.yy,
        )

    __rmul__ = __mul__

    def parts(self) -> tuple[Expr, ...]:
        """Value, first and second derivatives."""
        return self.f, self.x, self.y, self.xx, self.xy, self.yy

    def of(self, a: Jet, b: Jet) -> Jet:
        """This function at x = a, y = b, as a function of the variables of a and b.

        Example:
            f = xy at x = y = t, a function of t and another number: t², here at t = 3.

            >>> t = Jet(3.0, 1.0, 0.0, 0.0, 0.0, 0.0)
            >>> Jet(9.0, 3.0, 3.0, 0.0, 1.0, 0.0).of(t, t).parts()
            (9.0, 6.0, 0.0, 2.0, 0.0, 0.0)
        """

        def second(m: tuple[Expr, Expr], n: tuple[Expr, Expr], mn: tuple[Expr, Expr]) -> Expr:
            mixed = m[0] * n[1] + m[1] * n[0]
            bent = self.xx * (m[0] * n[0]) + self.xy * mixed + self.yy * (m[1] * n[1])
            return bent + self.x * mn[0] + self.y * mn[1]

        x, y = (a.x, b.x), (a.y, b.y)
        return Jet(
            self.f,
            self.x * a.x + self.y * b.x,
            self.x * a.y + self.y * b.y,
            second(x, x, (a.xx, b.xx)),
            second(x, y, (a.xy, b.xy)),
            second(y, y, (a.yy, b.yy)),
        )

    def through(self, value: Expr, slope: Expr, bend: Expr) -> Jet:
        """A function of this one, by its value and its derivatives there.

        Example:
            t² at t = 3.

            >>> Jet(3.0, 1.0, 0.0, 0.0, 0.0, 0.0).through(9.0, 6.0, 2.0).parts()
            (9.0, 6.0, 0.0, 2.0, 0.0, 0.0)
        """
        return Jet(value, slope, 0.0, bend, 0.0, 0.0).of(self, constant(0.0))


def constant(value: Expr) -> Jet:
    """Jet of a constant.

    Args:
        value: a number or an expression.

    Returns:
        The value with derivatives of 0.
    """
    return Jet(value, 0.0, 0.0, 0.0, 0.0, 0.0)


def variables(x: Expr, y: Expr) -> tuple[Jet, Jet]:
    """The two variables themselves, as functions of x and y."""
    return Jet(x, 1.0, 0.0, 0.0, 0.0, 0.0), Jet(y, 0.0, 1.0, 0.0, 0.0, 0.0)


def series(terms: Mapping[tuple[int, int], float], x: Jet, y: Jet) -> Jet:
    """Σ c xⁱ yʲ by Horner's rule, first in x, then in y; c may be UFL expressions.

    Args:
        terms: c by (i, j).
        x, y: bases of the powers.

    Example:
        1 + 2 xy² at x = 3, y = 2; by y it is 4 xy.

        >>> p = series({(0, 0): 1.0, (1, 2): 2.0}, *variables(3.0, 2.0))
        >>> p.f, p.y
        (25.0, 24.0)
    """
    rows = {j: {i: constant(c) for (i, k), c in terms.items() if k == j} for _, j in terms}
    return _horner({j: _horner(row, x) for j, row in rows.items()}, y)


def _horner(factors: Mapping[int, Jet], z: Jet) -> Jet:
    highest = max(factors)
    total = factors[highest]
    for power in range(highest - 1, -1, -1):
        total = z * total
        if power in factors:
            total = total + factors[power]
    return total
