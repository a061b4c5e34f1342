"""Natural frequencies of small vibrations about a model's present state."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc
from scipy.sparse.linalg import LinearOperator, eigsh

from dolfingrip.mechanics.newton.newton import Newton


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
