"""The readings of an experiment, row by row, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.files.run import GraspOutcome, PlatePose, RunFailure, TurningPoint
from dolfingrip.mechanics.path.failure import Failure

if TYPE_CHECKING:
    import pandas as pd

Row = dict[str, Any]
"""Readings of one stop, by column."""


@dataclass(slots=True, repr=False)
class Readings:
    """A table of readings with a row for each stop.

    Attributes:
        kind: the experiment's name.
        config: configuration of the run.
        rows: a dictionary by column for each stop.
        failure: why the path ended early, if it did; the rows up to there are valid.
        turning_point: turning point of the blocked-force curve, if it has one.
        plate: where the force sensor stood, if there was one.
        outcome: outcome of a grasp.
        order: of the columns in its file.
    """

    kind: str
    config: Config
    rows: list[Row] = field(default_factory=list)
    failure: Failure | RunFailure | None = None
    turning_point: TurningPoint | None = None
    plate: PlatePose | None = None
    outcome: GraspOutcome | None = None
    order: Sequence[str] = ()

    def __len__(self) -> int:
        """The number of readings."""
        return len(self.rows)

    def __bool__(self) -> bool:
        """A result is one even if it has no readings."""
        return True

    def __iter__(self) -> Iterator[str]:
        """The names of its columns."""
        return iter(self.columns())

    def _ipython_key_completions_(self) -> list[str]:
        """Names of columns, which IPython and Jupyter complete."""
        return list(self)

    def __contains__(self, name: object) -> bool:
        """Tell whether it has a column of this name."""
        return any(name in row for row in self.rows)

    def __getitem__(self, name: str) -> np.ndarray:
        """The values of a column.

        Args:
            name: of the column, such as ``angle_deg``.

        Returns:
            Shape (rows,): floats, NaN where it is empty; texts of a column of texts.

        Raises:
            ConfigError: one line with the columns there are, if no row has this one.
        """
        if self.rows and name not in self:
            raise ConfigError(
                f"column {name}: not in a result of {self.kind}; allowed: {', '.join(self)}"
            )
        values = [row.get(name) for row in self.rows]
        texts = any(isinstance(value, str) for value in values)
        return np.array(values, dtype=np.str_ if texts else float)

    def column(self, name: str) -> np.ndarray:
        """The values of a column of numbers.

        Args:
            name: of the column, such as ``angle_deg``.

        Returns:
            Shape (rows,), NaN where it is empty.

        Raises:
            ConfigError: one line with the columns there are, if no row has this one.
        """
        values = self[name]
        if values.dtype.kind == "U":
            raise ConfigError(f"column {name}: of texts; allowed: a column of numbers")
        return values

    def columns(self) -> dict[str, list[Any]]:
        """The table by column, in the order of its file; columns without a value are left out."""
        items = (item for row in self.rows for item in row.items())
        present = dict.fromkeys(name for name, v in items if v is not None and v == v)
        names = dict.fromkeys([*(name for name in self.order if name in present), *present])
        return {name: [row.get(name) for row in self.rows] for name in names}

    def to_pandas(self) -> pd.DataFrame:
        """The table as a data frame of pandas: :meth:`columns`, whose names end in their units."""
        import pandas as pd

        return pd.DataFrame(self.columns())
