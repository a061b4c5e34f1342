"""``surrogate.json`` and the tables beside it: what a surrogate learnt, and how well."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field, FiniteFloat, PositiveInt

from dolfingrip.files.result_file import Part, ResultFile, reading
from dolfingrip.files.table import read_csv

CURVE, DESIGNS = "learning_curve.csv", "designs.csv"
PREFIX = "surrogate."
"""Begins the name of a column with the surrogate's outputs."""


class OutputError(Part):
    """Root mean square errors of an output, in its unit."""

    training: float | None = None
    test: float | None = Field(None, description="on designs that were held out")


class LearntDesign(Part):
    """A design that the surrogate learnt from or was tested on."""

    inputs: dict[str, float]
    outputs: dict[str, float]
    predicted: dict[str, float]


class SurrogateFile(ResultFile):
    """Contents of ``surrogate.json``."""

    FILE: ClassVar[str] = "surrogate.json"
    MADE_BY: ClassVar[str] = "dolfingrip train"

    schema_version: Literal[1] = 1
    inputs: dict[str, tuple[FiniteFloat, FiniteFloat]] = Field(
        description="range of each, by which it is normalised to [−1, 1]: that of all designs"
    )
    outputs: dict[str, tuple[FiniteFloat, FiniteFloat]] = Field(
        description="range of each, by which it is normalised to [0, 1]: that of training designs"
    )
    layers: tuple[PositiveInt, ...] = Field((), description="widths, from inputs to outputs")
    activation: Literal["tanh", "silu"] = "tanh"
    weights_sha256: str = Field("", description="of surrogate.pt beside it")
    settings: dict[str, Any] = Field({}, description="of the training")
    training_mse: float | None = Field(None, description="of normalised outputs")
    test_mse: float | None = Field(None, description="on designs that were held out")
    rms_error: dict[str, OutputError] = Field({}, description="by output")
    campaign: dict[str, Any] | None = Field(None, description="what all designs share")
    training_designs: int = 0
    test_designs: int = 0
    failed_designs: int = 0
    incomplete_designs: int = 0
    table_sha256: str = Field("", description="of the designs")
    versions: dict[str, str] = Field({}, description="of the software")

    @property
    def base(self) -> dict[str, Any] | None:
        """Configuration that a design's inputs are set in; None if it is not known."""
        return (self.campaign or {}).get("base")

    @property
    def errors(self) -> dict[str, float]:
        """Root mean square error of each output on designs that were held out, in its unit."""
        return {name: e.test for name, e in self.rms_error.items() if e.test is not None}

    @staticmethod
    def learning_curve(folder: Path) -> dict[str, list[float]]:
        """Read how the errors fell.

        Args:
            folder: of the surrogate.

        Returns:
            ``epoch``, ``training_mse`` and ``test_mse`` of the normalised outputs; nothing if
            there is no such table.
        """
        if not (folder / CURVE).is_file():
            return {}
        with reading(folder / CURVE):
            table = read_csv(folder / CURVE, ours=True)
            return {name: [float(entry) for entry in entries] for name, entries in table.items()}

    def designs(self, folder: Path) -> list[LearntDesign]:
        """Read the designs that it learnt from or was tested on.

        Args:
            folder: of the surrogate.

        Returns:
            They; none if there is no such table.
        """
        if not (folder / DESIGNS).is_file():
            return []

        def some(row: dict[str, str], names: Any, prefix: str = "") -> dict[str, float]:
            return {n: float(row[prefix + n]) for n in names if row.get(prefix + n)}

        with reading(folder / DESIGNS):
            table = read_csv(folder / DESIGNS, ours=True)
            rows = (dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True))
            return [
                LearntDesign(
                    inputs=some(row, self.inputs),
                    outputs=some(row, self.outputs),
                    predicted=some(row, self.outputs, PREFIX),
                )
                for row in rows
            ]
