"""The file of answers that come with the package, written: what a diagnosis reads is there."""

from __future__ import annotations

import gzip
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import TypeAdapter

from dolfingrip.diagnosis.simulation import runner
from dolfingrip.diagnosis.simulation.runner import Known, key_without_protocol, protocol_of
from dolfingrip.experiments.request import FORMAT, Answer, Request
from dolfingrip.files import whole

DIGITS: Final = 7
"""Of each number that is kept."""


def write(
    file: Path, requests: Iterable[Request], answers: Iterable[Answer], *, keep: bool = False
) -> None:
    """Write answers into a file.

    Args:
        file: where.
        requests: that were computed.
        answers: what each gave.
        keep: what the file has beside them stays.
    """
    known = runner.shipped(file) if keep else None
    every = [] if known is None else [*known.known]
    every += [
        _known(request, answer)
        for request, answer in zip(requests, answers, strict=True)
        if known is None or known.entry(request) is None
    ]
    write_known(file, every)


def write_known(file: Path, every: Sequence[Known]) -> None:
    """Write entries into a file, with the digests of today's code.

    Args:
        file: where.
        every: its entries.
    """
    names = sorted({name for each in every for name in each.effects})
    effects = {name: runner.effect_digest(name) for name in names}
    rounded = [replace(each, answer=_rounded(each.answer)) for each in every]
    content = runner.Shipped(FORMAT, runner.core_digest(), effects, rounded)
    with whole.stream(file) as stream:
        told = TypeAdapter(runner.Shipped).dump_json(content, exclude={"agrees"})
        stream.write(gzip.compress(told, mtime=0))


def _rounded(answer: Answer) -> Answer:
    def digits(values: np.ndarray) -> np.ndarray:
        return np.array([float(f"{x:.{DIGITS}g}") for x in values])

    columns = {name: digits(values) for name, values in answer.columns.items()}
    slopes = {names: digits(values) for names, values in answer.slopes.items()}
    return replace(answer, columns=columns, slopes=slopes)


def restamp(file: Path) -> None:
    """Give a file the digests of today's code, which is known to compute what the file has."""
    write_known(file, runner.loaded(file).known)


def _known(request: Request, answer: Answer) -> Known:
    effects = sorted(effect.name() for effect in request.config.extensions.active())
    protocol, gradients = protocol_of(request), request.gradients or ()
    return Known(key_without_protocol(request), effects, protocol, gradients, answer)
