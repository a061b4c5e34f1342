"""A stiff layer in a part of the base, which no effect of the catalogue is.

    scripts/run env PYTHONPATH=tests python -m support.stiff_layer [FOLDER]

prints angle and force of the reference finger with it, on a mesh of tetrahedra (half a minute of
processor; an AMD EPYC). ``READINGS`` has them; they are written into a folder as measured ones.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, ClassVar, Final

import numpy as np
import ufl
from pydantic import Field
from support import trial
from support.measured_files import written
from ufl.core.expr import Expr

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.extensions.effect import Effect, Prior, Site
from dolfingrip.sections.section import FINGERS, Ratio
from dolfingrip.sections.tables import assignments

ALONG: Final = (0.45, 0.8)
"""Where it begins and ends, by the finger's length."""
THICK_mm: Final = 3.0
"""Of the 3.5 mm of the base layer."""
FACTOR: Final = 4.0
TETRAHEDRA: Final = ("solver.element=P2", "mesh.size_mm=2.5")
PRESSURES_kPa: Final = tuple(25.0 * i for i in range(11))
READINGS: Final = {
    "angle_deg": (
        0.0, 12.99375, 25.82564, 38.55083, 51.24973, 64.00784, 76.90733, 90.02374, 103.42418,
        117.16543, 131.29140,
    ),
    "force_N": (
        0.0, 0.2432612, 0.5108738, 0.8006842, 1.1113580, 1.4424627, 1.8197169, 2.2313384,
        2.6817334, 3.1772726, 3.7203353,
    ),
}  # fmt: skip
NOISE: Final = {"angle_deg": 0.42, "force_N": 0.02}
EXPERIMENTS: Final = {"angle_deg": "bending", "force_N": "blocked_force"}
SEED: Final = 1
TOLD: Final = """experiment = ["bending", "blocked_force"]
[nuisance]
modulus = 0.03
wall = 0.02
[noise]
angle_deg = 0.42
force_N = 0.02
"""


class StiffLayer(Effect):
    """A layer of another stiffness."""

    kind: ClassVar = "elastic"
    felt_by: ClassVar = FINGERS

    factor: Annotated[Ratio, Prior(FACTOR, 1.0, "made up", positive=True)] = Field(FACTOR, gt=0)

    def moduli(self, site: Site) -> Expr:
        x, ends = ufl.SpatialCoordinate(site.domain.mesh), site.extent(2)
        s = (x[2] - ends[0]) / (ends[1] - ends[0])
        along = ufl.And(ufl.gt(s, ALONG[0]), ufl.lt(s, ALONG[1]))
        inside = ufl.And(along, ufl.lt(x[0], site.fixed(THICK_mm)))
        return ufl.conditional(inside, site.constant(self, "factor"), 1.0)


def measured(folder: Path) -> Path:
    """The readings with noise, as a laboratory hands them over that knows the modulus."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    lines = ["experiment,branch,time_s,pressure_kPa,angle_deg,force_N"]
    for column, values in READINGS.items():
        noisy = [0.0, *(np.array(values[1:]) + NOISE[column] * rng.standard_normal(10))]
        for pressure, value in zip(PRESSURES_kPa, noisy, strict=True):
            entry = f"{value:.5f}," if column == "angle_deg" else f",{value:.5f}"
            name = EXPERIMENTS[column]
            lines.append(f"{name},loading,{pressure / 25},{pressure},{entry}")
    return written(folder, "\n".join(lines) + "\n", TOLD)


def main() -> None:
    """Simulate the truth, and print it; or write readings as a laboratory hands them over."""
    if folders := sys.argv[1:]:
        Path(folders[0]).mkdir(parents=True, exist_ok=True)
        print(measured(Path(folders[0])))
        return
    finger = trial.configured(
        {StiffLayer: {}}, *TETRAHEDRA, finger=lambda *own: config.load(None, assignments(own))
    )
    way = {
        "time_s": [each / 25 for each in PRESSURES_kPa], "pressure_kPa": PRESSURES_kPa,
        "branch": ["loading"] * len(PRESSURES_kPa),
    }  # fmt: skip
    for column, name in EXPERIMENTS.items():
        print(column, run(name, finger.changed(protocol=way)).column(column).tolist())


if __name__ == "__main__":
    main()
