"""The files of a diagnosis: diagnosis.json, extended.toml, summary.md, and data for pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis import page
from dolfingrip.diagnosis.answer import results
from dolfingrip.diagnosis.answer.found import Diagnosis


@dataclass(frozen=True)
class Written:
    """What was written.

    Attributes:
        text: of the summary.
        pictures: plain data for the report.
    """

    text: str
    pictures: dict[str, Any]


def write(found: Diagnosis, data: Sequence[Path], out: Path) -> Written:
    """Write all files but the pictures into ``out``."""
    out.mkdir(parents=True, exist_ok=True)
    try:
        told = results.extended_toml(found)
        (out / "extended.toml").write_text(told, encoding="utf-8")
    except ConfigError as error:
        found.warnings.append(f"extended.toml is not written: {error}")
    result = results.outcome_of(found, [str(file) for file in data], out)
    result.write(out / "diagnosis.json")
    text = page.text(result)
    (out / "summary.md").write_text(text, encoding="utf-8")
    pictures = results.pictures(found)
    pictures["readings"].to_csv(out / "readings.csv", index=False)
    return Written(text, pictures)
