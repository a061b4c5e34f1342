"""The ten lines that a diagnosis begins with, for a reader who knows none of its methods."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from dolfingrip.diagnosis.outcome import Brief, DiagnosisFile
from dolfingrip.extensions.index import NAMES, effect

HEADINGS: Final = {
    "result": "RESULT",
    "size": "SIZE",
    "fit": "FIT",
    "check": "CHECK",
    "not_explained": "NOT EXPLAINED",
    "also_possible": "ALSO POSSIBLE",
    "cannot_be_seen": "CANNOT BE SEEN HERE",
    "assumed": "ASSUMED",
    "do_next": "DO NEXT",
    "use_it": "USE IT",
}
"""Headings of the lines, in their order."""

NUISANCES: Final = {
    "coupon_slack_mm": "the force of the coupons begins at another travel than was told",
    "coupon.gauge_length_mm": "another gauge length than was told",
    "coupon_area": "another cross-section of the coupons than was told",
    "modulus": "a stiffer or softer material",
}
"""Causes that are no effects of the catalogue, in words."""


def in_words(name: str) -> str:
    """A cause in words, its name in brackets."""
    if name in NAMES:
        told = (effect(name).__doc__ or name).strip().splitlines()[0].rstrip(".")
        told = told.partition(" (")[0]
        return f"{told[0].lower()}{told[1:]} ({name})"
    return f"{NUISANCES.get(name, name)} ({name})"


IN_WORDS: Final = 3
"""So many causes of a set are told in words, the rest by their names."""


def one_of(names: Sequence[str]) -> str:
    """Causes that cannot be told apart, the most probable first."""
    told = [in_words(name) for name in names[:IN_WORDS]]
    text = told[0] if len(told) == 1 else " or ".join(told)
    rest = names[IN_WORDS:]
    return f"{text} or, less probably, {' or '.join(rest)}" if rest else text


def lines(brief: Brief) -> list[str]:
    """The ten lines."""
    width = max(map(len, HEADINGS.values()))
    return [f"{heading:<{width}}  {getattr(brief, key)}" for key, heading in HEADINGS.items()]


def with_doubts(result: DiagnosisFile, sentence: str) -> str:
    """A result, doubts about the data first."""
    if result.not_reached:
        sentence = f"Not all readings are compared: {result.not_reached[0]}. {sentence}"
    if not result.suspicions:
        return sentence
    return f"Check the data first: {' Or: '.join(result.suspicions[:2])} Then: {sentence}"
