"""Cholesky factors in single and double precision: a binding of SuiteSparse's CHOLMOD.

PETSc has CHOLMOD's factors in double precision alone. The binding is compiled once for each cache
of forms and version of CHOLMOD. The names are those of CHOLMOD's header (Chen, Davis, Hager &
Rajamanickam, ACM Trans. Math. Softw. 35, 2008; SuiteSparse 7.10, CHOLMOD User Guide).
"""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import os
import sys
import weakref
from functools import cache
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from typing import Any, NamedTuple

import cffi
import numpy as np

from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.compilation import CompilationError, compiled

PLACES = (sys.prefix, os.environ.get("CONDA_PREFIX", ""), "/usr", "/usr/local", "/opt/homebrew")
"""Where a header may be, below ``include``: of this Python, of conda, a system's, Homebrew's."""

DECLARATIONS = """
#define CHOLMOD_INT ...
#define CHOLMOD_PATTERN ...
#define CHOLMOD_REAL ...
#define CHOLMOD_SINGLE ...
#define CHOLMOD_DOUBLE ...
#define CHOLMOD_SUPERNODAL ...
#define CHOLMOD_GIVEN ...
#define CHOLMOD_AMD ...
#define CHOLMOD_METIS ...
#define CHOLMOD_A ...
#define CHOLMOD_OK ...
struct cholmod_method_struct { int ordering; ...; };
typedef struct {
    int print, supernodal, quick_return_if_not_posdef, nmethods, status;
    double fl, lnz;
    struct cholmod_method_struct method[...];
    ...;
} cholmod_common;
typedef struct {
    size_t nrow, ncol, nzmax;
    void *p, *i, *x;
    int stype, itype, xtype, dtype, sorted, packed;
    ...;
} cholmod_sparse;
typedef struct { size_t nrow, ncol, nzmax, d; void *x; int xtype, dtype; ...; } cholmod_dense;
typedef struct { void *Perm; ...; } cholmod_factor;
int cholmod_start(cholmod_common *);
int cholmod_finish(cholmod_common *);
cholmod_factor *cholmod_analyze(cholmod_sparse *, cholmod_common *);
cholmod_factor *cholmod_analyze_p(cholmod_sparse *, int32_t *, int32_t *, size_t, cholmod_common *);
int cholmod_factorize(cholmod_sparse *, cholmod_factor *, cholmod_common *);
int cholmod_solve2(int, cholmod_factor *, cholmod_dense *, cholmod_sparse *, cholmod_dense **,
    cholmod_sparse **, cholmod_dense **, cholmod_dense **, cholmod_common *);
int cholmod_free_factor(cholmod_factor **, cholmod_common *);
int cholmod_free_dense(cholmod_dense **, cholmod_common *);
"""


class CholmodFactors:
    """Factors of symmetric definite matrices of one pattern.

    Args:
        starts: (n + 1,) int32, where each column of the lower triangle starts.
        rows: rows of its entries, int32, rising in each column.
        order: (n,) int32, the unknowns in the order of their elimination.
        dtype: float32 or float64.

    Attributes:
        values: of the entries, of this type. Set them before :meth:`factorise`.
        free: frees the factors, which nobody may use then.

    Raises:
        MemoryError: if the factors are too large.
    """

    def __init__(
        self, starts: np.ndarray, rows: np.ndarray, order: np.ndarray, dtype: type[np.floating[Any]]
    ) -> None:
        ffi, lib = _binding()
        self.values = np.zeros(len(rows), dtype=dtype)
        self._pattern = starts, rows
        self._matrix = _sparse(starts, rows, self.values)
        self._common = common = _common()
        common.nmethods = 1
        common.method[0].ordering = lib.CHOLMOD_GIVEN
        given = ffi.from_buffer("int32_t[]", order)
        factor = lib.cholmod_analyze_p(self._matrix, given, ffi.NULL, 0, common)
        self._factor = ffi.new("cholmod_factor **", factor)
        self._work = [ffi.new("cholmod_dense **") for _ in range(3)]
        self.free = weakref.finalize(self, _free, common, self._factor, self._work)
        if common.status != lib.CHOLMOD_OK:
            raise MemoryError(f"CHOLMOD: no analysis (status {common.status})")

    def factorise(self) -> bool:
        """Factorise the matrix with these values; return whether it is definite."""
        _, lib = _binding()
        lib.cholmod_factorize(self._matrix, self._factor[0], self._common)
        return bool(self._common.status == lib.CHOLMOD_OK)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solutions for (n, k) right-hand sides, overwritten by the next ones, (n, k)."""
        ffi, lib = _binding()
        given = np.asfortranarray(right, dtype=self.values.dtype)
        size, count = given.shape
        dense = ffi.new("cholmod_dense *", {
            "nrow": size, "ncol": count, "nzmax": given.size, "d": size,
            "x": ffi.cast("void *", given.ctypes.data),
            "xtype": lib.CHOLMOD_REAL, "dtype": self._matrix.dtype,
        })  # fmt: skip
        solution, *work = self._work
        done = lib.cholmod_solve2(
            lib.CHOLMOD_A, self._factor[0], dense, ffi.NULL, solution, ffi.NULL, *work, self._common
        )
        if not done:
            raise MemoryError(f"CHOLMOD: no solution (status {self._common.status})")
        values = np.frombuffer(ffi.buffer(solution[0].x, given.nbytes), dtype=given.dtype)
        return values.reshape((size, count), order="F")


class Elimination(NamedTuple):
    """How blocks of 3 are eliminated.

    Attributes:
        order: (n,) int32, the blocks in the order of their elimination.
        entries: blocks of the factors.
    """

    order: np.ndarray
    entries: float


def elimination(starts: np.ndarray, rows: np.ndarray) -> Elimination:
    """The order in which blocks of 3 are eliminated, by minimum degree or nested dissection.

    As CHOLMOD does it with scalars, dissection is tried where the factors would have more than 500
    operations an entry.

    Args:
        starts: (n + 1,) int32, where each column of the lower triangle of blocks starts.
        rows: rows of its blocks, int32, rising in each column.
    """
    ffi, lib = _binding()
    common = _common()
    common.method[0].ordering, common.method[1].ordering = lib.CHOLMOD_AMD, lib.CHOLMOD_METIS
    matrix, factor = _sparse(starts, rows, None), ffi.new("cholmod_factor **")
    for common.nmethods in (1, 2):
        lib.cholmod_free_factor(factor, common)
        factor[0] = lib.cholmod_analyze(matrix, common)
        if 3 * common.fl < 500 * common.lnz:
            break
    count = len(starts) - 1
    order = np.frombuffer(ffi.buffer(factor[0].Perm, 4 * count), dtype=np.int32).copy()
    chosen = Elimination(order, float(common.lnz))
    _free(common, factor, [])
    return chosen


def _common() -> Any:
    """CHOLMOD's settings and workspace."""
    ffi, lib = _binding()
    common = ffi.new("cholmod_common *")
    lib.cholmod_start(common)
    common.print = 0
    # supernodal always: CHOLMOD's other method is LDLᵀ without pivots, which takes any matrix
    common.supernodal = lib.CHOLMOD_SUPERNODAL
    common.quick_return_if_not_posdef = 1
    return common


def _sparse(starts: np.ndarray, rows: np.ndarray, values: np.ndarray | None) -> Any:
    """A lower triangle that points to these arrays; a pattern if it has no values."""
    ffi, lib = _binding()
    size = len(starts) - 1
    single = values is not None and values.dtype == np.float32
    places = {
        name: ffi.cast("void *", array.ctypes.data)
        for name, array in (("p", starts), ("i", rows), ("x", values))
        if array is not None
    }
    return ffi.new("cholmod_sparse *", places | {
        "nrow": size, "ncol": size, "nzmax": len(rows), "stype": -1, "itype": lib.CHOLMOD_INT,
        "xtype": lib.CHOLMOD_PATTERN if values is None else lib.CHOLMOD_REAL,
        "dtype": lib.CHOLMOD_SINGLE if single else lib.CHOLMOD_DOUBLE, "sorted": 1, "packed": 1,
    })  # fmt: skip


def _free(common: Any, factor: Any, dense: list[Any]) -> None:
    _, lib = _binding()
    lib.cholmod_free_factor(factor, common)
    for matrix in dense:
        lib.cholmod_free_dense(matrix, common)
    lib.cholmod_finish(common)


@cache
def header() -> Path | None:
    """The header of a CHOLMOD that has single precision, as of SuiteSparse 7.4; None without."""
    headers = (Path(place, "include", "suitesparse", "cholmod.h") for place in PLACES if place)
    single = (file for file in headers if file.exists() and "CHOLMOD_SINGLE 4" in file.read_text())
    return next(single, None)


@cache
def available() -> bool:
    """Find out whether CHOLMOD is here and can be loaded; a warning says why it cannot."""
    if header() is None:
        return False
    try:
        _binding()
    except CompilationError as error:
        logging.getLogger(__name__).warning("MUMPS factorises, which takes longer: %s", error)
        return False
    return True


@cache
def _binding() -> tuple[cffi.FFI, Any]:
    """The compiled binding of this version of CHOLMOD: its types and its functions."""
    place_of_header = header()
    assert place_of_header is not None
    content = f"{place_of_header}{place_of_header.read_text()}{DECLARATIONS}"
    key = hashlib.sha256(content.encode()).hexdigest()[:12]
    folders = [str(place_of_header.parents[2] / "lib")]
    name = f"dolfingrip_cholmod_{key}"

    def get(place: Path) -> Any:
        file = next(place.glob(f"{name}.*.so"), None)
        if file is None:
            ffi = cffi.FFI()
            ffi.cdef(DECLARATIONS)
            ffi.set_source(
                name,
                f'#include "{place_of_header}"',
                libraries=["cholmod"],
                library_dirs=folders,
                runtime_library_dirs=folders,
            )
            file = Path(ffi.compile(tmpdir=place))
        loader = ExtensionFileLoader(name, str(file))
        spec = importlib.util.spec_from_loader(name, loader)
        assert spec is not None
        module = importlib.util.module_from_spec(spec)
        loader.exec_module(module)
        return module

    module = compiled(Path(jit.options()["cache_dir"]) / name, get, "the binding of CHOLMOD")
    return module.ffi, module.lib
