"""Charts of a plan: each effect's strength, the strength from which it is named, additions."""

from __future__ import annotations

from typing import Final

from dolfingrip.charts.chart import Axis, Chart, Colour, Mark, Series
from dolfingrip.charts.picture import Look
from dolfingrip.files.plan import EffectOutlook, PlanFile

FAINTEST_SIGMA: Final = 0.3
"""Strength (σ) below which a bar ends."""

ROW_IN: Final = 0.19
"""Height of an effect's line, in inches."""

KINDS: Final[dict[str, Colour]] = {
    "named alone in half of cases or more": "green",
    "its class is": "blue",
    "neither": "pale",
}


def look(plan: PlanFile) -> Look:
    """Size the picture of a plan.

    Args:
        plan: what is drawn.

    Returns:
        A look with a line for each effect.
    """
    lines = max(len(plan.effects), 2 * len(plan.additions) + 4)
    return Look(panel_in=(5.5, 1.1 + ROW_IN * lines), dpi=130, key="below")


def _kind(effect: EffectOutlook) -> str:
    alone, with_class, neither = KINDS
    return alone if effect.share >= 0.5 else with_class if effect.class_share >= 0.5 else neither


def charts(plan: PlanFile) -> list[Chart]:
    """Make the charts of a plan.

    Args:
        plan: what a rig could find out.

    Returns:
        Bars of the effects, and of the additions if there are any.
    """
    bars = []
    for name, colour in KINDS.items():
        of_kind = [(i, effect) for i, effect in enumerate(plan.effects) if _kind(effect) == name]
        length = [max(effect.strength_sigma, FAINTEST_SIGMA) for _, effect in of_kind]
        bars.append(Series(name, length, [i for i, _ in of_kind], "bar", colour=colour))
    named = [
        (effect.named_from_sigma, i)
        for i, effect in enumerate(plan.effects)
        if effect.named_from_sigma is not None
    ]
    from_here = Series("named alone from here on", [x for x, _ in named], [y for _, y in named],
                       "points", colour="ink", marker="|")  # fmt: skip
    drawn = [
        Chart(
            "Effects",
            Axis("Change of the readings by an ordinary strength (σ)", "σ", log=True,
                 ends=(FAINTEST_SIGMA, None)),
            Axis("", names=[effect.effect.replace("_", " ") for effect in plan.effects]),
            [*bars, from_here],
        )
    ]  # fmt: skip
    if plan.additions:
        rows = sorted(plan.additions, key=lambda row: -row.share)
        said = [f"{100 * row.gain_per_minute:+z.2f} % a minute" for row in rows]
        shares = [100 * row.share for row in rows]
        drawn.append(
            Chart(
                "Additions",
                Axis("Effects that are named (%)", "%", ends=(0.0, 100.0)),
                Axis("", names=[f"{row.name} ({row.minutes:.0f}\u00a0min)" for row in rows]),
                [Series("", shares, range(len(rows)), "bar", colour="orange", said=said)],
                [Mark(100 * plan.share, "the rig as it is", "x")],
            )
        )
    return drawn
