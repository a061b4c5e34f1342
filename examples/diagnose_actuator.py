"""Find what a simulation gets wrong about a measured silicone actuator.

A block of Ecoflex 30 with five chambers bends by 2.5° at 20 kPa. The model has the modulus of a
coupon, μ = 0.0204 MPa, and a film of 50 N/mm that hardly stretches. It bends too far. Two numbers
are not known: the source of the data calls the chambers 8 mm wide, and 4 mm in one place, and
nobody measured the film. The laboratory's TOML says so, as standard deviations under
``[nuisance]``. What these explain is no cause; the diagnosis tells how far off each then is:

    y = y₀ + Σ N_k z_k + noise,    z_k ~ N(0, 1),    N_k = ∂y/∂θ_k σ_k

Instruments are asked beside them: a camera whose scale is off, and a regulator's.

    scripts/run python examples/diagnose_actuator.py

Source of the readings: P. Moseley et al., Advanced Engineering Materials 18 (2016).
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import tomlkit

from dolfingrip import config
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.diagnosis.results import write
from dolfingrip.files.diagnosis import HEADINGS, DiagnosisFile

ACTUATORS = Path(__file__).with_name("ecoflex_actuators")
HIGHEST_kPa = 17.0
"""Far below ballooning."""
TRIED = ("angle_gain", "angle_offset")
COARSE = {"mesh.edge_size_mm": 2.0}


def readings(out: Path) -> Path:
    """Write the readings of the five chambers up to 17 kPa, as a CSV beside its TOML."""
    out.mkdir(parents=True, exist_ok=True)
    file = out / "bending.csv"
    table = pd.read_csv(ACTUATORS / "bending.csv")
    own = (table["specimen"] == "c5-w7") & (table["pressure_kPa"] < HIGHEST_kPa)
    table[own].to_csv(file, index=False)
    setup = tomlkit.parse((ACTUATORS / "bending.toml").read_text("utf-8"))
    del setup["specimen"]["c7-w7"]
    file.with_suffix(".toml").write_text(tomlkit.dumps(setup), "utf-8")
    return file


def main(out: Path) -> DiagnosisFile:
    """Diagnose and read ``diagnosis.json``."""
    file = readings(out)
    model = config.load(ACTUATORS / "coupon_alone.toml", COARSE)
    found = diagnose([file], model, out, DiagnosisSettings(effects=TRIED))
    write(found, [file], out)
    return DiagnosisFile.read(out)


if __name__ == "__main__":
    brief = main(Path("out/diagnose_actuator")).brief
    for line, heading in HEADINGS.items():
        print(f"{heading}: {getattr(brief, line)}")
