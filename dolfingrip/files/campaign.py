"""``campaign.json``: the designs of a campaign, and what they share."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from pydantic import Field

from dolfingrip.files.result_file import Part, ResultFile


class CampaignDesign(Part):
    """A design of a campaign."""

    key: str = Field(description="hash of all that it depends on")
    status: Literal["pending", "done", "failed"]
    inputs: dict[str, float | int | str] = Field(description="value of what the campaign varies")
    outputs: dict[str, float] | None = Field(None, description="quantities; null: not done")
    gradients: dict[str, dict[str, float]] | None = Field(
        None, description="of each quantity the derivatives by parameters"
    )
    curve: dict[str, Any] | None = Field(None, exclude=True, description="readings, by column")
    iterations: int | None = None
    versions: dict[str, str] | None = None
    failure_class: str | None = None
    failure: str | None = None
    started_at: str | None = None
    wall_s: float | None = None
    worker: str | None = None


class CampaignFile(ResultFile):
    """Contents of ``campaign.json``."""

    FILE: ClassVar[str] = "campaign.json"
    MADE_BY: ClassVar[str] = "dolfingrip doe"

    schema_version: Literal[1] = 1
    parameters: tuple[str, ...] = Field(description="that the campaign varies")
    quantities: tuple[str, ...] = Field(description="outputs of each design")
    objective: str = Field("", description="import path of what computes a design")
    base: dict[str, Any] = Field({}, description="configuration that the inputs are set in")
    designs: tuple[CampaignDesign, ...] = Field(description="in the order of entry")

    def by_key(self) -> dict[str, CampaignDesign]:
        """Designs by their keys."""
        return {design.key: design for design in self.designs}
