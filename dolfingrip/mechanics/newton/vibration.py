"""Natural frequencies of small vibrations about a model's present state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from petsc4py import PETSc
from scipy.sparse.linalg import LinearOperator, eigsh

from dolfingrip.mechanics.model.state import History
from dolfingrip.mechanics.newton.newton import Newton


def complex_frequencies(
    newton: Newton, mass: PETSc.Mat, count: int, history: History, times_s: Sequence[float]
) -> np.ndarray:
    """Lowest complex frequencies s (1/s) of a solid with Maxwell branches: motions exp(s t).

    For a mode of mass 1 the stiffness is k(s) = k∞ + Σ kᵢ sτᵢ/(1 + sτᵢ), and s² + k(s) = 0. A load
    step of length h from a relaxed state has the stiffness k∞ + Σ kᵢ (1 − exp(−x))/x, x = h/τᵢ;
    the natural frequencies for h = 0 and h = τᵢ tell k∞ and kᵢ. It is exact where the modes' shapes
    do not depend on h, as where all branches are in proportion to the elastic solid.

    Args:
        newton: solver of the model, whose state is at rest.
        mass: as in :func:`natural_frequencies_Hz`.
        count: number of frequencies.
        history: internal variables of the model, which has the length of the load step.
        times_s: τᵢ of all branches; none where the material is elastic.

    Returns:
        (count,) with positive imaginary parts, in the order of the natural frequencies for h = 0;
        NaN for a motion that the state is unstable against.
    """
    tau = np.unique(np.asarray(times_s, dtype=float))
    now_s, weights, squares = float(history.time_s.value), [], []
    try:
        for step_s in (0.0, *tau):
            history.set_time(now_s, step_s)
            x = step_s / tau
            weights.append([1.0, *np.divide(-np.expm1(-x), x, out=np.ones_like(x), where=x > 0)])
            squares.append((2 * np.pi * natural_frequencies_Hz(newton, mass, count)) ** 2)
    finally:
        history.set_time(now_s, 0.0)
    stiffnesses = np.linalg.lstsq(np.array(weights), np.array(squares), rcond=None)[0].T
    return np.array([_swing(k[0], k[1:], tau) for k in stiffnesses])


def _swing(relaxed: float, branches: np.ndarray, tau: np.ndarray) -> complex:
    """The root s of s² + k∞ + Σ kᵢ sτᵢ/(1 + sτᵢ) that swings."""
    if not np.isfinite(relaxed):
        return complex(np.nan, np.nan)
    # the branches' strains are unknowns, too: s qᵢ = s x − qᵢ/τᵢ
    size = 2 + len(tau)
    matrix = np.zeros((size, size))
    matrix[0, 1] = 1.0
    matrix[1, 0], matrix[1, 2:] = -relaxed, -branches
    matrix[2:, 1] = 1.0
    matrix[2:, 2:] = -np.diag(1 / tau)
    roots = np.linalg.eigvals(matrix)
    return complex(roots[np.argmax(roots.imag)])


def natural_frequencies_Hz(newton: Newton, mass: PETSc.Mat, count: int) -> np.ndarray:
    """Lowest natural frequencies: K φ = ω² M φ with the tangent K at the present state.

    Lanczos' method finds the largest eigenvalues of K⁻¹ M. All ranks work on the whole vectors,
    and each adds its rows.

    Args:
        newton: solver of the model, which has K⁻¹.
        mass: M of the displacement (t), without regard to supports.
        count: number of frequencies.

    Returns:
        (count,) in ascending order; NaN for a motion that the state is unstable against.
    """
    comm, free = newton.model.comm, newton.model.free
    # SciPy's solver refers to itself: it would keep the model until a search for cycles
    lent = [newton.linear()]
    sizes = comm.allgather(len(free))
    mine = slice(sum(sizes[: comm.rank]), sum(sizes[: comm.rank + 1]))
    x, y = mass.createVecs()

    def gathered(local: np.ndarray) -> np.ndarray:
        return np.concatenate(comm.allgather(local))

    def weighed(vector: np.ndarray) -> np.ndarray:
        local = free * vector.ravel()[mine]
        x.array[:] = local[: x.local_size]
        mass.mult(x, y)
        weighted = np.zeros_like(local)
        weighted[: y.local_size] = y.array_r
        return gathered(free * weighted)

    def solved(vector: np.ndarray) -> np.ndarray:
        return gathered(lent[0](vector.ravel()[mine].copy()))

    shape = (sum(sizes), sum(sizes))
    m, k = (LinearOperator(shape, product, dtype=float) for product in (weighed, solved))
    start = solved(weighed(np.random.default_rng(0).uniform(-1, 1, shape[0])))
    try:
        squares = eigsh(m, count, m, sigma=0.0, OPinv=k, v0=start, return_eigenvectors=False)
    finally:
        lent.clear()
    with np.errstate(invalid="ignore"):  # the root of a negative number is NaN
        return np.asarray(np.sqrt(np.sort(squares)) / (2 * np.pi))
