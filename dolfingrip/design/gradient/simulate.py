"""A load path of a design as a job: readings at places of it, with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from dolfingrip import config as configuration
from dolfingrip.config import Config, felt
from dolfingrip.design.campaign import grasps
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.jobs.job import Data, Job, JobFailure, content_key

FUNCTION: Final = "dolfingrip.design.gradient.simulate:simulate"
"""Import path of :func:`simulate`."""

SCHEMA: Final = 1
"""Version of what a job computes from its arguments."""


def simulate(
    config: Data,
    made_for: Data | None,
    experiment: str,
    places: Sequence[Sequence[Any]],
    columns: Sequence[str],
    keys: Sequence[str],
) -> Data:
    """Readings at places of a design's load path.

    Args:
        config: resolved.
        made_for: configuration with the dimensions that the mesh is made for; None: ``config``.
        experiment: its name.
        places: column and value of each.
        columns: readings that are wanted.
        keys: parameters that they are derived by.

    Returns:
        ``values`` and ``gradients``, one for each place.

    Raises:
        JobFailure: where the path does not reach a place.
        ConfigError: where there is no such finger.
    """
    from mpi4py import MPI

    from dolfingrip.experiments.derivatives.answers import Ended, Place, answers

    other = None if made_for is None else configuration.from_dict(made_for).adapted().geometry
    try:
        found = answers(
            experiment,
            configuration.from_dict(config),
            [Place(str(column), float(value)) for column, value in places],
            columns,
            keys,
            MPI.COMM_SELF,
            other,
        )
    except Ended as ending:
        raise JobFailure(ending.kind, ending.sentence) from None
    return {
        "values": [each.values for each in found],
        "gradients": [each.gradients for each in found],
    }


def job(
    config: Config,
    made_for: Config | None,
    experiment: str,
    places: Sequence[tuple[str, float]],
    columns: Sequence[str],
    keys: Sequence[str],
) -> Job:
    """The job that :func:`simulate` is called by."""
    plain = config.model_dump(mode="json")
    reference = None if made_for is None else made_for.model_dump(mode="json")
    asked: Data = {
        "experiment": experiment,
        "places": [list(each) for each in places],
        "columns": list(columns),
        "keys": list(keys),
    }
    content = {
        "schema": SCHEMA,
        "config": felt(config),
        "made_for": None if made_for is None else felt(made_for),
        **asked,
    }
    arguments = {"config": plain, "made_for": reference, **asked}
    return Job(content_key(content), FUNCTION, arguments, {"experiment": experiment})


def grasp_job(config: Config) -> Job:
    """The job of a grasp, as campaigns have it."""
    (found,) = Plan(config, (), ({},), (grasps.PICKUP,), grasps.OBJECTIVE).jobs()
    return found
