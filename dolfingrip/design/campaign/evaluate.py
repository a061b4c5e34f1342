"""A design as a job: its configuration goes to an objective function, its numbers come back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from math import isfinite
from typing import Any, Final

from dolfingrip.jobs.job import Data, JobFailure
from dolfingrip.jobs.work import found

FUNCTION: Final = "dolfingrip.design.campaign.evaluate:evaluate"
"""Import path of :func:`evaluate`."""


@dataclass(slots=True)
class Outcome:
    """What an objective function returns.

    Attributes:
        outputs: number by quantity, the unit in its name.
        gradients: by output its derivatives, by key of the parameter; None where not computed.
        curve: the readings, by column.
        iterations: of Newton's method.
        versions: of the software that computed it, by package.
    """

    outputs: dict[str, float]
    gradients: dict[str, dict[str, float]] | None = None
    curve: dict[str, Any] | None = None
    iterations: int | None = None
    versions: dict[str, str] = field(default_factory=dict)


Objective = Callable[..., Outcome]
"""From a configuration, the wanted quantities and the number of MPI ranks to their numbers; where
derivatives are asked for, also from the keys of their parameters. It raises
:class:`~dolfingrip.jobs.job.JobFailure` where there is no result, whose ``partial`` may have a
``curve``."""


def evaluate(
    config: Data,
    quantities: Sequence[str],
    objective: str,
    ranks: int = 1,
    gradients: Sequence[str] | None = None,
    fields: str | None = None,
) -> Data:
    """Compute a design.

    Args:
        config: resolved.
        quantities: outputs that are wanted.
        objective: import path ``module:function`` of an :data:`Objective`.
        ranks: MPI processes that the design runs on.
        gradients: keys of parameters that the quantities are derived by, () for all; None for what
            the objective derives anyway.
        fields: folder that the objective keeps its results with fields in; None where it keeps
            none.

    Returns:
        The fields of an :class:`Outcome`.

    Raises:
        JobFailure: where there is no result.
        ConfigError: where there is no such design.
    """
    function: Objective = found(objective)
    keys = () if gradients is None else (tuple(gradients),)
    kept = {} if fields is None else {"fields": fields}
    outcome = function(config, tuple(quantities), ranks, *keys, **kept)
    missing = [q for q in quantities if not isfinite(outcome.outputs.get(q, float("nan")))]
    if missing:
        raise JobFailure("no number", f"{', '.join(missing)} came out as no number")
    outcome.outputs = {name: float(outcome.outputs[name]) for name in quantities}
    return asdict(outcome)
