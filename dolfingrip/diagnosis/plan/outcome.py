"""``plan.json``: what a rig could find out, with a versioned schema; and the same as text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from dolfingrip import __version__
from dolfingrip.diagnosis.outcome import Outcome, Part
from dolfingrip.diagnosis.policy import PAGE, POLICY
from dolfingrip.diagnosis.words import section, table


class Effect(Part):
    """What the rig says about one effect."""

    effect: str
    ordinary: str = Field("", description="its parameters at the ordinary strength")
    strength_sigma: float = Field(
        0.0, description="length of its change at its ordinary strength, nuisances fitted"
    )
    named_from: float | None = Field(
        None, description="strength, by the ordinary one, from which on it is rather named alone "
        "than not; null: none that occurs",
    )  # fmt: skip
    named_from_sigma: float | None = Field(None, description="the same in standard deviations")
    class_from: float | None = Field(None, description="the same for a set of effects that has it")
    share: float = Field(0.0, description="probability that a strength from its prior is named")
    class_share: float = Field(0.0, description="that a set that has it is")
    confused_with: tuple[str, ...] = Field(
        (), description="effects that are as probable as it about the ordinary strength, or nearly"
    )
    sure: int | None = Field(
        None, exclude=True, description="place among the strengths from which on all draws are "
        "named alone; not written",
    )  # fmt: skip

    @property
    def at_ordinary(self) -> bool:
        """Whether it is named at its ordinary strength."""
        return self.named_from is not None and self.named_from <= 1.0


class Addition(Part):
    """What an addition buys."""

    name: str
    kind: str = Field(description="as in can_vary")
    minutes: float = Field(description="set-up included, a guess")
    share: float = Field(description="part of the effects that is named with it")
    gain_per_minute: float = Field(description="by how much that rises, by the minute")
    lifts: tuple[str, ...] = Field(
        description="effects that are named at their ordinary strength, thanks to it"
    )


class Plan(Outcome):
    """What a rig could find out."""

    schema_version: Literal[1] = 1
    version: str = Field(__version__, description="of dolfingrip")
    experiments: tuple[str, ...]
    readings: int
    minutes: float = Field(description="that the protocol takes, without setting up")
    share: float = Field(description="part of the effects named, strengths from their priors")
    class_share: float = Field(description="part of the effects whose class is named")
    effects: tuple[Effect, ...] = Field(description="the strongest first")
    additions: tuple[Addition, ...] = Field(description="the best per minute first")
    warnings: tuple[str, ...] = ()


def text(result: Plan) -> str:
    """One page."""
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
    effects = []
    for each in result.effects:
        least = "–" if each.named_from is None else f"{each.named_from:.2g}"
        effects.append(
            f"| {each.effect} | {each.ordinary} | {each.strength_sigma:.1f} | {least} | "
            f"{each.share:.2f} | {each.class_share:.2f} | {_listed(each.confused_with)} |"
        )
    lines += table(
        "| effect | ordinary strength | σ | from × ordinary | named | its class | not told from |",
        effects,
    )
    if result.additions:
        additions = (
            f"| {each.name} | {each.minutes:.0f} | {each.share:.2f} | "
            f"{100 * each.gain_per_minute:+.2f} % | {_listed(each.lifts)} |"
            for each in result.additions
        )
        columns = "| addition | minutes | share named | gain per minute | newly named |"
        lines += section("Additions", table(columns, additions))
    if result.warnings:
        lines += section("Beware", (f"- {each}" for each in result.warnings))
    return "\n".join(lines) + "\n"


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - PAGE.in_a_cell} more" if len(names) > PAGE.in_a_cell else ""
    return ", ".join(names[: PAGE.in_a_cell]) + more or "–"
