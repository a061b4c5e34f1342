"""Derivatives of readings as a table: rows, columns, parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from dolfingrip.files.result_file import reading
from dolfingrip.files.table import read_csv

if TYPE_CHECKING:
    import pandas as pd

COLUMNS: Final = ("row", "column", "parameter", "derivative")
"""Columns of ``sensitivity.csv``: the row of ``result.csv`` from 0 on, its column, the key of the
configuration, and the derivative in the column's unit for each unit of the parameter."""

FILE: Final = "sensitivity.csv"


class SensitivityTable(Sequence[dict[str, Any]]):
    """Derivatives of every reading by parameters of the configuration.

    As a sequence it has a dictionary for each derivative, by :data:`COLUMNS`.

    Args:
        entries: such dictionaries.
    """

    def __init__(self, entries: Iterable[Mapping[str, Any]] = ()) -> None:
        self._entries = [dict(entry) for entry in entries]

    def __len__(self) -> int:
        """The number of derivatives."""
        return len(self._entries)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The derivatives one by one."""
        return iter(self._entries)

    def __getitem__(self, key: Any) -> Any:
        """Derivatives of a column by a parameter, or one entry of the sequence.

        Args:
            key: a column and a parameter, such as ``("angle_deg", "finger.wall_mm")``; or a place.

        Returns:
            Shape (rows,), in the column's unit for each unit of the parameter.

        Raises:
            KeyError: one line, if there are none.
        """
        if not isinstance(key, tuple):
            return self._entries[key]
        column, parameter = key
        if column not in self.columns or parameter not in self.parameters:
            raise KeyError(
                f"no derivative of {column} by {parameter}; allowed: one of "
                f"{', '.join(self.columns)} by one of {', '.join(self.parameters)}"
            )
        return self.values[:, self.columns.index(column), self.parameters.index(parameter)]

    def __add__(self, others: Iterable[Mapping[str, Any]]) -> SensitivityTable:
        """A table with further derivatives."""
        return SensitivityTable([*self._entries, *others])

    def __repr__(self) -> str:
        """One line with its size."""
        rows, columns, parameters = self.values.shape
        return f"<Sensitivities: {rows} rows, {columns} columns, {parameters} parameters>"

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of the result that are derived."""
        return tuple(dict.fromkeys(entry["column"] for entry in self._entries))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Keys of the configuration that they are derived by."""
        return tuple(dict.fromkeys(entry["parameter"] for entry in self._entries))

    @property
    def values(self) -> npt.NDArray[np.float64]:
        """The derivatives, shape (rows, columns, parameters); NaN where there is none."""
        columns, parameters = self.columns, self.parameters
        rows = 1 + max((entry["row"] for entry in self._entries), default=-1)
        slopes = np.full((rows, len(columns), len(parameters)), np.nan)
        at_column = {name: i for i, name in enumerate(columns)}
        at_parameter = {key: i for i, key in enumerate(parameters)}
        for entry in self._entries:
            place = entry["row"], at_column[entry["column"]], at_parameter[entry["parameter"]]
            slopes[place] = entry["derivative"]
        return slopes

    def to_pandas(self) -> pd.DataFrame:
        """A data frame of pandas: a row for each row and column, a column for each parameter."""
        import pandas as pd

        long = pd.DataFrame(self._entries, columns=list(COLUMNS))
        return long.pivot(index=["row", "column"], columns="parameter", values="derivative")

    @classmethod
    def read(cls, folder: Path) -> SensitivityTable:
        """Read ``sensitivity.csv``.

        Args:
            folder: of a result.

        Returns:
            Its table; an empty one if there is no such file.
        """
        file = folder / FILE
        if not file.is_file():
            return cls()
        with reading(file):
            table = read_csv(file, ours=True)
            rows = (dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True))
            return cls(
                {**entry, "row": int(entry["row"]), "derivative": float(entry["derivative"])}
                for entry in rows
            )
