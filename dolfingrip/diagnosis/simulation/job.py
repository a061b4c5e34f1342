"""One simulation of a diagnosis, named by all that its result depends on."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config, from_dict
from dolfingrip.design.campaign.answer import DesignFailure, Outcome
from dolfingrip.design.campaign.plan import SCHEMA, Design, content_key, decisive, digest_of
from dolfingrip.diagnosis.data.columns import NUMBERS, READINGS
from dolfingrip.sections.geometry.index import TABLES

FORMAT: Final = 1
"""Version of what a result holds and a key means; to be raised where the same configuration gives
other results. A result of another version is computed again, and of an experiment that had fewer
channels."""

OBJECTIVE: Final = "dolfingrip.diagnosis.simulation.job:simulate"
"""Import path of what computes a job."""

_OF_COUPON: Final = ("material", "solver", "coupon", "protocol", "extensions")
_OF_FINGER: Final = (
    *TABLES, "material", "film", "mesh", "morph", "solver", "contact", "plate",
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
            "config": {name: felt[name] for name in sections},
        }

    def design(self) -> Design:
        """As the campaign's engine takes it."""
        config = {
            "experiment": self.experiment,
            "gradients": list(self.gradients),
            "config": self.config.model_dump(mode="json"),
        }
        return Design(self.key, {}, config)


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


@dataclass(frozen=True, slots=True)
class Batch:
    """Jobs as the work of a campaign."""

    jobs: Sequence[Job]
    quantities: tuple[str, ...] = ()
    objective: str = OBJECTIVE
    gradients: tuple[str, ...] | None = None  # each job tells its own

    def designs(self) -> list[Design]:
        """The jobs in order, each once."""
        return list({job.key: job.design() for job in self.jobs}.values())

    def facts(self) -> dict[str, Any]:
        """Jobs have nothing in common but the format."""
        return {
            "schema": SCHEMA,
            "objective": self.objective,
            "quantities": [],
            "parameters": [],
            "base": {},
        }


def simulate(job: dict[str, Any], quantities: tuple[str, ...], ranks: int) -> Outcome:
    """Compute a job on a worker.

    Args:
        job: ``experiment``, ``gradients`` and ``config`` as :meth:`Job.design` gives them.
        quantities: of no meaning here.
        ranks: MPI processes; one.

    Raises:
        DesignFailure: where not all stops were reached; with what was read before.
        ConfigError: where there is no such finger.
    """
    from mpi4py import MPI

    from dolfingrip.experiments import run
    from dolfingrip.experiments.results import record

    resolved = from_dict(job["config"])
    gradients = job["gradients"] or None
    result = run(job["experiment"], resolved, comm=MPI.COMM_SELF, gradients=gradients)
    curve: dict[str, list[float]] = {}
    for name in NUMBERS:
        if any(name in row for row in result.rows):
            curve[name] = [float(value) for value in result.column(name)]
    for slope in result.sensitivities:
        if slope["column"] in NUMBERS:
            name = json.dumps([slope["column"], slope["parameter"]])
            curve.setdefault(name, []).append(float(slope["derivative"]))
    if result.failure is not None:
        raise DesignFailure(str(result.failure.kind), result.failure.sentence(), curve)
    iterations = result.facts["newton"]["iterations"]
    return Outcome({}, curve=curve, iterations=iterations, versions=record.versions())


def result_of(row: Mapping[str, Any]) -> JobResult:
    """The result in a row of the store."""
    columns: dict[str, np.ndarray] = {}
    slopes: dict[tuple[str, str], np.ndarray] = {}
    for name, values in (row["curve"] or {}).items():
        numbers = np.array([np.nan if value is None else value for value in values], dtype=float)
        if name.startswith("["):
            column, parameter = json.loads(name)
            slopes[column, parameter] = numbers
        else:
            columns[name] = numbers
    return JobResult(columns, slopes, row["failure_class"], row["failure"], row["wall_s"])
