"""A diagnosis as one page of text."""

from __future__ import annotations

from dolfingrip.diagnosis.words import chance, section
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files.columns import TextTable


def text(result: outcome.DiagnosisFile) -> str:
    """Write a diagnosis as one page; its first ten lines are the verdict.

    Args:
        result: the diagnosis.

    Returns:
        Markdown.
    """
    lines = _brief(result.brief) if result.brief else [result.verdict.sentence]
    off = [f"- {each}" for each in result.sentences] or ["- nowhere"]
    lines += section("Where the simulation is off (nuisances fitted)", off)
    lines += section("Causes", _causes(result))
    for each in result.tables():
        lines += section(each.title, each.markdown())
    if result.downstream:
        lines += ["", f"{result.downstream.sentence}."]
    noise = [f"- {each}" for each in result.noise.sentences] or ["- as the laboratory tells it"]
    lines += section("Noise", noise)
    doubts = [*result.suspicions, *result.not_reached, *result.warnings]
    if doubts:
        lines += section("Beware", (f"- {each}" for each in doubts))
    return "\n".join(lines) + "\n"


def _brief(brief: outcome.Brief) -> list[str]:
    """The ten lines, for a reader who knows none of the methods."""
    width = max(map(len, outcome.HEADINGS.values()))
    return [
        f"{heading:<{width}}  {getattr(brief, key)}" for key, heading in outcome.HEADINGS.items()
    ]


def _causes(result: outcome.DiagnosisFile) -> list[str]:
    shown = [(each.name, each.probability) for each in result.causes if each.probability >= 0.005]
    shown += [("none", result.none), ("unknown", result.unknown)]
    rows = [[name, chance(p)] for name, p in shown]
    return TextTable(["cause", "probability that it takes part"], rows).markdown()
