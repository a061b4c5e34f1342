"""What a diagnosis delivers, read back from the files that it writes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.results import write
from dolfingrip.files.diagnosis import READINGS, DiagnosisFile, FittedNumber, Verdict


@dataclass(frozen=True)
class Delivered:
    """Contents of the files.

    Attributes:
        folder: of the files.
        result: ``diagnosis.json``.
    """

    folder: Path
    result: DiagnosisFile

    @property
    def verdict(self) -> Verdict:
        """The answer."""
        return self.result.verdict

    @property
    def inclusion(self) -> dict[str, float]:
        """Probability by cause."""
        return {cause.name: cause.probability for cause in self.result.causes}

    @property
    def numbers(self) -> dict[str, FittedNumber]:
        """Fitted numbers of the answer by key."""
        return {each.key: each for each in self.result.fits[0].parameters}

    def numbers_of(self, *effects: str) -> dict[str, FittedNumber]:
        """Fitted numbers of a hypothesis by key."""
        (fit,) = (fit for fit in self.result.fits if fit.effects == effects)
        return {each.key: each for each in fit.parameters}

    @property
    def extended(self) -> Config:
        """``extended.toml``."""
        return configuration.load(self.folder / "extended.toml")

    @property
    def readings(self) -> pd.DataFrame:
        """``readings.csv``: values, noise, and the model before and after."""
        return pd.read_csv(self.folder / READINGS)

    @property
    def left(self) -> np.ndarray:
        """What the fitted model leaves of the readings (n,), by the noise."""
        found = self.readings
        return ((found["value"] - found["after"]) / found["noise"]).to_numpy()


def delivered(found: Diagnosis, folder: Path, data: Sequence[Path] = ()) -> Delivered:
    """Write a diagnosis into a folder, and read it back."""
    write(found, data, folder)
    return Delivered(folder, DiagnosisFile.read(folder))
