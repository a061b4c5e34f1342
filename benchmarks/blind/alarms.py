"""False alarms: how often measurements in which nothing is hidden are said to have a cause.

A set has a dozen cases without a cause, which hardly tell a share of 5 % from one of 15 %. Here
are as many as wanted: nuisances, noise and missing readings are drawn anew for each, the readings
come from the generator's library, and each is diagnosed as by the command. Draws are kept one by
one, those of each seed apart: an analyser that was tuned on draws of one seed is measured on those
of another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from benchmarks.blind import cases as casework
from benchmarks.blind import generator, noise
from benchmarks.blind.diagnoses import How, settings_of
from benchmarks.blind.noise import Instruments
from benchmarks.blind.response import Catalogue, Truth
from benchmarks.blind.score import interval
from dolfingrip.diagnosis import selection
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.diagnose import judged

SEED: Final = 50_912
"""Of the figures that are reported; other draws are for tuning."""


@dataclass(frozen=True, slots=True)
class Draws:
    """Which measurements are drawn.

    Attributes:
        folder: where they are kept; a call goes on where the one before it was stopped.
        count: how many.
        seed: of them.
    """

    folder: Path
    count: int
    seed: int = SEED


def draw(
    catalogue: Catalogue, draws: Draws, how: How, show: Callable[[int, int], None]
) -> pd.DataFrame:
    """The answer to each measurement, and its probability.

    Args:
        catalogue: the generator's, of the protocol.
        draws: which.
        how: cases are diagnosed; with workers that stay.
        show: called with the number of draws that are done, and of all.
    """
    folder, count = draws.folder / str(draws.seed), draws.count
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{catalogue.protocol.name}.csv"
    known = len(pd.read_csv(file)) if file.is_file() else 0
    for number in range(known, count):
        show(number, count)
        found = _judged(catalogue, folder / catalogue.protocol.name, how, (draws.seed, number))
        row = pd.DataFrame([{"draw": number, **found}])
        row.to_csv(file, mode="a", header=not number, index=False)
    return pd.read_csv(file).head(count)


def measured_of(catalogue: Catalogue, folder: Path, value: np.ndarray) -> Measurement:
    """Readings of a protocol by ordinary instruments, as a laboratory hands them over."""
    protocol = catalogue.protocol
    folder.mkdir(parents=True, exist_ok=True)
    told = {**protocol.setup(), "noise": Instruments().told(noise.channels(protocol))}
    path = folder / "measured.csv"
    casework.write_files(path, casework.rows(protocol, value), told)
    config = generator.analysed(protocol)
    return selection.selected(measured.read([path], config), config)[0]


def _judged(
    catalogue: Catalogue, folder: Path, how: How, seed: tuple[int, ...]
) -> dict[str, float | str]:
    """What is said of a measurement without a cause."""
    protocol = catalogue.protocol
    truth = Truth((), casework.drawn_nuisances(np.random.default_rng(seed), protocol))
    readings = casework.read_by(protocol, Instruments(), (*seed, 1), catalogue.vector(truth))
    measurement = measured_of(catalogue, folder, readings.value)
    assert how.crew is not None
    config = generator.analysed(protocol)
    decision = judged(measurement, config, how.crew, settings_of(how)).decision
    return {"answer": decision.answer, "none": decision.none, "probability": decision.probability}


def table(found: Mapping[str, pd.DataFrame], seed: int) -> pd.DataFrame:
    """A row for each protocol: the share of alarms with its 90 % interval."""
    rows = []
    for name, draws in found.items():
        alarms = int((draws["answer"] != "none").sum())
        low, high = interval(alarms, len(draws))
        rows.append({
            "protocol": name, "seed": seed, "draws": len(draws), "alarms": alarms / len(draws),
            "low": low, "high": high, "none": draws["none"].mean(),
        })  # fmt: skip
    return pd.DataFrame(rows).round(4)
