"""``plan.json``: what a rig could find out, in a versioned schema."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from dolfingrip.files.diagnosis_words import listed
from dolfingrip.files.result_file import Part, ResultFile
from dolfingrip.files.text_table import TextTable
from dolfingrip.version import __version__


class EffectOutlook(Part):
    """Outlook of one effect at a rig."""

    effect: str
    ordinary: str = Field("", description="its parameters at the ordinary strength")
    strength_sigma: float = Field(
        0.0, description="length of its change at its ordinary strength, nuisances fitted"
    )
    named_from: float | None = Field(
        None, description="strength, by the ordinary one, from which on it is rather named alone "
        "than not; null: none that occurs",
    )  # fmt: skip
    named_from_sigma: float | None = Field(None, description="that strength in standard deviations")
    class_from: float | None = Field(
        None, description="strength from which on a set of effects that has it is named"
    )
    share: float = Field(0.0, description="probability that a strength from its prior is named")
    class_share: float = Field(0.0, description="that a set that has it is")
    confused_with: tuple[str, ...] = Field(
        (), description="effects that are as probable as it about the ordinary strength, or nearly"
    )

    @property
    def at_ordinary(self) -> bool:
        """True if it is named at its ordinary strength."""
        return self.named_from is not None and self.named_from <= 1.0


class AdditionWorth(Part):
    """Worth of an addition to a rig."""

    name: str
    kind: str = Field(description="as in can_vary")
    minutes: float = Field(description="set-up included, a guess")
    share: float = Field(description="part of the effects that is named with it")
    gain_per_minute: float = Field(description="by how much that rises, by the minute")
    lifts: tuple[str, ...] = Field(
        description="effects that are named at their ordinary strength, thanks to it"
    )


class PlanFile(ResultFile):
    """Contents of ``plan.json``."""

    FILE: ClassVar[str] = "plan.json"
    MADE_BY: ClassVar[str] = "dolfingrip plan-experiment"

    schema_version: Literal[1] = 1
    version: str = Field(__version__, description="of dolfingrip")
    experiments: tuple[str, ...]
    readings: int
    minutes: float = Field(description="that the protocol takes, without setting up")
    share: float = Field(description="part of the effects named, strengths from their priors")
    class_share: float = Field(description="part of the effects whose class is named")
    effects: tuple[EffectOutlook, ...] = Field(description="the strongest first")
    additions: tuple[AdditionWorth, ...] = Field(description="the best per minute first")
    warnings: tuple[str, ...] = ()

    def tables(self) -> list[TextTable]:
        """List effects, and additions where there are some, as tables."""
        rows = [
            [effect.effect, effect.ordinary, f"{effect.strength_sigma:z.1f}",
             "–" if effect.named_from is None else f"{effect.named_from:.2g}",
             f"{effect.share:z.2f}", f"{effect.class_share:z.2f}", listed(effect.confused_with)]
            for effect in self.effects
        ]  # fmt: skip
        headings = ["effect", "ordinary strength", "σ", "from × ordinary", "named", "its class",
                    "not told from"]  # fmt: skip
        tables = [TextTable(headings, rows, "Effects")]
        if self.additions:
            rows = [
                [addition.name, f"{addition.minutes:.0f}", f"{addition.share:z.2f}",
                 f"{100 * addition.gain_per_minute:+z.2f} %", listed(addition.lifts)]
                for addition in self.additions
            ]  # fmt: skip
            headings = ["addition", "minutes", "share named", "gain per minute", "newly named"]
            tables.append(TextTable(headings, rows, "Additions"))
        return tables
