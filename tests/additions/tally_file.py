"""``tally.json``: how many fingers were printed."""

from __future__ import annotations

from typing import ClassVar, Literal

from dolfingrip.files.result_file import ResultFile


class TallyFile(ResultFile):
    """Contents of ``tally.json``."""

    FILE: ClassVar[str] = "tally.json"
    MADE_BY: ClassVar[str] = "the workshop"

    schema_version: Literal[1] = 1
    days: tuple[int, ...]
    printed: tuple[int, ...]
