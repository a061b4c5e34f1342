"""Will it break: the largest stretch by the elongation at break, and the pressure where it is 1."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI
from support import small

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.experiments.results.doubts import elongation, of_motion
from dolfingrip.parameter import every
from dolfingrip.sections import material


def test_the_pressure_at_which_it_breaks_lies_between_the_readings() -> None:
    """The column is the largest elongation by that at break; the sentence interpolates it."""
    settings = small.short("experiment.step_kPa=20", "experiment.max_pressure_kPa=40")
    free = run("bending", settings, comm=MPI.COMM_SELF)
    stretch = free.column("largest_stretch")
    assert stretch[0] == 1
    assert (np.diff(stretch) > 0.01).all()
    assert "break_share" not in free
    assert elongation(free) == []
    at_break = float(stretch[1] + stretch[2]) / 2 - 1
    told = config.changed(settings, {"material.elongation_at_break": at_break})
    broken = run("bending", told, comm=MPI.COMM_SELF)
    assert broken.column("break_share") == pytest.approx((stretch - 1) / at_break, rel=1e-6)
    (said,) = [doubt.sentence for doubt in of_motion(broken)]
    assert said.startswith("a wall breaks at 30 kPa")  # half-way between 20 and 40 kPa
    share = 100 * (stretch[2] - 1) / at_break
    assert elongation(broken) == [f"largest elongation: {share:.3g} % of that at break, at 40 kPa"]
    assert "material.elongation_at_break" not in {each.key for each in every(told)}


@pytest.mark.parametrize("name", material.named())
def test_a_named_material_tells_its_elongation_at_break(name: str) -> None:
    own = material.named()[name]["elongation_at_break"]
    assert config.load(None, {"material.name": name}).material.elongation_at_break == own
    change = {"material.name": name, "material.elongation_at_break": 2.0}
    assert config.load(None, change).material.elongation_at_break == 2.0
