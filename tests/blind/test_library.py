"""The blind benchmark: the generator's library, of which simulations may end early."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from blind.made_up import case, made_up

from benchmarks.blind import judging, library
from benchmarks.blind.judging import CaseSet, Folders
from benchmarks.blind.library import BASE, Entry
from benchmarks.blind.response import Hidden
from dolfingrip.config import Config
from dolfingrip.diagnosis.simulation.job import Job, JobResult
from dolfingrip.diagnosis.simulation.runner import Workers

DONE = JobResult({"angle_deg": np.zeros(1), "force_N": np.zeros(1)})
STOPPED = JobResult(failure_class="iteration limit", failure="stopped at 110 kPa")


@dataclass(frozen=True, slots=True)
class Pretended(Workers):
    """Workers that compute at once: yeoh ends early in bending."""

    known: dict[str, JobResult] = field(default_factory=dict)
    order: list[str] = field(default_factory=list)

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        for job in jobs:
            stops = job.experiment == "bending" and "yeoh" in effects(job)
            self.known[job.key] = STOPPED if stops else DONE
            self.order.append(f"{job.experiment} {'+'.join(effects(job)) or BASE}")
        return [self.known[job.key] for job in jobs]


def effects(job: Job) -> list[str]:
    return [effect.name() for effect in job.config.extensions.active()]


def entry(name: str, experiment: str) -> Entry:
    config = Config()
    if name != BASE:
        config = config.overridden([f"extensions.{name}.C20_MPa=0.1"])
    config = config.changed(protocol={"time_s": [0.0], "pressure_kPa": [0.0]})
    return Entry(name, 0, 1.0, experiment, "curve", "store", Job(experiment, config))


def test_what_failed_in_one_test_is_not_simulated_in_another(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    every = [
        entry(name, test) for test in ("bending", "blocked_force") for name in (BASE, "yeoh")
    ]  # fmt: skip
    workers = Pretended(tmp_path)
    monkeypatch.setattr(library, "entries", lambda history: every)
    monkeypatch.setattr(library, "known", lambda wanted, folder: dict(workers.known))
    library.compute("P2", tmp_path, lambda store: workers)
    assert workers.order == ["bending base", "bending yeoh", "blocked_force base"]
    found = library.load("P2", tmp_path)
    assert found.failed == {"yeoh"}
    assert found.failures == ("yeoh in bending: stopped at 110 kPa",)
    assert not found.knows("yeoh")


def test_cases_wait_for_what_is_missing_but_not_for_what_failed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    catalogue = made_up("P2")
    whole = catalogue.library
    hidden = case(catalogue, Hidden("prony", 0, 1.0))
    other = case(catalogue, Hidden("mooney_rivlin", 0, 1.0))
    few = {key: each for key, each in whole.changes.items() if key[0] != "mooney_rivlin"}
    monkeypatch.setattr(judging.generator, "causes", lambda: catalogue.causes)
    for failed, complete in ((frozenset[str](), False), (frozenset({"mooney_rivlin"}), True)):
        left = library.Library(whole.base, whole.walls, few, tuple(failed), failed)
        monkeypatch.setattr(library, "of_protocol", lambda protocol, folder, left=left: left)
        case_set = CaseSet([hidden, other], Folders(tmp_path))
        assert case_set.complete("P2") is complete
        assert case_set.readings(hidden) is not None
        assert case_set.readings(other) is None
        assert case_set.failures() == sorted(failed)
