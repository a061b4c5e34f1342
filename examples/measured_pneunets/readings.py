"""Make the tables of docs/measured_pneunets.md from the files that their authors published.

Neither source states a licence, so this package holds how the actuators are built, and no reading
of them. Each table gets a TOML that tells the set-up, and what the source does not tell.

    git clone https://github.com/fahimiah34/Printable_Robotics-PneuNet printed
    git clone https://github.com/sw06045/IIB-Project-Soft-Gripper cast
    scripts/run python examples/measured_pneunets/readings.py printed cast

Sources: PneuNet_Experimental-Numerical_Comparison.m of the first, commit da53c660; of the second
Raw Data/Contact Experiments/Normal Contact Force Experiment.xlsx, commit 4ded06ce (IROS 2022,
doi 10.1109/IROS47612.2022.9982126).
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import pandas as pd

OUT = Path("out/measured_pneunets")
N_PER_GRAM = 0.00981
GAPS_mm = (0, 2)
"""Settings that are diagnosed; the tip hardly touches beyond."""
MEMBERS = (1, 4)
"""How many actuators may have pressed on the scale at once."""

PRINTED = """experiment = "bending"
rate_kPa_per_s = 2.0            # not told

[noise]                         # standard deviations: whole degrees
{column} = 0.5
pressure_kPa = 2.0

[nuisance]                      # standard deviations
modulus = 1.0                   # where a diagnosis begins is a guess
wall = 0.125                    # relative; 1.2 mm, printed with 1.35 times the material
"""

CAST = """experiment = "blocked_force"
rate_kPa_per_s = 2.0            # not told

[plate]
gap_mm = {gap_mm}.0

[noise]                         # standard deviations; the force from the scatter of four runs
force_N = {noise_N}
pressure_kPa = 1.0

[nuisance]                      # standard deviations
modulus = 1.0                   # the silicone is not named
plate_gap_mm = 0.3
pressure_offset_kPa = 5.0
pneunet.base_mm = 0.3           # the base is 2.5 to 3.5 mm
"""


def printed(source: Path) -> list[Path]:
    """Write the angle of the printed pneu-net as the tip's and as the chord's; list the files."""
    text = (source / "PneuNet_Experimental-Numerical_Comparison.m").read_text("utf-8")
    found = dict(re.findall(r"(\w+) = \[?([\d:., ]+)", text))
    first, step, last = map(int, found["P"].split(":"))
    angles = [float(each) for each in found["B_experimental"].split(",")]
    made = []
    for name, column in {"tip": "angle_deg", "chord": "chord_angle_deg"}.items():
        table = pd.DataFrame({"pressure_kPa": range(first, last + 1, step), column: angles})
        made.append(_written(table, OUT / "printed" / name, PRINTED.format(column=column)))
    author = [float(each) for each in found["B_comsol"].split(",")]
    table = pd.DataFrame({"pressure_kPa": range(first, last + 1, step), "angle_deg": author})
    table.to_csv(OUT / "printed" / "author.csv", index=False)  # by COMSOL, not measured
    return made


def cast(source: Path) -> list[Path]:
    """Write runs 2 to 5 of the cast pneu-net, by the gap and the number that pressed."""
    file = source / "Raw Data" / "Contact Experiments" / "Normal Contact Force Experiment.xlsx"
    rows, gap_mm = [], 0
    for label, volt, _, *grams in pd.read_excel(file, header=None, usecols=range(8)).to_numpy():
        if isinstance(label, str):
            gap_mm = int(label.removesuffix("mm"))
        elif not pd.isna(volt):
            kPa = 59.092 * volt - 94.002  # the source's own
            rows += [(gap_mm, run, kPa, g) for run, g in enumerate(grams) if run and not pd.isna(g)]
    every = pd.DataFrame(rows, columns=["gap_mm", "cycle", "pressure_kPa", "grams"])
    made = []
    for members in MEMBERS:
        (OUT / f"cast{members}").mkdir(parents=True, exist_ok=True)
        force = every.assign(force_N=every["grams"] * N_PER_GRAM / members)
        force.to_csv(OUT / f"cast{members}" / "every.csv", index=False)
        for gap_mm in GAPS_mm:
            own = force[force["gap_mm"] == gap_mm].sort_values("cycle", kind="stable")
            told = CAST.format(gap_mm=gap_mm, noise_N=0.04 / members)
            columns = ["cycle", "pressure_kPa", "force_N"]
            made.append(_written(own[columns], OUT / f"cast{members}" / f"gap{gap_mm}", told))
    return made


def _written(table: pd.DataFrame, to: Path, told: str) -> Path:
    """A table beside its TOML."""
    to.parent.mkdir(parents=True, exist_ok=True)
    table.to_csv(to.with_suffix(".csv"), index=False, float_format="%.5g")
    to.with_suffix(".toml").write_text(told, "utf-8")
    return to.with_suffix(".csv")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("printed", type=Path, help="copy of the first source")
    parser.add_argument("cast", type=Path, help="copy of the second source")
    asked = parser.parse_args()
    for file in (*printed(asked.printed), *cast(asked.cast)):
        print(file)
