"""The whole of it on coupons, whose simulation is cheap and whose closed forms are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.here import Here, simulated
from support.measured_files import written

from dolfingrip.config import Change, Config, changed, load
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.finger import FingerSimulation
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, SimulatedReadings, simulate
from dolfingrip.experiments import run, synthetic
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.sections.tables import assignments

TOLD = "gauge_length_mm = 33.0\narea_mm2 = 9.0\n[nuisance]\ncoupon_area = 0.18\n"
SHARP = {"force_N": 0.0, "displacement_mm": 0.0}
HIDDEN = "extensions.mooney_rivlin.C01_MPa=1.0"


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    """Two coupons of Mooney and Rivlin's material, 101 rows each, to 50 % and without noise."""
    told = load(None, assignments(["coupon.step_strain=0.005"]))
    hidden = changed(told, assignments([HIDDEN]))
    silent = {**synthetic.NOISE, **SHARP}
    made = synthetic.measure(["coupon"], told, hidden=hidden, noise=silent)
    lines = ["specimen,time_s,displacement_mm,force_N"]
    for name in "AB":
        for row in made.rows:
            entries = (row[key] for key in ("time_s", "displacement_mm", "force_N"))
            lines.append(",".join([name, *(f"{entry:.8g}" for entry in entries)]))
    folder = tmp_path_factory.mktemp("coupons")
    csv = "\n".join(lines) + "\n"
    return read([written(folder, csv, 'experiment = "coupon"\n' + TOLD)])


@pytest.fixture(scope="module")
def simulation(measurement: Measurement, store: Path) -> FingerSimulation:
    return simulated(measurement, Config(), Here(store))


@pytest.fixture(scope="module")
def base(simulation: FingerSimulation) -> SimulatedReadings:
    return simulation.base


def nuisance(simulation: FingerSimulation, name: str) -> np.ndarray:
    return next(each.change for each in simulation.rig if each.name == name)


def test_readings_are_those_of_a_run_at_every_row(
    base: SimulatedReadings, measurement: Measurement
) -> None:
    """25 stops stand for 101 rows: the error is below the noise."""
    every = run("coupon", load(None, assignments(["coupon.step_strain=0.005"]))).column("force_N")
    error = np.abs(base.readings - np.tile(every, 2)).max()
    print("error", error, "N")
    assert len(base.runs) == 1
    assert error < 0.02


def test_nuisances(simulation: FingerSimulation, measurement: Measurement) -> None:
    """The force is proportional to modulus and area."""
    base = simulation.base
    names = [each.name for each in simulation.rig]
    assert names == ["modulus", "coupon_area", "specimen_scale of A", "specimen_scale of B"]
    np.testing.assert_allclose(nuisance(simulation, "modulus"), 0.2 * base.readings, atol=1e-4)
    np.testing.assert_allclose(nuisance(simulation, "coupon_area"), 0.18 * base.readings)
    first = (measurement.listed["specimen"] == "A").to_numpy()
    own = nuisance(simulation, "specimen_scale of A")
    np.testing.assert_allclose(own, 0.015 * np.where(first, base.readings, 0), atol=1e-5)
    assert all(each.change.shape == (202,) for each in simulation.rig)
    assert np.abs(simulation.mesh).max(initial=0.0) < 1e-9


def test_gauge_noise_counts_by_the_slope(base: SimulatedReadings, measurement: Measurement) -> None:
    listed = measurement.listed
    control, first = listed["control"].to_numpy(), (listed["specimen"] == "A").to_numpy()
    slope = np.gradient(base.readings[first], control[first])
    np.testing.assert_allclose(base.by_control[first][2:-2], slope[2:-2], rtol=2e-3)


def test_stops_stand_for_all_rows_where_there_is_memory(tmp_path: Path, store: Path) -> None:
    """A viscous bar up, a wait and down, 223 rows: simulated at 61 stops against at every row.

    What is left is interpolation and the longer steps in time: below 0.5 % of the relaxed force.
    """
    up = np.linspace(0, 10, 101)
    way = [("loading", k * 0.04, u) for k, u in enumerate(up)]
    way += [("hold", 4 + k, 10.0) for k in range(1, 22)]
    way += [("unloading", 25 + 0.04 * k, u) for k, u in enumerate(up[::-1]) if k]
    lines = ["branch,time_s,displacement_mm,force_N"]
    lines += [f"{branch},{time_s:.4f},{u:.4f},1.0" for branch, time_s, u in way]
    told = 'experiment = "coupon"\n' + TOLD
    long = read([written(tmp_path, "\n".join(lines) + "\n", told)])
    viscous = {"extensions.prony.g": [0.3], "extensions.prony.tau_s": [3.0]}
    (found,) = simulate(long, Config(), [ModelVariant(viscous)], Here(store))
    rows = long.readings
    every = load(None, viscous).changed(
        protocol={
            "time_s": rows["time_s"].tolist(), "displacement_mm": rows["displacement_mm"].tolist(),
            "branch": rows["branch"].tolist(),
        }
    )  # fmt: skip
    assert len(found.runs[0].schedule.value) < 65
    there = run("coupon", every).column("force_N")
    relaxed = there[100] - there[121]
    error = np.abs(found.readings - there).max()
    print("relaxed", relaxed, "N, error", error, "N")
    assert relaxed > 1.0
    assert error < 5e-3 * relaxed


def test_derivatives_through_memory(measurement: Measurement, store: Path) -> None:
    """What a fit by least squares asks for, against central differences of two simulations."""

    def viscous(g: float, tau_s: float) -> Change:
        return {"extensions.prony.g": [g], "extensions.prony.tau_s": [tau_s]}

    ends = [(0.2, 3.0), (0.201, 3.0), (0.199, 3.0), (0.2, 3.01), (0.2, 2.99)]
    keys = ("extensions.prony.g", "extensions.prony.tau_s[0]", "finger.wall_mm")
    cases = [ModelVariant(viscous(*end), keys if not i else ()) for i, end in enumerate(ends)]
    base, *there = simulate(measurement, Config(), cases, Here(store))
    for key, (up, down), step in (
        ("extensions.prony.g[0]", there[:2], 2e-3), ("extensions.prony.tau_s[0]", there[2:], 2e-2)
    ):  # fmt: skip
        expected = (up.readings - down.readings) / step
        scale = np.abs(expected).max()
        np.testing.assert_allclose(base.slopes[key], expected, atol=1e-3 * scale)
    assert not {"finger.wall_mm", "extensions.prony.g"} & set(base.slopes)


class Failing(Here):
    """Its simulations end at the tenth stop."""

    def results(self, requests: Sequence[Request]) -> list[Answer]:
        return [
            replace(
                whole,
                columns={name: values[:10] for name, values in whole.columns.items()},
                failure_class="limit point",
                failure="stopped at 6 mm (limit point)",
            )
            for whole in Here.results(self, requests)
        ]


def test_a_simulation_that_fails_is_told_and_leaves_no_numbers(
    measurement: Measurement, store: Path
) -> None:
    """Up to where it came its readings are good."""
    whole, part = (
        simulate(measurement, Config(), [ModelVariant()], workers(store))[0]
        for workers in (Here, Failing)
    )
    assert not whole.failures
    (failure,) = part.failures
    assert [measurement.tests[number].specimen for number in failure.group.tests] == ["A", "B"]
    assert failure.why == "stopped at 6 mm (limit point)"
    control = measurement.listed["control"].to_numpy()
    reached = part.runs[0].result.columns["displacement_mm"][-1]
    good = ~np.isnan(part.readings)
    assert good[control <= reached].all()
    assert not good[control > 1.1 * reached].any()
    np.testing.assert_allclose(part.readings[good], whole.readings[good], atol=0.01)
