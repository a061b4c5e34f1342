"""The quantities of a design by their names, by simulation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dolfingrip import config as configuration
from dolfingrip.design.quantities.index import SOURCES, parse
from dolfingrip.design.quantities.quantity import AskedDesign, Outcome
from dolfingrip.jobs.job import Data


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

    asked = AskedDesign(
        configuration.from_dict(config), keys, ranks, None if fields is None else Path(fields)
    )
    outcome = Outcome({}, {}, {}, 0, record.versions())
    wanted = [parse(text) for text in quantities]
    for source in SOURCES:
        some = [each for each in wanted if each.name in source.names]
        if some:
            source.add(outcome, some, asked)
    slopes = outcome.gradients or {}
    outcome.gradients = {text: slopes[text] for text in quantities if slopes.get(text)}
    return outcome
