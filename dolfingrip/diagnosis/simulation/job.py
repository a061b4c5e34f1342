"""One simulation of a diagnosis, named by all that its result depends on."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config, from_dict
from dolfingrip.diagnosis.data.columns import NUMBERS, READINGS
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.experiments.decisive import decisive, digest_of
from dolfingrip.jobs import job as jobs
from dolfingrip.jobs.job import Data, JobFailure, content_key
from dolfingrip.jobs.store import Shared, same
from dolfingrip.sections.geometry.index import TABLES

FORMAT: Final = 1
"""Version of what a result holds and a key means; to be raised where the same configuration gives
other results. A result of another version is computed again, and of an experiment that had fewer
channels."""

FUNCTION: Final = "dolfingrip.diagnosis.simulation.job:simulate"
"""Import path of what computes a job."""

_OF_COUPON: Final = ("material", "solver", "coupon", "protocol", "extensions")
_OF_FINGER: Final = (
    *TABLES, "material", "film", "cavity", "mesh", "form", "morph", "solver", "contact", "plate",
    "gravity", "camera", "protocol", "extensions",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Job:
    """An experiment on a configuration, with its protocol, and the derivatives that are wanted.

    Attributes:
        experiment: its name.
        config: all that the simulation depends on.
        gradients: keys of parameters that all readings are derived by; none where empty.
    """

    experiment: str
    config: Config
    gradients: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """Hash of the content: of the same key is the same result."""
        return content_key(self._content())

    @property
    def key_without_protocol(self) -> str:
        """The same of all but the protocol and the derivatives."""
        content = self._content()
        del content["config"]["protocol"], content["gradients"]
        return content_key(content)

    def _content(self) -> dict[str, Any]:
        plain = self.config.model_dump(mode="json")
        felt = decisive(plain, digest_of(self.config.mesh.file))
        sections = _OF_COUPON if self.experiment == "coupon" else _OF_FINGER
        return {
            "format": FORMAT + max(CHANNELS[name].added for name in READINGS[self.experiment]),
            "experiment": self.experiment,
            "gradients": sorted(self.gradients),
            "config": {name: felt[name] for name in sections if name in felt},
        }

    def call(self) -> jobs.Job:
        """The call of :func:`simulate` that computes it."""
        arguments = {
            "experiment": self.experiment,
            "gradients": list(self.gradients),
            "config": self.config.model_dump(mode="json"),
        }
        return jobs.Job(self.key, FUNCTION, arguments)


@dataclass(frozen=True, slots=True)
class JobResult:
    """What a job gave.

    Attributes:
        columns: (reached,) readings by column, at the stops that were reached.
        slopes: likewise their derivatives, by column and parameter.
        failure_class, failure: why not all stops were reached, as class and sentence; None where
            all were.
        wall_s: time that it took.
    """

    columns: Mapping[str, np.ndarray] = field(default_factory=dict)
    slopes: Mapping[tuple[str, str], np.ndarray] = field(default_factory=dict)
    failure_class: str | None = None
    failure: str | None = None
    wall_s: float | None = None


SHARED: Final[Shared] = same(function=FUNCTION)
"""What the jobs of a store have in common."""


def calls(jobs_: Sequence[Job]) -> list[jobs.Job]:
    """Calls in the order of the jobs, each once."""
    return list({job.key: job.call() for job in jobs_}.values())


def simulate(experiment: str, config: Data, gradients: Sequence[str]) -> Data:
    """Compute a job on a worker.

    Args:
        experiment: its name.
        config: resolved.
        gradients: keys of parameters that all readings are derived by; none where empty.

    Returns:
        ``curve`` with readings and derivatives, ``iterations``, ``versions``.

    Raises:
        JobFailure: where not all stops were reached; with what was read before.
        ConfigError: where there is no such finger.
    """
    from mpi4py import MPI

    from dolfingrip.experiments import run
    from dolfingrip.experiments.results import record

    # States beyond a snap are not what was measured up to there, and cost most of the time. How far
    # a path goes beyond its last stop is never read.
    given = from_dict(config)
    shortest = max(given.solver.min_step_kPa, POLICY.shortest_step * given.solver.max_step_kPa)
    plain = given.changed(experiment={"snaps": False}, solver={"min_step_kPa": shortest})
    result = run(experiment, plain, comm=MPI.COMM_SELF, gradients=gradients or None)
    curve: dict[str, list[float]] = {}
    for name in NUMBERS:
        if any(name in row for row in result.rows):
            curve[name] = [float(value) for value in result.column(name)]
    for slope in result.sensitivities:
        if slope["column"] in NUMBERS:
            name = json.dumps([slope["column"], slope["parameter"]])
            curve.setdefault(name, []).append(float(slope["derivative"]))
    if result.failure is not None:
        raise JobFailure(str(result.failure.kind), result.failure.sentence(), {"curve": curve})
    iterations = result.facts.newton.iterations
    return {"curve": curve, "iterations": iterations, "versions": record.versions()}


def result_of(row: Mapping[str, Any]) -> JobResult:
    """The result in a row of the store."""
    columns: dict[str, np.ndarray] = {}
    slopes: dict[tuple[str, str], np.ndarray] = {}
    for name, values in (row["result"] or row["partial"] or {"curve": {}})["curve"].items():
        numbers = np.array([np.nan if value is None else value for value in values], dtype=float)
        if name.startswith("["):
            column, parameter = json.loads(name)
            slopes[column, parameter] = numbers
        else:
            columns[name] = numbers
    return JobResult(columns, slopes, row["failure_class"], row["failure"], row["wall_s"])
