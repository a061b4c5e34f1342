"""Factorisations by MUMPS that get more memory if the estimate was too small."""

from __future__ import annotations

from typing import Final

from petsc4py import PETSc

from dolfingrip.mechanics.newton.policy import WORKSPACE

RELAXATION: Final = "mat_mumps_icntl_14"
"""PETSc's option for MUMPS' ICNTL(14): by how many per cent the workspace exceeds the estimate."""

TOO_SMALL: Final = (-8, -9, -14, -17, -20)
"""INFOG(1) of MUMPS where the integer or real workspace, or a buffer of messages, is too small."""


def set_up(pc: PETSc.PC) -> None:
    """Factorise; if MUMPS' workspace is too small, factorise again with a larger one.

    The estimate does not know delayed pivots, which saddle points have. Rounding decides which ones
    are delayed, and on several ranks the order in which messages arrive does so, too. A
    body of few elements needs twice the estimate then (MUMPS Users' Guide, error -9).

    Args:
        pc: a factorisation by MUMPS with its operators; what it still fails by is its own
            ``getFailedReason``.
    """
    pc.setUp()
    more = WORKSPACE.first_percent
    while more <= WORKSPACE.most_percent and pc.getFactorMatrix().getMumpsInfog(1) in TOO_SMALL:
        operators = pc.getOperators()
        pc.reset()  # PETSc takes no further matrix for factors that ran out of memory once
        pc.setOperators(*operators)
        PETSc.Options(pc.getOptionsPrefix())[RELAXATION] = more
        pc.setUp()
        more *= WORKSPACE.growth
