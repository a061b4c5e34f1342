"""Find what a simulation gets wrong about a measured silicone actuator.

A block of Ecoflex 30 with five chambers bends by 2.5° at 20 kPa. The model has the modulus of a
coupon, μ = 0.0204 MPa, and a film of 50 N/mm that hardly stretches. It bends too far. Two numbers
are not known: the source of the data calls the chambers 8 mm wide, and 4 mm in one place, and
nobody measured the film. The laboratory's TOML says so, as standard deviations under
``[nuisance]``. What these explain is no cause; the diagnosis tells how far off each then is:

    y = y₀ + Σ N_k z_k + noise,    z_k ~ N(0, 1),    N_k = ∂y/∂θ_k σ_k

Instruments are asked beside them: a camera whose scale is off, and a regulator's.

    scripts/run python examples/diagnose_actuator.py

With ``--blocked`` the force of the tip on a load cell is diagnosed beside the free bending, and
what holds and touches the actuator is asked, too: its clamp, and the place, tilt, friction and
compliance of the block on the cell.

    scripts/run python examples/diagnose_actuator.py --blocked c5-w7    # or c7-w7

Source of the readings: P. Moseley et al., Advanced Engineering Materials 18 (2016).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import pandas as pd
import tomlkit

from dolfingrip import config
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.diagnosis.results import write
from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.files.diagnosis_words import lines

ACTUATORS = Path(__file__).with_name("ecoflex_actuators")
FIRST = "c5-w7"
"""The actuator with five chambers."""
HIGHEST_kPa = {"bending": 17.0, "blocked_force": 25.0}
"""Below ballooning."""
TRIED = ("angle_gain", "angle_offset")
TOUCHES = (
    "clamp_compliance", "gravity_pitch", "plate_compliance", "plate_friction", "plate_gap",
    "plate_tilt", "force_gain", "force_offset", "pressure_gain",
)  # fmt: skip
"""What a blocked actuator feels beside its body."""
COARSE = {"mesh.edge_size_mm": 2.0}
CLOSED = {"cast.tube": False}
"""A clamp that moves asks for a cavity that is closed at the clamp."""


def readings(out: Path, experiment: str = "bending", specimen: str = FIRST) -> Path:
    """Write the readings of one actuator below ballooning, as a CSV beside its TOML."""
    out.mkdir(parents=True, exist_ok=True)
    file = out / f"{experiment}.csv"
    table = pd.read_csv(ACTUATORS / file.name)
    own = (table["specimen"] == specimen) & (table["pressure_kPa"] <= HIGHEST_kPa[experiment])
    table[own].to_csv(file, index=False)
    setup = tomlkit.parse((ACTUATORS / file.name).with_suffix(".toml").read_text("utf-8"))
    for other in [name for name in setup["specimen"] if name != specimen]:
        del setup["specimen"][other]
    file.with_suffix(".toml").write_text(tomlkit.dumps(setup), "utf-8")
    return file


def main(out: Path, blocked: str = "", *, quick: bool = False) -> DiagnosisFile:
    """Diagnose and read ``diagnosis.json``; with its force where a blocked actuator is named."""
    files = [readings(out, specimen=blocked or FIRST)]
    if blocked:
        files.append(readings(out, "blocked_force", blocked))
    model = config.load(ACTUATORS / "coupon_alone.toml", COARSE | (CLOSED if blocked else {}))
    tried = (*TRIED, *TOUCHES) if blocked else TRIED
    settings = DiagnosisSettings(effects=tried, quick=quick, say=print)
    found = diagnose(files, model, out, settings)
    write(found, files, out)
    return DiagnosisFile.read(out)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--blocked", default="", choices=("c5-w7", "c7-w7"))
    parser.add_argument("--quick", action="store_true", help="stop after the screen")
    asked = parser.parse_args()
    out = Path("out/diagnose_actuator") / asked.blocked
    print(*lines(main(out, asked.blocked, quick=asked.quick)), sep="\n")
