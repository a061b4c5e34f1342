"""Takes a channel that was added through everything that reads columns, in a process of its own.

    python tests/added_channel/flow.py FOLDER

The channel is ``narrowing_mm`` of a coupon. Each step asserts what it shows; the last ones are a
diagnosis of a synthetic coupon by its force and this reading alone.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest
from support.delivered import Delivered
from support.here import Here

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config, ConfigError, changed, load
from dolfingrip.diagnosis.answer.errors import instrument_noise
from dolfingrip.diagnosis.data.measurement import read, selected
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.results import write as write_diagnosis
from dolfingrip.experiments import Result, recorder, run, synthetic
from dolfingrip.experiments.index import find
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.report import diagnosis as pictures
from dolfingrip.report.table import tabulate
from dolfingrip.sections.tables import assignments

NAME = "narrowing_mm"
ONCE = ("coupon.step_strain=0.0125",)
WIDTH_MM = 3.0
HIDDEN = "extensions.bulk_modulus.more_MPa=100.0"
"""It narrows the coupon by 0.04 mm more at the largest strain, which is seven times the noise."""


def header(file: Path) -> list[str]:
    with file.open(encoding="utf-8") as stream:
        return next(csv.reader(stream))


def of_an_experiment(folder: Path) -> Result:
    """Its values, their derivatives, the column of ``result.csv`` and of the printed table."""
    coupon = find("coupon")
    result = run(coupon, load(None, assignments(ONCE)), out=folder, gradients=["material.nu"])
    narrowed_mm = result.column(NAME)
    expected = -WIDTH_MM * result.column("transverse_strain")
    np.testing.assert_allclose(narrowed_mm, expected, rtol=1e-9, atol=1e-12)
    by_nu = {
        name: [each["derivative"] for each in result.sensitivities if each["column"] == name]
        for name in (NAME, "transverse_strain")
    }
    assert by_nu[NAME][-1] > 0.5
    np.testing.assert_allclose(
        by_nu[NAME], -WIDTH_MM * np.array(by_nu["transverse_strain"]), rtol=1e-5, atol=1e-9
    )
    assert NAME in header(folder / "result.csv")
    assert dict(recorder.described(coupon))[NAME] == CHANNELS[NAME].title
    table = tabulate((coupon.table, result.columns()))
    shown = {" ".join(str(each.header).split()): list(each.cells) for each in table.columns}
    assert shown["Narrowing (mm)"] == [f"{each:.3f}" for each in narrowed_mm]
    return result


def of_data(folder: Path, result: Result) -> Path:
    """Its noise in a synthetic measurement, which is read again; what is refused of it."""
    assert synthetic.NOISE[NAME] == 0.006
    truth = changed(result.config, assignments([HIDDEN]))
    made = synthetic.measure(["coupon"], result.config, hidden=truth, seed=5)
    for row in made.rows:  # what tells the same is not measured
        del row["transverse_strain"]
    synthetic.write(made, folder)
    file = folder / "measured.csv"
    measurement = read([file])
    listed = measurement.listed
    mine = (listed["column"] == NAME).to_numpy()
    assert mine.sum() == len(result.rows)
    np.testing.assert_array_equal(instrument_noise(measurement)[0].independent[mine], 0.006)
    text = file.read_text(encoding="utf-8").replace(f"{made.rows[3][NAME]:.6g}", "300")
    wrong = folder / "wrong.csv"
    wrong.write_text(text, encoding="utf-8")
    wrong.with_suffix(".toml").write_bytes(file.with_suffix(".toml").read_bytes())
    with pytest.raises(ConfigError, match=f"line 5: {NAME} = 300: allowed: -100 to 100 mm"):
        read([wrong])
    return file


def of_a_diagnosis(file: Path, out: Path) -> None:
    """A hidden bulk modulus, which the force alone does not tell from another law."""
    measurement = selected(read([file]), Config())[0]
    settings = DiagnosisSettings(effects=("bulk_modulus", "ogden_terms"))
    found = diagnose_measurement(measurement, Config(), Here(out / "simulations"), settings)
    written, readings = write_diagnosis(found, [file], out)
    drawn = pictures.draw(written, readings, out)
    files = Delivered(out, DiagnosisFile.read(out))
    mine = files.readings[files.readings["channel"] == NAME]
    assert np.isfinite(mine["configured"]).all()
    np.testing.assert_allclose(mine["noise"], 0.006, rtol=0.5)
    print(files.verdict)
    assert files.verdict.effects == ("bulk_modulus",)
    assert all(picture.stat().st_size > 0 for picture in drawn)
    page = (out / "summary.md").read_text(encoding="utf-8")
    assert NAME in page


def main(folder: Path) -> None:
    assert CHANNELS[NAME].label == "Narrowing (mm)"
    assert len(EFFECTS) > 30
    result = of_an_experiment(folder / "run")
    of_a_diagnosis(of_data(folder, result), folder / "diagnosis")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
