"""Cases with a simulation of their own: all causes and nuisances at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from benchmarks.blind.cases import Case
from benchmarks.blind.generator import DRIFT, STAGES, Cause, causes, generating
from benchmarks.blind.outsiders import OUTSIDERS
from benchmarks.blind.protocols import PROTOCOLS, Course, Protocol
from benchmarks.blind.response import (
    WALL_SPREAD,
    GAP_SPREAD_mm,
    Truth,
    displayed,
    flat,
    outsider_modulus,
    outsider_pressure,
)
from dolfingrip.config import Config
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.diagnosis.simulation.job import Job, JobResult, result_of
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.jobs.store import NAME, Store

Sections = Mapping[str, Mapping[str, Any]]

STORE: Final = "full"
"""Name of the folder of these simulations."""


@dataclass(frozen=True, slots=True)
class Run:
    """The simulation of one test of a case.

    Attributes:
        course: the test.
        job: its simulation.
        place: (rows,) number of the stop that each row is.
    """

    course: Course
    job: Job
    place: np.ndarray


def runs(protocol: Protocol, truth: Truth, lab: Sections | None = None) -> list[Run]:
    """The simulations of a protocol.

    Args:
        protocol: that is followed.
        truth: that is hidden.
        lab: what the laboratory has set up otherwise, by section of the configuration and key.
    """
    known = causes()
    config = configured(generating(protocol).changed(**(lab or {})), truth, known)
    return [_run(course, config, truth, known) for course in protocol.courses]


def configured(config: Config, truth: Truth, known: Mapping[str, Cause]) -> Config:
    """The generator's configuration with all that is hidden but what instruments do."""
    plate_mm = config.plate.gap_mm + GAP_SPREAD_mm * truth.sigma("plate_gap")
    overrides = [
        f"material.mu_MPa={config.material.mu_MPa * truth.modulus!r}",
        f"finger.wall_mm={config.finger.wall_mm * (1 + WALL_SPREAD * truth.sigma('wall'))!r}",
        f"plate.gap_mm={max(plate_mm, 0.0)!r}",
        f"extensions.pressure_gain.gain={truth.gain!r}",
        f"extensions.pressure_offset.offset_kPa={truth.offset_kPa!r}",
    ]
    for hidden in truth.causes:
        if hidden.name in OUTSIDERS:
            change = OUTSIDERS[hidden.name].overrides
            overrides += change(hidden.strength) if change is not None else ()
        elif not known[hidden.name].effect.has("reading"):
            overrides += known[hidden.name].overrides(hidden.form, hidden.strength, truth.modulus)
    return config.overridden(overrides)


def _run(course: Course, config: Config, truth: Truth, known: Mapping[str, Cause]) -> Run:
    if course.experiment == "coupon":
        wanted = course.rows[course.control].to_numpy(dtype=float)
    else:
        # a modulus that changes between cycles is a pressure that does
        wanted = outsider_pressure(course, truth) / outsider_modulus(course, truth)
    if _depends_on_the_way(truth, known):
        place = np.arange(len(wanted))
        protocol = {**course.protocol(), course.control: [float(value) for value in wanted]}
    else:
        stops, place = np.unique(np.round(wanted, 9), return_inverse=True)
        protocol = {
            "time_s": [float(i) for i in range(len(stops))],
            course.control: [float(value) for value in stops],
            "cycle": [1] * len(stops),
            "branch": ["loading"] * len(stops),
        }
    return Run(course, Job(course.experiment, config.changed(protocol=protocol)), place)


def _depends_on_the_way(truth: Truth, known: Mapping[str, Cause]) -> bool:
    clocks = (*STAGES, DRIFT)
    return any(
        each.name in clocks or (each.name in known and known[each.name].remembers)
        for each in truth.causes
    )


def compute(cases: Sequence[Case], workers: Workers) -> None:
    """Simulate what is missing."""
    wanted = [runs(PROTOCOLS[case.protocol], case.truth) for case in cases]
    workers.results([run.job for each in wanted for run in each])


def known_results(folder: Path) -> dict[str, JobResult]:
    """Results by key, as far as they have been computed."""
    if not (folder / NAME).is_file():
        return {}
    with Store(folder) as store:
        return {row["key"]: result_of(row) for row in store.rows() if row["status"] != "pending"}


def vector(case: Case, results: Mapping[str, JobResult]) -> np.ndarray | None:
    """(n,) true readings of a case; None where a simulation is missing or ended early."""
    protocol = PROTOCOLS[case.protocol]
    return readings(protocol, case.truth, runs(protocol, case.truth), results)


def readings(
    protocol: Protocol, truth: Truth, wanted: Sequence[Run], results: Mapping[str, JobResult]
) -> np.ndarray | None:
    """(n,) true readings of a protocol's simulations; None where one is missing or ended early."""
    tables: list[pd.DataFrame] = []
    known = causes()
    for run in wanted:
        result = results.get(run.job.key)
        if result is None or result.failure_class is not None:
            return None
        true = {
            name: values[run.place]
            for name, values in result.columns.items()
            if name in READING_COLUMNS
        }
        if "force_N" in true:
            true["force_N"] = true["force_N"] * outsider_modulus(run.course, truth)
        shown = displayed(known, run.course, true, truth)
        names = [name for name in READING_COLUMNS if name in shown]
        tables.append(run.course.rows.assign(**{name: shown[name] for name in names}))
    return flat(protocol, tables)
