"""The generator's responses, simulated once and kept: all that cases are made of.

What has no memory is one elastic curve; what has, one run through the longest protocol of its
history, of which shorter protocols are the beginning. Simulations are kept by content, so that a
library that is stopped goes on where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from benchmarks.blind import generator
from benchmarks.blind.generator import Cause
from benchmarks.blind.outsiders import OUTSIDERS, PARTS
from benchmarks.blind.protocols import PROTOCOLS, PULL, Course, Protocol
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.simulation.job import Job, JobResult, result_of
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.secants import felt_in
from dolfingrip.jobs.store import NAME, Store

Way = Literal["curve", "history"]

BASE: Final = "base"
BASE_OF_CHANGES: Final = "base on the mesh of changes"
"""The simulation that changes are differences from, as the base itself is on another mesh."""
WALLS: Final = "base with other walls"
BASES: Final = (BASE, BASE_OF_CHANGES, WALLS)
WALL_PARTS: Final = (-0.125, -0.0625, 0.0625, 0.125)
"""Relative changes of the walls' thickness that the base is simulated with, too: 2.5 and 1.25
standard deviations. Where bellows touch, the force's derivative by the walls jumps, and other walls
move the jump."""
SLOPES: Final = ("finger.base_layer_mm", "plate.gap_mm")
"""Parameters that the base curve is derived by."""
HISTORIES: Final = ("P2", PULL, "P4", "short", "short-P4", "coupon")
"""Longest protocols; others begin like one of them."""
SHORTER: Final = 1.2
"""An effect's curve goes to so many times the highest pressure; the base's to the headroom."""
STOPS: Final = 20
"""Of the base's curve, from rest to the highest pressure."""
CHANGE_STOPS: Final = 10
"""Of an effect's, among them; changes are smoother."""
LONGEST_kPa: Final[Mapping[str, float]] = {"P4": 50.0}
"""Load steps of a history, where they are not :data:`generator.SETTINGS`'; those of a curve do not
matter, as its end does not depend on the way."""
CURVE_STEP_kPa: Final = 25.0


@dataclass(frozen=True, slots=True)
class Entry:
    """One simulation of the library.

    Attributes:
        name: of the base (one of :data:`BASES`), a cause or an outsider.
        form, part: of the cause, and its strength; of :data:`WALLS` one of :data:`WALL_PARTS`.
        experiment: that is simulated.
        way: along one curve, or through a history.
        store: name of the store that keeps it.
        job: the simulation.
    """

    name: str
    form: int
    part: float
    experiment: str
    way: Way
    store: str
    job: Job


def curve_protocol(course: Course, headroom: float, stops: int = STOPS) -> dict[str, list[Any]]:
    """A first loading to so many times the highest value of ``course``."""
    step = float(course.rows[course.control].max()) / stops
    at = [float(x) for x in step * np.arange(round(stops * headroom) + 1)]
    return {
        "time_s": [float(i) for i in range(len(at))],
        course.control: at,
        "cycle": [1] * len(at),
        "branch": ["loading"] * len(at),
    }


def entries(history: str) -> list[Entry]:
    """All simulations that protocols of a history are made of, those without memory first."""
    protocol = PROTOCOLS[history]
    found = [entry for course in protocol.courses for entry in _entries(protocol, course)]
    return sorted(found, key=lambda entry: (entry.way == "history", entry.name not in BASES))


def _entries(protocol: Protocol, course: Course) -> Iterator[Entry]:
    """Those of one test: the base, causes, and outsiders that are another geometry."""
    experiment, coupon = course.experiment, course.experiment == "coupon"
    config = generator.generating(protocol, changes=True)
    converged = config if coupon else generator.generating(protocol)
    curves = "coupon-curves" if coupon else f"{protocol.body}-curves"
    base = curve_protocol(course, 1.0 if coupon else generator.HEADROOM)
    along = curve_protocol(course, *((1.0,) if coupon else (SHORTER, CHANGE_STOPS)))

    def entry(
        name: str, form: int, part: float, changes: tuple[str, ...], told: Mapping[str, Any],
        slopes: tuple[str, ...] = (), model: Config = config,
    ) -> Entry:  # fmt: skip
        past = told is not base and told is not along
        step_kPa = LONGEST_kPa.get(protocol.name) if past else CURVE_STEP_kPa
        steps = {"max_step_kPa": step_kPa} if step_kPa else {}
        other = model.overridden(changes).changed(protocol=told, solver=steps)
        job = Job(experiment, other, slopes)
        way: Way = "history" if past else "curve"
        return Entry(name, form, part, experiment, way, protocol.name if past else curves, job)

    felt_here = [key for key in SLOPES if experiment == "blocked_force" or "plate" not in key]
    slopes = () if coupon else tuple(felt_here)
    yield entry(BASE, 0, 0.0, (), base, slopes, converged)
    if converged != config:
        yield entry(BASE_OF_CHANGES, 0, 0.0, (), base)
    if not coupon:
        wall_mm = converged.finger.wall_mm
        for part in WALL_PARTS:
            changes = (f"finger.wall_mm={wall_mm * (1 + part)!r}",)
            yield entry(WALLS, 0, part, changes, base, model=converged)
    for cause in generator.causes().values():
        if experiment in felt(cause):
            told = course.protocol() if cause.remembers else along
            for form, each in enumerate(cause.forms):
                for part in each.parts:
                    yield entry(cause.name, form, part, cause.overrides(form, part), told)
    for outsider in OUTSIDERS.values():
        if outsider.overrides is not None and protocol.body == "reference" and not coupon:
            for part in PARTS:
                yield entry(outsider.name, 0, part, outsider.overrides(part), along)


def felt(cause: Cause) -> frozenset[str]:
    """Experiments that feel a cause."""
    if cause.name == "gravity_pitch":
        return frozenset({"bending", "blocked_force"})
    return felt_in(cause.name, Config())


def compute(history: str, folder: Path, workers: Callable[[str], Workers]) -> None:
    """Simulate what is missing, store by store and test by test; elastic curves first.

    What failed in one test cannot be hidden, so that its other tests are not simulated.

    Args:
        history: whose entries are wanted.
        folder: of the stores.
        workers: where a store is computed, by its name.
    """
    wanted = entries(history)
    for store, experiment in dict.fromkeys((entry.store, entry.experiment) for entry in wanted):
        failed = failed_in(wanted, known(wanted, folder))
        jobs = [
            entry.job
            for entry in wanted
            if (entry.store, entry.experiment) == (store, experiment) and entry.name not in failed
        ]
        replace(workers(store), store=folder / store).results(jobs)


def failed_in(wanted: Sequence[Entry], found: Mapping[str, JobResult]) -> frozenset[str]:
    """Causes and outsiders of which a simulation ended early."""
    return frozenset(
        entry.name
        for entry in wanted
        if entry.name not in BASES
        and (result := found.get(entry.job.key)) is not None
        and result.failure_class is not None
    )


def known(wanted: Sequence[Entry], folder: Path) -> dict[str, JobResult]:
    """Results by key, of the entries that have been computed; others may be on their way."""
    found: dict[str, JobResult] = {}
    for name in {entry.store for entry in wanted}:
        if (folder / name / NAME).is_file():
            with Store(folder / name) as store:
                rows = [row for row in store.rows() if row["status"] != "pending"]
            found |= {row["key"]: result_of(row) for row in rows}
    return found


@dataclass(frozen=True, slots=True)
class Curve:
    """Readings along a curve or a history.

    Attributes:
        at: (stops,) pressure (kPa) or travel (mm).
        columns: (stops,) each.
        slopes: by column and parameter.
    """

    at: np.ndarray
    columns: Mapping[str, np.ndarray]
    slopes: Mapping[tuple[str, str], np.ndarray]


@dataclass(frozen=True, slots=True)
class Change:
    """How a cause changes the readings of one experiment.

    Attributes:
        way: along a curve, or through a history.
        at: (stops,) pressure (kPa) or travel (mm).
        parts: strengths; the first may be the only one.
        columns: (parts, stops) changes, by column.
    """

    way: Way
    at: np.ndarray
    parts: tuple[float, ...]
    columns: Mapping[str, np.ndarray]

    def column(self, name: str, strength: float) -> np.ndarray:
        """(stops,) at a strength: through 0 and the simulated ones."""
        known = self.columns[name]
        x = np.array(self.parts)
        powers = np.arange(1, len(x) + 1)
        weights = np.linalg.solve((x[None, :] ** powers[:, None]), strength**powers)
        return np.asarray(weights @ known)


@dataclass(frozen=True, slots=True)
class Library:
    """The responses of a history's protocols.

    Attributes:
        base: by experiment, on the converged mesh.
        walls: the same with other walls, by experiment and relative change of their thickness.
        changes: by cause or outsider, form and experiment; what is not felt is absent.
        failures: a sentence for each simulation that ended early.
        failed: causes and outsiders that they are of, which no case hides.
    """

    base: Mapping[str, Curve]
    walls: Mapping[str, Mapping[float, Curve]]
    changes: Mapping[tuple[str, int, str], Change]
    failures: tuple[str, ...] = ()
    failed: frozenset[str] = frozenset()

    def knows(self, name: str) -> bool:
        """Whether a cause or outsider was simulated without failure."""
        return any(key[0] == name for key in self.changes)


def load(history: str, folder: Path) -> Library:
    """The library of a history, as far as it has been computed.

    Raises:
        ConfigError: one line, where not even the base has been.
    """
    wanted = entries(history)
    found = known(wanted, folder)
    base: dict[str, Curve] = {}
    of_changes: dict[str, Curve] = {}
    walls: dict[str, dict[float, Curve]] = {}
    failures, missing = [], []
    kept: dict[tuple[str, int, str], list[tuple[Entry, JobResult]]] = {}
    for entry in wanted:
        result = found.get(entry.job.key)
        if result is None:
            missing.append(entry.name)
        elif entry.name in BASES:
            reached = len(next(iter(result.columns.values())))
            curve = Curve(_at(entry)[:reached], result.columns, result.slopes)
            if entry.name == WALLS:
                walls.setdefault(entry.experiment, {})[entry.part] = curve
            else:
                (base if entry.name == BASE else of_changes)[entry.experiment] = curve
        elif result.failure_class is not None:
            failures.append(f"{entry.name} in {entry.experiment}: {result.failure}")
            missing.append(entry.name)
        else:
            kept.setdefault((entry.name, entry.form, entry.experiment), []).append((entry, result))
    if set(BASES) & set(missing):
        raise ConfigError(f"{folder}: no library of {history} yet; run the stage library first")
    changes = {
        key: _change(parts, of_changes.get(key[2], base[key[2]]))
        for key, parts in kept.items()
        if key[0] not in missing
    }
    return Library(base, walls, changes, tuple(failures), failed_in(wanted, found))


def _at(entry: Entry) -> np.ndarray:
    control = "displacement_mm" if entry.experiment == "coupon" else "pressure_kPa"
    return np.array(getattr(entry.job.config.protocol, control), dtype=float)


def _change(parts: Sequence[tuple[Entry, JobResult]], base: Curve) -> Change:
    entry = parts[0][0]
    at = _at(entry)
    place = np.array([int(np.argmin(np.abs(base.at - x))) for x in at])
    if not np.allclose(base.at[place], at, atol=1e-6):
        raise ValueError(f"{entry.name}: stops that the base curve does not have")
    columns = {
        name: np.array([result.columns[name] - base.columns[name][place] for _, result in parts])
        for name in parts[0][1].columns
        if name in base.columns and name not in ("time_s", "pressure_kPa", "displacement_mm")
    }
    return Change(entry.way, at, tuple(entry.part for entry, _ in parts), columns)


def limited(library: Library, count: Callable[[str], int]) -> Library:
    """The library of a shorter protocol: histories end after ``count(experiment)`` rows."""
    changes = {
        key: change
        if change.way == "curve"
        else replace(
            change,
            at=change.at[: count(key[2])],
            columns={
                name: values[:, : count(key[2])] for name, values in change.columns.items()
            },
        )
        for key, change in library.changes.items()
    }  # fmt: skip
    return replace(library, changes=changes)


def of_protocol(protocol: Protocol, folder: Path) -> Library:
    """The library that a protocol's cases are made of."""
    library = load(protocol.history, folder)
    own = {course.experiment: len(course.rows) for course in protocol.courses}
    if "coupon" in own and "bending" in own:
        pull = load(PULL, folder)
        both = [name for name in {key[0] for key in pull.changes} if library.knows(name)]
        library = Library(
            {**library.base, **pull.base},
            library.walls,
            {
                **{key: each for key, each in library.changes.items() if _whole(key[0], pull)},
                **{key: each for key, each in pull.changes.items() if key[0] in both},
            },
            (*library.failures, *pull.failures),
            library.failed | pull.failed,
        )
    return limited(library, lambda experiment: own.get(experiment, 0))


def _whole(name: str, pull: Library) -> bool:
    """Whether the coupon's part of a cause is there, where a coupon feels it."""
    cause = generator.causes().get(name)
    return cause is None or "coupon" not in felt(cause) or pull.knows(name)
