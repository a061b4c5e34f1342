"""A design as a job: its configuration goes to an objective function, its numbers come back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import Final

from dolfingrip import config as configuration
from dolfingrip.design.quantities.index import SOURCES, parse
from dolfingrip.design.quantities.quantity import AskedDesign, Outcome, Quantity, QuantitySource
from dolfingrip.jobs.job import Data, JobFailure
from dolfingrip.jobs.work import found

FUNCTION: Final = "dolfingrip.design.campaign.objective:evaluate"
"""Import path of :func:`evaluate`."""


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
        The fields of an :class:`~dolfingrip.design.quantities.quantity.Outcome`.

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


def simulate(
    config: Data,
    quantities: tuple[str, ...],
    ranks: int,
    keys: Sequence[str] | None = None,
    fields: str | None = None,
) -> Outcome:
    """Compute a design in this process, or on several ranks under ``mpirun``.

    Args:
        config: resolved, as nested dictionaries.
        quantities: outputs that are wanted, by their texts.
        ranks: MPI processes.
        keys: of parameters that the outputs are derived by, () for all; None for ξ1 and ξ2 where
            the adjoint gives them.
        fields: folder for a result of each experiment with its fields; None: none is written.

    Returns:
        The outputs, their derivatives, and the curves that they are read from.

    Raises:
        JobFailure: where there is no result.
        ConfigError: where there is no such finger, or no such parameter of it.
        MachineError: where a rank died.
    """
    from dolfingrip.experiments.results import record

    design = AskedDesign(
        configuration.from_dict(config), keys, ranks, None if fields is None else Path(fields)
    )
    outcome = Outcome({}, {}, {}, 0, record.versions())
    for source, wanted in _by_source(quantities):
        source.add(outcome, wanted, design)
    slopes = outcome.gradients or {}
    outcome.gradients = {text: slopes[text] for text in quantities if slopes.get(text)}
    return outcome


def check_quantities(quantities: Sequence[str], design: AskedDesign) -> None:
    """Refuse quantities that :func:`simulate` can compute of no design.

    Args:
        quantities: by their texts.
        design: that the designs are varied from.

    Raises:
        ConfigError: one line.
    """
    for source, wanted in _by_source(quantities):
        source.check_design(wanted, design)


def _by_source(texts: Sequence[str]) -> Iterator[tuple[QuantitySource, list[Quantity]]]:
    """Yield the quantities by what computes them."""
    quantities = [parse(text) for text in texts]
    for source in SOURCES:
        wanted = [quantity for quantity in quantities if quantity.name in source.names]
        if wanted:
            yield source, wanted
