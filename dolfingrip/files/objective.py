"""What a front trades off, in result files."""

from __future__ import annotations

from pydantic import Field

from dolfingrip.files.result_file import Part


class NamedObjective(Part):
    """One of the objectives of a front."""

    name: str = Field(description="of the reading or of the number of the shape")
    unit: str = Field("", description="as printed")
    sense: str = Field(description="at most, minimise or maximise")
    where: str = Field("", description="where it is read, in words")

    @property
    def title(self) -> str:
        """The name with the place where it is read."""
        return f"{self.name} {self.where}".rstrip()
