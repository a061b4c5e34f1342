"""Outcomes of parts as files, kept after every run so that an interruption loses none."""

from __future__ import annotations

import datetime
import json
import platform
import statistics
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.measure import ROOT

FOLDER = ROOT / "out" / "benchmark"


@dataclass(slots=True)
class Outcome:
    """The runs of one part.

    Attributes:
        part: its name.
        facts: commit, date, machine and versions.
        runs: by label, one dictionary a repetition.
    """

    part: str
    facts: dict[str, Any] = field(default_factory=dict)
    runs: dict[str, list[dict[str, Any]]] = field(default_factory=dict)

    def median(self, label: str, key: str) -> float:
        """Median of a figure over the repetitions, NaN where there is none."""
        values = [run[key] for run in self.runs.get(label, ()) if key in run]
        return statistics.median(values) if values else float("nan")

    def last(self, label: str) -> dict[str, Any]:
        """The last repetition, {} where there is none."""
        return self.runs[label][-1] if self.runs.get(label) else {}

    def load(self) -> tuple[float, float]:
        """Lowest and highest load average at the runs' starts."""
        loads = [run["load"][0] for runs in self.runs.values() for run in runs]
        return (min(loads), max(loads)) if loads else (float("nan"), float("nan"))

    def write(self, folder: Path = FOLDER) -> None:
        """Replace the part's file."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{self.part}.json"
        partial = path.with_suffix(".part")
        content = {"part": self.part, "facts": self.facts, "runs": _rounded(self.runs)}
        partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        partial.replace(path)


def read(part: str, folder: Path = FOLDER) -> Outcome | None:
    """A part's outcome, None where it has not been run."""
    path = folder / f"{part}.json"
    if not path.exists():
        return None
    content = json.loads(path.read_text(encoding="utf-8"))
    return Outcome(content["part"], content["facts"], content["runs"])


def read_all(parts: Iterable[str], folder: Path = FOLDER) -> dict[str, Outcome]:
    """Outcomes of the parts that have been run."""
    found = {part: read(part, folder) for part in parts}
    return {part: outcome for part, outcome in found.items() if outcome is not None}


def facts() -> dict[str, Any]:
    """When, where and of what code the runs are; versions are added by the caller."""
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "commit": commit(),
        "processor": _processor(),
        "system": platform.platform(),
    }


def commit() -> str:
    """Short hash of the checkout, with + where the solver's files have changed since."""

    def git(*words: str) -> str:
        done = subprocess.run(
            ["git", "-c", f"safe.directory={ROOT}", *words],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        return done.stdout.strip()

    try:
        changed = git("status", "--porcelain", "--", "dolfingrip", "forms", "meshes")
        return (git("rev-parse", "--short", "HEAD") or "unknown") + ("+" if changed else "")
    except FileNotFoundError:
        return "unknown"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    facts = dict(line.split(":", 1) for line in lines if ":" in line)
    words = {key.strip(): value.strip() for key, value in facts.items()}
    count = sum(line.startswith("processor") for line in lines)
    name = words.get("model name", platform.machine())
    speed = f", {float(words['cpu MHz']) / 1000:.1f} GHz" if "cpu MHz" in words else ""
    return f"{name}{speed}, {count} cores"


def _rounded(value: Any) -> Any:
    """Floats to ten digits, in nested lists and dictionaries."""
    if isinstance(value, float):
        return float(f"{value:.10g}")
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    return [_rounded(item) for item in value] if isinstance(value, list) else value
