"""Find what a simulation gets wrong about printed coupons, and why.

Eight coupons of NinjaFlex were printed and pulled to 50 % strain. The configured material is neo-
Hookean with μ = 2.93 MPa: P = μ (λ − λ⁻²). The coupons are stiffer, and they soften: their curve
bends more than neo-Hooke's. A modulus alone cannot bend it. The diagnosis tries causes of its
catalogue and compares their evidence, the probability of the readings with all numbers of a cause
integrated out. Here it is asked about two elastic laws and an instrument's error:

    Mooney–Rivlin   P = 2 (C10 + C01/λ)(λ − λ⁻²)
    Gent            stiffens, so it cannot be it
    force_gain      a load cell's factor, which acts as a modulus does

    scripts/run python examples/diagnose_coupons.py

``dolfingrip diagnose examples/coupons/ninjaflex_uniaxial.csv`` tries the whole catalogue.
"""

from __future__ import annotations

from pathlib import Path

from dolfingrip.config import Config
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.diagnosis.results import write
from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.files.diagnosis_words import lines

COUPONS = Path(__file__).with_name("coupons") / "ninjaflex_uniaxial.csv"
TRIED = ("mooney_rivlin", "gent", "force_gain")


def main(out: Path) -> DiagnosisFile:
    """Diagnose and read ``diagnosis.json``."""
    found = diagnose([COUPONS], Config(), out, DiagnosisSettings(quick=True, effects=TRIED))
    write(found, [COUPONS], out)
    return DiagnosisFile.read(out)


if __name__ == "__main__":
    out = Path("out/diagnose_coupons")
    print(*lines(main(out)), sep="\n")
