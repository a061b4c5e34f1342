"""Simulations of the reference finger that come with the package: a small file of results.

A result serves a job of the same configuration whose protocol is the beginning of its own: who
loads once, or unloads, is served by three cycles. A file is stale where the code has changed since:
results of an effect count only with that effect's code unchanged, and where the mechanics have
changed at all, one simulation is computed anew and has to agree before any other is believed.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.diagnosis.policy import MODEL
from dolfingrip.diagnosis.simulation import sources
from dolfingrip.diagnosis.simulation.job import FORMAT, Job, JobResult
from dolfingrip.files import whole
from dolfingrip.jobs.job import Answer

FILE: Final = Path(__file__).with_name("reference.npz")

Protocol = dict[str, list[Any]]


@dataclass(frozen=True, slots=True)
class Known:
    """One result.

    Attributes:
        job: its key without protocol and derivatives.
        effects: that were on, by name.
        protocol: stops.
        gradients: keys of the parameters of its derivatives.
        curve: readings and derivatives as a campaign stores them.
        failure_class, failure: why not all stops were reached; None where all were.
        wall_s: time that it took.
    """

    job: str
    effects: Sequence[str]
    protocol: Protocol
    gradients: Sequence[str]
    curve: Mapping[str, np.ndarray]
    failure_class: str | None
    failure: str | None
    wall_s: float | None

    def serves(self, job: Job) -> bool:
        """Whether a job's protocol is the beginning of this, and its derivatives are here."""
        if not set(job.gradients) <= set(self.gradients):
            return False
        asked = protocol_of(job)
        return asked.keys() == self.protocol.keys() and all(
            self.protocol[name][: len(values)] == values for name, values in asked.items()
        )

    def answer(self, job: Job) -> Answer:
        """As the store takes it."""
        count = len(next(iter(protocol_of(job).values())))
        wanted = {
            name: values[:count].tolist()
            for name, values in self.curve.items()
            if not name.startswith("[") or json.loads(name)[1].split("[")[0] in job.gradients
        }
        reached = min((len(values) for values in wanted.values()), default=0)
        done = self.failure_class is None or reached == count
        if done:
            return Answer(job.key, "done", {"curve": wanted}, wall_s=self.wall_s, worker="shipped")
        return Answer(
            job.key, "failed", partial={"curve": wanted}, failure_class=self.failure_class,
            failure=self.failure, wall_s=self.wall_s, worker="shipped",
        )  # fmt: skip


_FACTS: Final = tuple(each.name for each in fields(Known) if each.name != "curve")
"""What a file says of a result beside its numbers."""


@dataclass(slots=True)
class Shipped:
    """What a file holds.

    Attributes:
        core: digest of the code that computed it.
        known: its results by their jobs' key without protocol.
        agrees: whether a simulation computed anew agreed; None where that was not tried.
    """

    core: str
    known: Mapping[str, Sequence[Known]]
    agrees: bool | None = None

    def answers(
        self, jobs: Iterable[Job], computed: Callable[[Job], JobResult]
    ) -> list[tuple[Job, Answer]]:
        """What is known of ``jobs``.

        Args:
            jobs: that are wanted.
            computed: computes a job anew; called once, where the code has changed.
        """
        found = [(job, known) for job in jobs if (known := self._of(job)) is not None]
        if not found or not self._believed(computed, found):
            return []
        return [(job, known.answer(job)) for job, known in found]

    def _of(self, job: Job) -> Known | None:
        candidates = self.known.get(job.key_without_protocol, ())
        return next((known for known in candidates if known.serves(job)), None)

    def _believed(
        self, computed: Callable[[Job], JobResult], found: Sequence[tuple[Job, Known]]
    ) -> bool:
        if self.agrees is None and self.core == sources.core_digest():
            self.agrees = True
        plain = [(job, known) for job, known in found if not known.effects]
        if self.agrees is None and plain:
            quickest = min(plain, key=lambda pair: pair[1].wall_s or 0.0)
            self.agrees = self._checked(computed, *quickest)
        return bool(self.agrees)

    def _checked(self, computed: Callable[[Job], JobResult], job: Job, own: Known) -> bool:
        """Whether a job comes out as it did, within the tolerance of each channel."""
        anew, answer = computed(job).columns, own.answer(job)
        curve = (answer.result or answer.partial or {})["curve"]
        return all(
            len(anew.get(name, ())) == len(values)
            and np.allclose(anew[name], values, 0.0, CHANNELS[name].tolerance)
            for name in READING_COLUMNS
            if (values := np.asarray(curve.get(name, ()))).size
        )


def protocol_of(job: Job) -> Protocol:
    """Stops of a job."""
    told = job.config.protocol.model_dump(mode="json")
    return {name: values for name, values in told.items() if values}


def write(
    file: Path, jobs: Iterable[Job], results: Iterable[JobResult], *, keep: bool = False
) -> None:
    """Write the results of jobs; with ``keep`` what the file has beside them, too."""
    known = read(file) if keep else None
    every = [] if known is None else [each for own in known.known.values() for each in own]
    every += [
        _known(job, result)
        for job, result in zip(jobs, results, strict=True)
        if known is None or known._of(job) is None
    ]
    facts: list[dict[str, Any]] = [
        {
            **{name: getattr(each, name) for name in _FACTS},
            "columns": {name: len(values) for name, values in each.curve.items()},
        }
        for each in every
    ]
    numbers = [
        float(f"{x:.{MODEL.digits}g}")
        for each in every
        for values in each.curve.values()
        for x in values
    ]
    names = sorted({name for fact in facts for name in fact["effects"]})
    head = {
        "format": FORMAT, "core": sources.core_digest(), "results": facts,
        "effects": {name: sources.effect_digest(name) for name in names},
    }  # fmt: skip
    _replace(file, head, np.array(numbers, dtype=np.float32))


def _known(job: Job, result: JobResult) -> Known:
    effects = sorted(effect.name() for effect in job.config.extensions.active())
    slopes = {json.dumps(list(k)): values for k, values in result.slopes.items()}
    return Known(
        job.key_without_protocol, effects, protocol_of(job), job.gradients,
        {**result.columns, **slopes}, result.failure_class, result.failure, result.wall_s,
    )  # fmt: skip


def restamp(file: Path) -> None:
    """Give a file the digests of today's code, which is known to compute what the file has."""
    head, numbers = _loaded(file)
    head["core"] = sources.core_digest()
    head["effects"] = {name: sources.effect_digest(name) for name in head["effects"]}
    _replace(file, head, numbers)


def _loaded(file: Path) -> tuple[dict[str, Any], np.ndarray]:
    with np.load(file) as data:
        return json.loads(data["head"].tobytes().decode()), data["numbers"]


def _replace(file: Path, head: Mapping[str, Any], numbers: np.ndarray) -> None:
    text = np.frombuffer(json.dumps(head).encode(), dtype=np.uint8)
    with whole.stream(file) as content:
        np.savez_compressed(content, head=text, numbers=numbers)


@cache
def read(file: Path = FILE) -> Shipped | None:
    """What :func:`write` wrote; None where there is no file, or one of another format.

    Results of effects whose code has changed are left out.
    """
    if not file.is_file():
        return None
    head, numbers = _loaded(file)
    if head["format"] != FORMAT:
        return None
    same = {name for name, old in head["effects"].items() if old == _now(name)}
    known: dict[str, list[Known]] = {}
    place = 0
    for fact in head["results"]:
        curve = {}
        for name, count in fact["columns"].items():
            curve[name] = numbers[place : place + count].astype(float)
            place += count
        if set(fact["effects"]) <= same:
            known.setdefault(fact["job"], []).append(
                Known(curve=curve, **{name: fact[name] for name in _FACTS})
            )
    return Shipped(head["core"], known)


def _now(name: str) -> str | None:
    try:
        return sources.effect_digest(name)
    except FileNotFoundError:
        return None
