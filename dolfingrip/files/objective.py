"""What a front trades off, in result files."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from dolfingrip.files.result_file import Part

Sense = Literal["at most", "at least", "minimise", "maximise"]
"""What is done with a quantity: it is limited, or improved."""


class NamedObjective(Part):
    """One of the objectives of a front."""

    name: str = Field(description="of the reading or of the number of the shape")
    unit: str = Field("", description="as printed")
    sense: Sense = Field(description="at most or at least of one that is limited")
    where: str = Field("", description="where it is read, in words")

    @property
    def title(self) -> str:
        """The name with the place where it is read."""
        return f"{self.name} {self.where}".rstrip()

    @property
    def sign(self) -> float:
        """1 where less is better, −1 where more is."""
        return 1.0 if self.sense in ("at most", "minimise") else -1.0
