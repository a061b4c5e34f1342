"""The whole of it on a short, coarse finger: free and blocked, up, a wait and down."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import small
from support.here import Here, simulated
from support.measured_files import written

from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.core.unknown import causes, factor_of_moduli
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.finger import FingerSimulation
from dolfingrip.diagnosis.simulation.point import Point
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, SimulatedReadings, simulate
from dolfingrip.experiments import run

TOLD = """experiment = ["bending", "blocked_force"]
[plate]
gap_mm = 0.1
"""
UP, DOWN = (0, 20, 40, 60), (30, 0)


def finger() -> Config:
    """Two bellows, graded a little, so that there is something to take off."""
    return small.short(*small.FEW, "mesh.edge_size_mm=6", "solver.rtol=1e-9")


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


def test_nuisances_are_derivatives_by_their_standard_deviation(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against central differences; the wall's moves the mesh, so a thicker one is meshed alike."""
    base = simulation.base
    names = [each.name for each in simulation.rig]
    assert names == ["modulus", "wall", "pressure_gain", "pressure_offset_kPa", "plate_gap_mm"]
    columns = {each.name: each.change for each in simulation.rig}
    free = of(measurement, "bending")
    assert not columns["plate_gap_mm"][free].any()
    np.testing.assert_allclose(columns["plate_gap_mm"], 0.3 * base.slopes["plate.gap_mm"])
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


def point(simulation: FingerSimulation, c: float, name: str, zeta: float) -> Point:
    """Moduli c times those configured, and a cause."""
    factor = factor_of_moduli(0.2, -5.0, 5.0)
    (cause,) = causes(finger(), [name])
    own = np.r_[zeta, np.zeros(len(cause.numbers) - 1)]
    return Point(factor, factor.zeta(c), (), ((cause, own),))


@pytest.mark.slow
def test_a_point_is_what_is_simulated_with_its_numbers(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against a simulation of the configuration, and central differences of its derivatives."""
    where = point(simulation, 0.9, "mooney_rivlin", 0.5)
    (found,) = simulation.at([where])
    assert found is not None
    there = one(measurement, store, {**simulation.flat, **where.change(finger())}).readings
    np.testing.assert_allclose(found.told[0, :, 0] - simulation.delta, there, rtol=1e-4, atol=1e-4)
    ((cause, zeta),) = where.causes
    step = 0.05
    for place, ends in enumerate([
        [replace(where, zeta=where.zeta + way * step) for way in (1, -1)],
        [replace(where, causes=((cause, zeta + way * step),)) for way in (1, -1)],
    ]):  # fmt: skip
        more, less = simulation.at(ends)
        assert more is not None
        assert less is not None
        by_u = (more.told - less.told)[0, :, 0] / (more.u - less.u)[0, place]
        largest = np.abs(by_u).max()
        np.testing.assert_allclose(found.told[0, :, 1 + place], by_u, atol=0.02 * largest)


@pytest.mark.slow
def test_where_causes_do_nothing_their_derivatives_are_known(
    simulation: FingerSimulation,
) -> None:
    """One simulation for all that are smooth there, against small amounts of each."""
    some = causes(finger(), ["mooney_rivlin", "yeoh", "base_layer_offset"])
    start = Point(factor_of_moduli(0.2, -5.0, 5.0), 0.0)
    told = simulation.resting(some, start)
    assert told is not None
    assert set(told) == {each.name for each in some}
    for cause in some:
        zeta = np.full(len(cause.numbers), -3.0 if cause.numbers[0].prior.positive else 0.2)
        (there,) = simulation.at([replace(start, causes=((cause, zeta),))])
        assert there is not None
        own = told[cause.name]
        line = own.told[0, :, 0] + own.told[0, :, 1:] @ (there.u - own.u)[0]
        change = there.told[0, :, 0] - own.told[0, :, 0]
        off = np.abs(line - there.told[0, :, 0]).max()
        print(cause.name, "off by", off, "of", np.abs(change).max())
        assert off < 0.1 * np.abs(change).max() + 1e-3


def test_an_instrument_shows_what_the_finer_mesh_changes(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against a simulation that has the lag itself; a stiffer body stands for a coarser mesh."""
    stiffer: Change = {"material.mu_MPa": 1.02 * finger().material.shear_MPa}
    graded = replace(simulation, flat=stiffer, graded=True)
    where = point(simulation, 1.0, "sensor_lag", 1.0)
    there = one(measurement, store, where.change(finger())).readings
    (found,) = graded.at([where])
    assert found is not None
    late, on_time = there - found.told[0, :, 0], graded.delta
    print("finer mesh", on_time, "left", late)
    assert np.abs(on_time[of(measurement, "bending")]).max() > 0.1
    np.testing.assert_allclose(late, 0.0, atol=2e-5 * 20)


def test_an_angle_that_lags_is_the_filtered_curve(
    simulation: FingerSimulation, measurement: Measurement, store: Path
) -> None:
    """Against simulations in time; nothing else is changed, and nothing is simulated for it."""
    where = point(simulation, 1.0, "sensor_lag", 1.0)
    angles = of(measurement, "bending")
    there = one(measurement, store, {**simulation.flat, **where.change(finger())}).readings
    plain = simulation.plain(replace(where, causes=())).told[0, :, 0]
    (found,) = simulation.at([where])
    assert found is not None
    change, own = there - (plain - simulation.delta), found.told[0, :, 0] - plain
    print("changes", change[angles], "told", own[angles])
    assert np.abs(change[angles]).max() > 0.05 * plain[angles].max()
    np.testing.assert_allclose(own[angles], change[angles], atol=2e-5 * 20)
    forces = of(measurement, "blocked_force", "force_N")
    np.testing.assert_allclose(own[forces], 0.0, atol=1e-9)
    more, less = simulation.at(
        [point(simulation, 1.0, "sensor_lag", 1.0 + h) for h in (0.01, -0.01)]
    )
    assert more is not None
    assert less is not None
    by_u = (more.told - less.told)[0, :, 0] / (more.u - less.u)[0, 1]
    np.testing.assert_allclose(found.told[0, :, 2], by_u, atol=1e-2 * np.abs(by_u).max())
