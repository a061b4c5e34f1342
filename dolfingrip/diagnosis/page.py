"""A diagnosis, and a plan, as one page of text each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from dolfingrip.diagnosis.answer.ten_lines import chance
from dolfingrip.diagnosis.policy import PAGE, POLICY
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files.columns import TextTable
from dolfingrip.files.plan import PlanFile


def section(title: str, lines: Iterable[str]) -> list[str]:
    """Lines below a heading."""
    return ["", f"## {title}", "", *lines]


def plan_text(result: PlanFile) -> str:
    """Write a plan as one page of text.

    Args:
        result: the plan.

    Returns:
        Markdown.
    """
    rig = ", ".join(result.experiments)
    lines = [
        f"# {rig}: {100 * result.share:.0f} % of the effects of the catalogue would be named, "
        f"{100 * result.class_share:.0f} % up to effects that change these readings alike",
        "",
        f"{result.readings} readings in {result.minutes:.1f} minutes of pressure. Named: a "
        "diagnosis of these readings would answer with this effect alone. Assumed: one effect "
        "acts, at a strength from its prior, under the noise of these instruments; in "
        f"{100 * (1 - POLICY.discrepancy_off):.0f} % of cases something acts beside it that no "
        "effect is.",
        "",
    ]
    rows = [
        [each.effect, each.ordinary, f"{each.strength_sigma:.1f}",
         "–" if each.named_from is None else f"{each.named_from:.2g}", f"{each.share:.2f}",
         f"{each.class_share:.2f}", _listed(each.confused_with)]
        for each in result.effects
    ]  # fmt: skip
    headings = ["effect", "ordinary strength", "σ", "from × ordinary", "named", "its class",
                "not told from"]  # fmt: skip
    lines += TextTable(headings, rows).markdown()
    if result.additions:
        rows = [
            [each.name, f"{each.minutes:.0f}", f"{each.share:.2f}",
             f"{100 * each.gain_per_minute:+.2f} %", _listed(each.lifts)]
            for each in result.additions
        ]  # fmt: skip
        headings = ["addition", "minutes", "share named", "gain per minute", "newly named"]
        lines += section("Additions", TextTable(headings, rows).markdown())
    if result.warnings:
        lines += section("Beware", (f"- {each}" for each in result.warnings))
    return "\n".join(lines) + "\n"


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - PAGE.in_a_cell} more" if len(names) > PAGE.in_a_cell else ""
    return ", ".join(names[: PAGE.in_a_cell]) + more or "–"


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
