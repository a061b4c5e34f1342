"""The objectives of the paper, by simulation: COG offset, blocked force, and the tip's angle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.channels import ANGLE, CONTACT_GAP, FORCE, PRESSURE
from dolfingrip.config import Config
from dolfingrip.design.campaign.evaluate import Outcome
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.jobs.job import Data, JobFailure

COG: Final = "cog_offset_mm"

QUANTITIES: Final = (COG, FORCE.name, ANGLE.name)
"""What can be computed: the undeformed centroid's offset, and the blocked force and the free
tip's angle at the highest pressure."""

EXPERIMENTS: Final = {FORCE.name: ("blocked_force", "blocked"), ANGLE.name: ("bending", "free")}
"""Experiment by the quantity that it yields, and what its columns of the curve begin with."""


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
        quantities: outputs that are wanted.
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

    resolved = configuration.from_dict(config)
    offset, slopes, labels = _cog_offset(resolved, keys)
    outcome = Outcome({COG: offset}, {COG: slopes}, {}, 0, record.versions())
    assert outcome.curve is not None
    assert outcome.gradients is not None
    assert outcome.iterations is not None
    for quantity, request in requests(resolved, quantities, ranks, keys, fields).items():
        answer = compute(request)
        outcome.curve |= _curve(answer, quantity)
        outcome.iterations += answer.iterations
        if answer.failure_class is not None:
            raise JobFailure(answer.failure_class, answer.failure or "", {"curve": outcome.curve})
        highest = int(np.argmax(answer.columns[PRESSURE.name]))
        outcome.outputs[quantity] = float(answer.columns[quantity][highest])
        found = {label: answer.slopes.get((quantity, label)) for label in labels}
        outcome.gradients[quantity] = {
            label: float(values[highest])
            for label, values in found.items()
            if values is not None and np.isfinite(values[highest])
        }
    outcome.gradients = {q: outcome.gradients[q] for q in quantities if outcome.gradients[q]}
    return outcome


def requests(
    config: Config,
    quantities: Sequence[str],
    ranks: int = 1,
    keys: Sequence[str] | None = None,
    fields: str | None = None,
) -> dict[str, Request]:
    """Return the simulations that a design's quantities are read from.

    Args:
        config: of the design.
        quantities: outputs that are wanted.
        ranks: MPI processes of each.
        keys: of parameters that the outputs are derived by, () for all; None for ξ1 and ξ2 where
            the adjoint gives them.
        fields: folder for a result of each experiment with its fields; None: none is written.

    Returns:
        The request by quantity; the COG offset needs none.
    """
    from dolfingrip.experiments.derivatives.gradients import XI, by_adjoint

    if keys is None and by_adjoint(config):
        keys = XI
    return {
        quantity: Request.of(
            name, config, keys, at_highest=True,
            columns=(PRESSURE.name, quantity, CONTACT_GAP.name),
            fields=None if fields is None else Path(fields) / name, ranks=ranks,
        )
        for quantity, (name, _) in EXPERIMENTS.items()
        if quantity in quantities
    }  # fmt: skip


def _cog_offset(
    config: Config, keys: Sequence[str] | None
) -> tuple[float, dict[str, float], list[str]]:
    """The offset (mm) and its derivatives, and what the derivatives are called, in order."""
    from dolfingrip.experiments.derivatives.choices import choices
    from dolfingrip.experiments.derivatives.gradients import XI, cog_offset_mm
    from dolfingrip.experiments.derivatives.sensitivities import chosen

    if keys is None:
        return *cog_offset_mm(config), list(XI)
    offset, slopes = cog_offset_mm(config, chosen(config, keys))
    for choice in choices(config, keys):
        slopes[choice.label] = choice.difference(offset, cog_offset_mm(choice.other, ())[0])
    return offset, slopes, list(slopes)


def _curve(answer: Answer, quantity: str) -> Mapping[str, list[float]]:
    """Readings at each pressure that was reached."""
    prefix = EXPERIMENTS[quantity][1]
    columns = {
        f"{prefix}_{PRESSURE.name}": PRESSURE.name,
        quantity: quantity,
        f"{prefix}_{CONTACT_GAP.name}": CONTACT_GAP.name,
    }
    none = np.empty(0)
    return {
        name: list(map(float, answer.columns.get(source, none))) for name, source in columns.items()
    }
