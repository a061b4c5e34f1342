"""Steps and vents with waits of two seconds: a relaxation that they show, far from its middle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import small
from support.here import Here
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.unknown import causes
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.experiments import run
from dolfingrip.jobs.store import Store

SEED = 5
G, TAU_S = 0.15, 1.0
ANGLE_deg = 0.03
LEVELS_kPa = (30, 60)
READ_s = (0.1, 0.3, 0.8, 2.0)
TOLD = """experiment = "bending"
[noise]
angle_deg = 0.03
"""


def test_a_time_begins_where_the_longest_wait_tells_it() -> None:
    """By its prior a relaxation takes 13 s; no time leaves its prior by 1.5 standard deviations."""
    (prony,) = causes(Config(), ("prony",))
    time = prony.numbers[1]

    def begins(longest_s: float) -> float:
        return float(time.at(prony.at_strength(1.0, longest_s)[1]))

    assert time.key == "extensions.prony.tau_s"
    middle_s = 30 / np.sqrt(1 + (60 / 30) ** 2)  # the median of a lognormal number
    assert begins(np.inf) == pytest.approx(middle_s)
    assert begins(600.0) == pytest.approx(middle_s)
    assert begins(3.0) == pytest.approx(3.0)
    least_s = middle_s * np.exp(-1.5 * np.sqrt(np.log1p((60 / 30) ** 2)))
    assert begins(0.5) == pytest.approx(least_s)


@pytest.mark.slow
def test_a_second_of_relaxation_is_told_by_waits_of_two(tmp_path: Path, store: Path) -> None:
    """Its strength and its time, alone among what may follow them, by few simulations."""
    print("seed", SEED)
    time_s, pressure_kPa = [0.0], [0.0]
    for level in LEVELS_kPa:
        for target in (level, 0):
            begins = time_s[-1]
            time_s += [begins + 0.02, *(begins + at for at in READ_s)]
            pressure_kPa += [target] * (1 + len(READ_s))
    way = {"time_s": time_s, "pressure_kPa": pressure_kPa}
    viscous = small.short(*small.FEW, f"extensions.prony.g=[{G}]",
                          f"extensions.prony.tau_s=[{TAU_S}]").changed(protocol=way)  # fmt: skip
    values = run("bending", viscous).column("angle_deg")
    values += ANGLE_deg * np.random.default_rng(SEED).standard_normal(len(values))
    rows = zip(time_s, pressure_kPa, values, strict=True)
    lines = ["time_s,pressure_kPa,angle_deg", *("{:.2f},{},{:.4f}".format(*row) for row in rows)]
    config = small.short(*small.FEW)
    file = written(tmp_path, "\n".join(lines) + "\n", TOLD)
    effects = ("prony", "set_point_logged", "sensor_lag", "loss_factor", "permanent_set")
    settings = DiagnosisSettings(effects=effects)
    found = diagnose_measurement(read([file], config), config, Here(store), settings)
    decision = found.decision
    assert (decision.answer, decision.first, decision.second) == ("cause", ("prony",), ())
    assert decision.probability > 0.95
    with Store(store, write=False) as kept:
        assert kept.counts()["done"] <= 12, "nine are enough"
    g, tau = found.numbers(decision.best)[-2:]
    print(g, tau)
    assert g.low < G < g.high
    assert tau.low < TAU_S < tau.high
