"""Small measured files for tests."""

from __future__ import annotations

from pathlib import Path

CSV = """experiment,specimen,cycle,branch,time_s,pressure_kPa,angle_deg,force_N
bending,A,1,loading,0,0,0.1,
bending,A,1,loading,1,25,12.5,
bending,A,1,loading,2,50,25.2,
bending,A,1,unloading,3,25,13.0,
blocked_force,A,1,loading,0,0,,0.01
blocked_force,A,1,loading,1,25,1.5,0.30
"""

TOML = """experiment = ["bending", "blocked_force"]
note = "invented"
[finger]
wall_mm = 1.8
[plate]
gap_mm = 0.5
[noise]
angle_deg = 0.3
force_N = 0.02
pressure_kPa = 0.5
"""


def written(folder: Path, csv: str = CSV, toml: str | None = TOML, name: str = "lab") -> Path:
    """The CSV, with its TOML beside it."""
    file = folder / f"{name}.csv"
    file.write_text(csv, encoding="utf-8")
    if toml is not None:
        file.with_suffix(".toml").write_text(toml, encoding="utf-8")
    return file
