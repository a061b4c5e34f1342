"""The whole of it on a short, coarse finger: free and blocked, up, a wait and down."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import small
from support.here import Here, simulated
from support.measured_files import written

from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.answer.errors import errors_of
from dolfingrip.diagnosis.core.unknown import causes, factor_of_moduli
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.finger import closed_forms
from dolfingrip.diagnosis.finger.model import (
    FingerSimulation,
    baseline_problem,
    fitted_moduli,
)
from dolfingrip.diagnosis.simulation.simulated import (
    ModelVariant,
    SimulatedReadings,
    scaled_moduli,
    simulate,
)
from dolfingrip.experiments import run
from dolfingrip.parameter.nuisances import GAP

TOLD = """experiment = ["bending", "blocked_force"]
[plate]
gap_mm = 0.1
"""
UP, DOWN = (0, 20, 40, 60), (30, 0)


def finger() -> Config:
    """Two bellows, graded a little, so that there is something to take off."""
    return small.short("mesh.edge_size_mm=4", "solver.rtol=1e-9")


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    """No readings of anything: what is simulated matters here."""
    lines = ["experiment,branch,time_s,pressure_kPa,angle_deg,force_N"]
    for name, entries in (("bending", "1,"), ("blocked_force", "1,1")):
        way = [("loading", p) for p in UP] + [("hold", 60), *(("unloading", p) for p in DOWN)]
        lines += [f"{name},{branch},{i},{p},{entries}" for i, (branch, p) in enumerate(way)]
    folder = tmp_path_factory.mktemp("fingers")
    return read([written(folder, "\n".join(lines) + "\n", TOLD)], finger())


@pytest.fixture(scope="module")
def simulation(measurement: Measurement, store: Path) -> FingerSimulation:
    return simulated(measurement, finger(), Here(store))


@pytest.fixture(scope="module")
def base(simulation: FingerSimulation) -> SimulatedReadings:
    return simulation.base


def one(measurement: Measurement, store: Path, overrides: Change) -> SimulatedReadings:
    return simulate(measurement, finger(), [ModelVariant(overrides)], Here(store))[0]


def of(measurement: Measurement, experiment: str, column: str = "angle_deg") -> np.ndarray:
    listed = measurement.listed
    return ((listed["experiment"] == experiment) & (listed["column"] == column)).to_numpy()


def test_one_curve_serves_all_branches(base: SimulatedReadings, measurement: Measurement) -> None:
    """Readings are those of a run through all branches; of five stops 30 kPa is between two."""
    config = finger().changed(
        plate={"gap_mm": 0.1}, protocol={"time_s": range(7), "pressure_kPa": [*UP, 60, *DOWN]}
    )
    for name, column in (("bending", "angle_deg"), ("blocked_force", "force_N")):
        whole = run(name, config).column(column)
        got = base.readings[of(measurement, name, column)]
        stops = [0, 1, 2, 3, 4, 6]
        np.testing.assert_allclose(got[stops], whole[stops], atol=2e-5 * whole.max())
        assert got[5] == pytest.approx(whole[5], abs=5e-3 * whole.max())


def test_modulus_scales_exactly(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against simulations with all moduli changed, to what interpolation over 20 kPa leaves.

    The gap of 0.1 mm closes between the first two stops.
    """
    assert simulation.scales
    for factor in (0.8, 1.25):
        scaled = simulation.read(simulation.base, factor)
        changed = one(measurement, store, scaled_moduli(simulation.base.runs[1].config, factor))
        for name, column, allowed in (
            ("bending", "angle_deg", 1e-5), ("blocked_force", "force_N", 1e-3)
        ):  # fmt: skip
            at = of(measurement, name, column)
            there = changed.readings[at]
            off = np.abs(scaled[at] - there).max()
            print(factor, column, "off by", off, "of", there.max())
            assert off < allowed * there.max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factors", "there", "remembering"),
    [((2.0, 2.0, 2.0), 1.0, 1.6), ((0.7, 0.7, 0.7), 0.625, 0.625), ((0.45, 0.65, 0.8), 1.0, 1.0)],
)
def test_all_is_simulated_anew_where_a_plain_finger_is_softer(
    simulation: FingerSimulation, measurement: Measurement, factors: tuple[float, ...],
    there: float, remembering: float,
) -> None:  # fmt: skip
    """A stiffer one is read from the same curve but for causes with memory. Moduli that grow with
    the pressure, at 20, 40 and 60 kPa, are no other modulus."""
    plain = baseline_problem(simulation, errors_of(simulation))
    by = np.interp(measurement.listed["control"], UP[1:], factors)
    own = np.array([simulation.base_at(c)[place] for place, c in enumerate(by)])
    plain = replace(plain, value=own)
    assert fitted_moduli(plain, simulation) == pytest.approx(there)
    assert fitted_moduli(plain, simulation, scaled=False) == pytest.approx(remembering)


def test_nuisances_are_derivatives_by_their_standard_deviation(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against central differences; the wall's moves the mesh, so a thicker one is meshed alike."""
    base = simulation.base
    names = [each.name for each in simulation.nuisances]
    assert names == ["modulus", "wall", "pressure_gain", "pressure_offset_kPa", "plate_gap_mm"]
    columns = {each.name: each.change for each in simulation.nuisances}
    free = of(measurement, "bending")
    assert not columns["plate_gap_mm"][free].any()
    np.testing.assert_allclose(columns["plate_gap_mm"], 0.3 * base.slopes[GAP])
    np.testing.assert_allclose(columns["wall"], 0.05 * 1.6 * base.slopes["finger.wall_mm"])
    ends = [
        one(measurement, store, {"extensions.pressure_gain.gain": gain}) for gain in (1.005, 0.995)
    ]
    expected = 1.5 * (ends[0].readings - ends[1].readings)
    np.testing.assert_allclose(columns["pressure_gain"], expected, atol=2e-3)
    # by the exact scaling, too: dα/dln c = -p dα/dp
    pressure = measurement.listed["control"].to_numpy()
    np.testing.assert_allclose(
        columns["modulus"][free], -0.2 * (pressure * base.by_control)[free], atol=0.02
    )


def test_a_line_that_lags_is_the_elastic_curve_behind_it(
    base: SimulatedReadings, measurement: Measurement, store: Path
) -> None:
    """Against simulations in time, free to all digits. Blocked, interpolation over 20 kPa leaves a
    part where the gap of 0.1 mm closes, as it does of the base readings."""
    for tau_s in (0.3, 2.0):
        overrides = {"extensions.line_lag.tau_s": tau_s}
        line = changed(finger(), overrides).extensions.line_lag
        assert line is not None
        shape = closed_forms.change(measurement, base, line)
        change = one(measurement, store, overrides).readings - base.readings
        for experiment, name, allowed in (
            ("bending", "angle_deg", 1e-5),
            ("blocked_force", "angle_deg", 3e-2),
            ("blocked_force", "force_N", 3e-2),
        ):
            at = of(measurement, experiment, name)
            off = np.abs(shape - change)[at].max()
            largest = base.readings[measurement.listed["column"] == name].max()
            print(overrides, experiment, name, "off by", off, "of", np.abs(change[at]).max())
            assert off < allowed * largest


def test_an_angle_that_lags_is_the_filtered_curve(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against simulations in time; nothing else is changed."""
    (lag,) = causes(finger(), ["angle_lag"])
    zeta = np.array([1.0])
    told = closed_forms.simulations(
        simulation, lag, lag.box(), np.zeros(1), factor_of_moduli(0.2, -1.0, 1.0)
    )
    angles = of(measurement, "bending")
    tau_s = lag.numbers[0].at(told.zeta[:, 0])
    near = int(np.argmin(np.abs(tau_s - lag.numbers[0].at(zeta)[0])))
    overrides = {"extensions.angle_lag.tau_s": float(tau_s[near])}
    change = one(measurement, store, overrides).readings - simulation.base.readings
    found = told.values[0, near]
    print(overrides, "changes", change[angles], "told", found[angles])
    assert np.abs(change[angles]).max() > 0.05 * simulation.base.readings[angles].max()
    np.testing.assert_allclose(found[angles], change[angles], atol=2e-5 * 20)
    assert not found[of(measurement, "blocked_force", "force_N")].any()
