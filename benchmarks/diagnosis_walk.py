"""Which files of the diagnosis a measurement walks through on its way to the verdict.

    scripts/run python -m benchmarks.diagnosis_walk [FILE.csv ...] [--effects a,b] [--store FOLDER]

diagnoses with ``--quick`` (the example's coupons where no file is given), and prints the files in
the order in which they are entered, and each call of a file that was entered before its caller.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from types import FrameType
from typing import Any, Final

from dolfingrip.config import Config
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose

INSIDE: Final = "/dolfingrip/diagnosis/"
COUPONS: Final = Path("examples/coupons/ninjaflex_uniaxial.csv")


def file_of(frame: FrameType | None) -> str:
    """Return the file of the diagnosis that a call came from; "" where it came from none."""
    while frame is not None:
        if INSIDE in (name := frame.f_code.co_filename):
            return name.partition(INSIDE)[2]
        frame = frame.f_back
    return ""


def main() -> None:
    """Diagnose, and print the way."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("files", nargs="*", type=Path, default=[COUPONS])
    asked.add_argument("--effects", default=None)
    asked.add_argument("--store", type=Path, default=None, help="simulations of a diagnosis before")
    given = asked.parse_args()
    entered: dict[str, int] = {}
    back: dict[tuple[str, str], set[str]] = {}

    def note(frame: FrameType, event: str, _: Any) -> None:
        if event != "call" or INSIDE not in frame.f_code.co_filename:
            return
        here, caller = file_of(frame), file_of(frame.f_back)
        place = entered.setdefault(here, len(entered))
        if caller and caller != here and place < entered[caller]:
            back.setdefault((caller, here), set()).add(frame.f_code.co_name)

    names = given.effects.split(",") if given.effects else None
    with tempfile.TemporaryDirectory() as folder:
        settings = DiagnosisSettings(quick=True, effects=names, store=given.store)
        sys.setprofile(note)
        diagnose(given.files, Config(), Path(folder), settings)
        sys.setprofile(None)
    print(*entered, sep="\n")
    print(f"\n{len(entered)} files entered, {len(back)} calls of an earlier one")
    for (caller, here), called in back.items():
        print(f"{caller} -> {here}: {', '.join(sorted(called))}")


if __name__ == "__main__":
    main()
