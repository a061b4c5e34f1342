"""The result of an experiment: its readings, their derivatives, and how it was computed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from dolfingrip import config as configuration
from dolfingrip.channels import WORDS
from dolfingrip.charts.chart import Chart
from dolfingrip.experiments.chart import DrawnResult, chart
from dolfingrip.experiments.index import find
from dolfingrip.experiments.results.readings import Readings, Row
from dolfingrip.experiments.results.sensitivity_table import SensitivityTable
from dolfingrip.files.result_file import reading
from dolfingrip.files.run import RunFile
from dolfingrip.files.table import Columns, numbers, read_csv
from dolfingrip.files.text_table import TextTable
from dolfingrip.mechanics.path.failure import Failure
from dolfingrip.sections.errors import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TABLE: Final = "result.csv"
NOT_RUN: Final = RunFile(experiment="")
"""Facts of a run that has not ended."""


@dataclass(slots=True, repr=False)
class Result(Readings):
    """The result of an experiment.

    ``result["angle_deg"]`` is a column, ``len(result)`` the number of readings.

    Attributes:
        sensitivities: derivatives of the readings, if they were asked for.
        second_runs: for the key of each choice of the model whose difference was asked for: why
            the run with the other choice ended early; None if it did not.
        facts: contents of ``run.json``.
        folder: where its files are; None if it was not written.
    """

    sensitivities: SensitivityTable = field(default_factory=SensitivityTable)
    second_runs: dict[str, Failure | None] = field(default_factory=dict)
    facts: RunFile = NOT_RUN
    folder: Path | None = None

    @classmethod
    def read(cls, folder: Path | str) -> Self:
        """Read a result from its folder.

        Args:
            folder: that an experiment wrote.

        Returns:
            The result; also of a run that was interrupted, with the readings up to there.

        Raises:
            ResultFileError: one line, if a file is missing or has something else in it.
            ConfigError: one line, if this version has no such experiment or configuration.
        """
        folder = Path(folder)
        facts = RunFile.read(folder)
        experiment = find(facts.experiment)
        with reading(folder / TABLE):
            table = read_csv(folder / TABLE, ours=True)
            rows: list[Row] = [
                {name: _value(entry) for name, entry in zip(table, entries, strict=True) if entry}
                for entries in zip(*table.values(), strict=True)
            ]
            for name in table:
                texts = [row[name] for row in rows if isinstance(row.get(name), str)]
                if texts and name not in WORDS:
                    raise ValueError(f"column {name} has a text: {shown(texts[0])}")
        return cls(
            experiment.name,
            configuration.from_dict(facts.config),
            rows,
            facts.failure,
            facts.turning_point,
            facts.plate,
            facts.outcome,
            tuple(table),
            SensitivityTable.read(folder),
            facts=facts,
            folder=folder,
        )

    def chart(self, measured: Columns | None = None, label: str = "") -> Chart:
        """Make the chart of its experiment's plot.

        Args:
            measured: readings of an instrument that are drawn, too.
            label: what the key calls the result, where others share the axes.

        Returns:
            The chart as data.

        Raises:
            ValueError: one line that names a column which is missing.
        """
        shown = [DrawnResult(self, label)]
        turn = self.turning_point
        return chart(find(self.kind), shown, measured=measured, turning_point=turn)

    def plot(
        self, axes: Axes | None = None, *, label: str = "", measured: Columns | None = None
    ) -> Axes:
        """Draw the curves of its experiment's plot with Matplotlib.

        Args:
            axes: axes that are drawn into; None: new ones of pyplot. Further results on the same
                axes have colours of their own.
            label: what the key calls the result.
            measured: readings of an instrument that are drawn, too.

        Returns:
            The axes.

        Raises:
            ValueError: one line that names a column which is missing.
        """
        if axes is None:
            import matplotlib.pyplot as plt

            axes = plt.figure(layout="constrained").add_subplot()
        from dolfingrip.charts import picture

        picture.draw(self.chart(measured, label), axes)
        return axes

    def _repr_html_(self) -> str:
        """How the run ended, and its readings, as a notebook shows them."""
        columns, table = self.columns(), find(self.kind).table
        values = {c: v for c in table if (v := numbers(columns, c.name)) is not None}
        cells = [[f"{x:z{c.form}}" if x == x else "–" for x in v] for c, v in values.items()]
        rows = list(zip(*cells, strict=True))
        title = repr(self).splitlines()[0].strip("<>")
        return TextTable([channel.heading for channel in values], rows, title).html()

    def __repr__(self) -> str:
        """Lines with the number of readings, how the run ended, and the last row."""
        ending = "complete" if self.failure is None else self.failure.sentence()
        if self.outcome is not None:
            ending += f"; {self.outcome.kind}: {self.outcome.sentence}"
        text = f"<Result of {self.kind}: {len(self.rows)} readings, {ending}>"
        if self.rows:
            last = ", ".join(
                f"{name} {value:z.6g}" if isinstance(value, float) else f"{name} {value}"
                for name, value in self.rows[-1].items()
                if not isinstance(value, float) or math.isfinite(value)
            )
            text += f"\n  last row: {last}"
        return text


def _value(entry: str) -> Any:
    """A number if the text is one."""
    try:
        return int(entry) if entry.lstrip("-").isdigit() else float(entry)
    except ValueError:
        return entry
