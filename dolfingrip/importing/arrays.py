"""Arrays of a MAT file of MATLAB, 4 to 7.3, or of another HDF5 file, as tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.config import ConfigError

MOST_NUMBERS: Final = 20_000_000
"""Of all arrays of a file: a million rows of twenty columns."""


def tables(file: Path) -> dict[str, dict[str, np.ndarray]]:
    """Columns that are equally long, by their names, which stand for the table.

    A matrix is a table of its own, as are the fields of a structure.

    Args:
        file: of MATLAB, or HDF5.

    Raises:
        ConfigError: one line, where it cannot be read, or has no arrays of numbers.
    """
    alike: dict[tuple[str, int], dict[str, np.ndarray]] = {}
    names = []
    try:
        for path, array in _arrays(file):
            names.append(path)
            within, _, name = path.rpartition(".")
            if array.ndim == 1:
                alike.setdefault((within, len(array)), {})[name] = array
            elif array.ndim == 2 and len(array) > 1:
                across = min(array, array.T, key=len)  # there are more readings than quantities
                columns = {f"{name} column {i + 1}": column for i, column in enumerate(across)}
                alike[path, across.shape[1]] = columns
    except ImportError:  # the command's edge says what to install
        raise
    except Exception as error:  # any error of the readers on a broken file
        raise ConfigError(
            f"{file}: not readable as a MAT or HDF5 file ({error}); allowed: a whole one, or a CSV"
        ) from None
    by_name = {
        (f"{within}: " if within else "") + ", ".join(columns): columns
        for (within, length), columns in alike.items()
        if length > 1 and len(columns) > 1
    }
    if not by_name:
        raise ConfigError(
            f"{file}: {', '.join(names) or 'no array of numbers'}; allowed: two arrays of one "
            "length at least, or a matrix; write a table of MATLAB as CSV by writetable"
        )
    return by_name


def _arrays(file: Path) -> Iterator[tuple[str, np.ndarray]]:
    """Real arrays of numbers by their path; those of one row or column are flat."""
    import h5py  # only these files need it

    if h5py.is_hdf5(file):
        with h5py.File(file) as opened:
            stored: list[tuple[str, Any]] = []
            opened.visititems(lambda path, item: stored.append((path, item)))
            of_numbers = [
                (path.replace("/", "."), item)
                for path, item in stored
                if isinstance(item, h5py.Dataset) and not path.startswith("#")
                and item.dtype.kind in "iuf" and item.attrs.get("MATLAB_class") != b"char"
            ]  # fmt: skip
            _check(sum(item.size for _, item in of_numbers))
            for path, item in of_numbers:  # MATLAB has columns where HDF5 has rows
                array = item[()].T if "MATLAB_class" in item.attrs else item[()]
                yield path, np.squeeze(array).astype(float)
    else:
        import scipy.io

        _check(sum(int(np.prod(shape)) for _, shape, _ in scipy.io.whosmat(file)))
        yield from _within("", scipy.io.loadmat(file, squeeze_me=True, simplify_cells=True))


def _within(path: str, fields: Mapping[str, Any]) -> Iterator[tuple[str, np.ndarray]]:
    for name, value in fields.items():
        if isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
            parts = {f"{name} {i}": part for i, part in enumerate(np.ravel(value), 1)}
            yield from _within(path, parts)
        elif isinstance(value, Mapping):
            yield from _within(f"{path}{name}.", value)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
            yield f"{path}{name}", value.astype(float)


def _check(size: int) -> None:
    if size > MOST_NUMBERS:
        raise ValueError(f"{size} numbers; allowed: up to {MOST_NUMBERS}")
