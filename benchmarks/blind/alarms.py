"""False alarms: how often measurements in which nothing is hidden are said to have a cause.

A set has a dozen cases without a cause, which hardly tell a share of 5 % from one of 15 %. Here
are as many as wanted: nuisances, noise and missing readings are drawn anew for each, the readings
come from the generator's library, and the screen compares its odds with its own threshold. Draws
are kept one by one, those of each seed apart: an analyser that was tuned on draws of one seed is
measured on those of another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from benchmarks.blind import cases as casework
from benchmarks.blind import generator, noise
from benchmarks.blind.diagnoses import How
from benchmarks.blind.noise import Instruments
from benchmarks.blind.response import Catalogue, Truth
from benchmarks.blind.score import interval
from dolfingrip.diagnosis import conclude, selection
from dolfingrip.diagnosis.between import between
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.diagnose import problem_of
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation.base import simulate_base
from dolfingrip.diagnosis.simulation.walls import simulate_walls
from dolfingrip.diagnosis.tried import tried
from dolfingrip.diagnosis.workers import StayingWorkers

SEED: Final = 50_912
"""Of the figures that are reported; other draws are for tuning."""
PLACE: Final = ["experiment", "channel", "cycle", "branch", "time_s"]
"""Columns that tell single readings apart."""


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
    """Log odds of any cause against none of each measurement, and their threshold.

    The threshold is known only where the odds are above those before measuring, which no threshold
    is below; else it is NaN.

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
    if known < count:
        assert how.crew is not None
        whole = whole_problem(catalogue, folder / catalogue.protocol.name, how.crew)
        where = places_of(catalogue, whole)
        for number in range(known, count):
            show(number, count)
            problem = _drawn(catalogue, whole, where, (draws.seed, number))
            found = _screened(problem, how.crew)
            row = pd.DataFrame([{"draw": number, **found}])
            row.to_csv(file, mode="a", header=not number, index=False)
    return pd.read_csv(file).head(count)


def whole_problem(catalogue: Catalogue, folder: Path, crew: StayingWorkers) -> Problem:
    """The problem of all readings of the protocol."""
    protocol = catalogue.protocol
    folder.mkdir(parents=True, exist_ok=True)
    told = {**protocol.setup(), "noise": Instruments().told(noise.channels(protocol))}
    path = folder / "measured.csv"
    casework.write_files(path, casework.rows(protocol, catalogue.vector(Truth())), told)
    config = generator.analysed(protocol)
    measurement, _ = selection.selected(measured.read([path], config), config)
    base = simulate_base(measurement, config, crew, effects=tried(None))
    problem, _ = problem_of(measurement, base, simulate_walls(measurement, base, crew))
    return problem


def places_of(catalogue: Catalogue, problem: Problem) -> np.ndarray:
    """(n,) place of each of the problem's readings among the generator's."""
    every = noise.index(catalogue.protocol)[PLACE].assign(place=lambda table: table.index)
    own = problem.index[PLACE].round(6)
    found = own.merge(every.round(6), how="left", on=PLACE, validate="1:1")
    return found["place"].to_numpy(dtype=int)


def _drawn(
    catalogue: Catalogue, whole: Problem, where: np.ndarray, seed: tuple[int, ...]
) -> Problem:
    """The problem of a measurement without a cause."""
    rng = np.random.default_rng(seed)
    truth = Truth((), casework.drawn_nuisances(rng, catalogue.protocol))
    readings = casework.read_by(
        catalogue.protocol, Instruments(), (*seed, 1), catalogue.vector(truth)
    )
    there = readings.kept[where]
    return replace(
        whole,
        kept=whole.kept[there],
        index=whole.index[there].reset_index(drop=True),
        value=readings.value[where][there],
        control_std=whole.control_std[there],
    )


def _screened(problem: Problem, crew: StayingWorkers) -> dict[str, float]:
    """Log odds of any cause, and their threshold."""
    fitter = Fitter(problem, crew, lambda text: None)
    none = fitter.settled()
    problem = fitter.problem
    analysis = conclude.screen(problem, none)
    found = conclude.conclude(problem, analysis, between(fitter, analysis, none))
    odds = found.posterior.log_odds_something()
    above = odds > analysis.priors.log_odds_something
    return {"log_odds": odds, "threshold": analysis.thresholds.something if above else np.nan}


def table(found: Mapping[str, pd.DataFrame], seed: int) -> pd.DataFrame:
    """A row for each protocol: the share of alarms with its 90 % interval.

    It also has the mean threshold of those that were computed, and the odds that one in twenty
    measurements exceeds.
    """
    rows = []
    for name, draws in found.items():
        alarms = int((draws["log_odds"] > draws["threshold"]).sum())
        low, high = interval(alarms, len(draws))
        rows.append({
            "protocol": name, "seed": seed, "draws": len(draws), "alarms": alarms / len(draws),
            "low": low, "high": high, "threshold": draws["threshold"].mean(),
            "log_odds_95": draws["log_odds"].quantile(0.95),
        })  # fmt: skip
    return pd.DataFrame(rows).round(4)
