"""The job of the explorer's worker: one experiment, with its fields on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from dolfingrip.jobs.job import Data, JobFailure
from dolfingrip.jobs.single import tell

FUNCTION: Final = "dolfingrip.explore.solve:solve"
"""Import path of :func:`solve`."""


def solve(config: Data, experiment: str, out: str) -> Data:
    """Run an experiment and keep its folder.

    Args:
        config: resolved.
        experiment: its name.
        out: folder for the result.

    Returns:
        The folder, and the time it took in s.

    Raises:
        JobFailure: nothing could be solved.
        ConfigError: there is no such design.
    """
    from mpi4py import MPI

    from dolfingrip import config as configuration
    from dolfingrip.experiments import run
    from dolfingrip.experiments.index import find

    resolved = configuration.from_dict(config)
    kind = find(experiment)
    total = len(kind.schedule(kind.settings(resolved)))
    done, reached = 0, "mesh and forms"
    tell(done, total, reached)

    def advance(row: dict[str, Any]) -> None:
        nonlocal done, reached
        done += 1
        over = kind.plot.over
        reached = f"{row[over.name]:zg} {over.symbol}"
        tell(done, total, reached)

    result = run(
        kind, resolved, out=Path(out), comm=MPI.COMM_SELF, progress=advance,
        tell=lambda line: tell(done, total, line or reached),
    )  # fmt: skip
    if result.failure is not None and len(result.rows) < 2:
        raise JobFailure(str(result.failure.kind), result.failure.sentence())
    return {"folder": out, "wall_s": result.facts.wall_s}
