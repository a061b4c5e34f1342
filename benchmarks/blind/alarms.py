"""False alarms: how often measurements in which nothing is hidden are said to have a cause.

A half has a dozen cases without a cause, which hardly tell a share of 5 % from one of 15 %. Here
are as many as wanted: nuisances, noise and missing readings are drawn anew for each, the readings
come from the generator's library, and the screen compares its odds with the threshold of the whole
protocol, as a reading that is missing hardly changes it. Draws are kept one by one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
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
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.diagnose import problem_of
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation.base import simulate_base
from dolfingrip.diagnosis.tried import tried
from dolfingrip.diagnosis.workers import StayingWorkers

SEED: Final = 50_911
PLACE: Final = ["experiment", "channel", "cycle", "branch", "time_s"]
"""Columns that tell single readings apart."""


def draw(
    catalogue: Catalogue, folder: Path, how: How, count: int, show: Callable[[int, int], None]
) -> pd.DataFrame:
    """Log odds of any cause against none, and their threshold, of ``count`` measurements.

    Args:
        catalogue: the generator's, of the protocol.
        folder: where draws are kept; a call goes on where the one before it was stopped.
        how: cases are diagnosed; with workers that stay.
        count: number of draws.
        show: called with the number of draws that are done, and of all.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{catalogue.protocol.name}.csv"
    known = len(pd.read_csv(file)) if file.is_file() else 0
    if known < count:
        assert how.crew is not None
        whole = _whole(catalogue, folder / catalogue.protocol.name, how.crew)
        where = _places(catalogue, whole)
        fitter = Fitter(whole, how.crew, lambda text: None)
        threshold = conclude.screen(whole, fitter.none()).thresholds.something
        for number in range(known, count):
            show(number, count)
            odds = _odds(_drawn(catalogue, whole, where, number), how.crew)
            row = pd.DataFrame([{"draw": number, "log_odds": odds, "threshold": threshold}])
            row.to_csv(file, mode="a", header=not number, index=False)
    return pd.read_csv(file).head(count)


def _whole(catalogue: Catalogue, folder: Path, crew: StayingWorkers) -> Problem:
    """The problem of all readings of the protocol."""
    protocol = catalogue.protocol
    folder.mkdir(parents=True, exist_ok=True)
    told = {**protocol.setup(), "noise": Instruments().told(noise.channels(protocol))}
    path = folder / "measured.csv"
    casework.write_files(path, casework.rows(protocol, catalogue.vector(Truth())), told)
    config = generator.analysed(protocol)
    measurement, _ = selection.selected(measured.read([path], config), config)
    base = simulate_base(measurement, config, crew, effects=tried(None))
    problem, _ = problem_of(measurement, base)
    return problem


def _places(catalogue: Catalogue, problem: Problem) -> np.ndarray:
    """(n,) place of each of the problem's readings among the generator's."""
    every = noise.index(catalogue.protocol)[PLACE].assign(place=lambda table: table.index)
    own = problem.index[PLACE].round(6)
    found = own.merge(every.round(6), how="left", on=PLACE, validate="1:1")
    return found["place"].to_numpy(dtype=int)


def _drawn(catalogue: Catalogue, whole: Problem, where: np.ndarray, number: int) -> Problem:
    """The problem of a measurement without a cause."""
    rng = np.random.default_rng([SEED, number])
    truth = Truth((), casework.drawn_nuisances(rng, catalogue.protocol))
    readings = casework.read_by(
        catalogue.protocol, Instruments(), (SEED, number, 1), catalogue.vector(truth)
    )
    there = readings.kept[where]
    return replace(
        whole,
        kept=whole.kept[there],
        index=whole.index[there].reset_index(drop=True),
        value=readings.value[where][there],
        led_std=whole.led_std[there],
    )


def _odds(problem: Problem, crew: StayingWorkers) -> float:
    none = Fitter(problem, crew, lambda text: None).none()
    analysis = conclude.screen(problem, none)
    found = conclude.conclude(problem, analysis, {conclude.NONE: none})
    return found.posterior.log_odds_something()


def table(found: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """A row for each protocol: the share of alarms with its 90 % interval.

    Beside it the share were the threshold never below the odds before the readings.
    """
    weights = HypothesisWeights()
    before = float(np.log((weights.single + weights.pair + weights.unknown) / weights.none))
    rows = []
    for name, draws in found.items():
        alarms = int((draws["log_odds"] > draws["threshold"]).sum())
        low, high = interval(alarms, len(draws))
        rows.append({
            "protocol": name, "draws": len(draws), "alarms": alarms / len(draws), "low": low,
            "high": high,
            "never_below_prior": float(
                (draws["log_odds"] > draws["threshold"].clip(lower=before)).mean()
            ),
            "threshold": float(draws["threshold"].iloc[0]),
            "log_odds_95": float(draws["log_odds"].quantile(0.95)),
        })  # fmt: skip
    return pd.DataFrame(rows)
