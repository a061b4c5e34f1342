"""Configurations with the table ``posterior``, which ``predict`` reads."""

from __future__ import annotations

import tomlkit

from dolfingrip.sections import tables
from dolfingrip.sections.posterior import PosteriorTable


def appended(text: str, posterior: PosteriorTable) -> str:
    """A configuration's text, followed by the table."""
    document = tomlkit.document()
    document.add(tables.POSTERIOR, tables.table(posterior))
    return f"{text}\n{tomlkit.dumps(document)}"
