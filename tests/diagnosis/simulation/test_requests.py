"""Requests of a diagnosis, their keys and their store."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.here import Here

from dolfingrip.config import load
from dolfingrip.diagnosis.simulation.runner import Workers, request
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import of_row
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.store import Store
from dolfingrip.sections.tables import assignments

PULL = {"time_s": [0.0, 1.0, 2.0], "displacement_mm": [0.0, 1.0, 2.0]}


def coupon(*overrides: str, gradients: tuple[str, ...] = ()) -> Request:
    return request("coupon", load(None, assignments(overrides)).changed(protocol=PULL), gradients)


def test_a_key_is_of_what_the_result_depends_on() -> None:
    base = coupon()
    assert base.key == coupon().key
    same = ["mesh.edge_size_mm=3", "finger.wall_mm=1.7", "experiment.max_pressure_kPa=99",
            "solver.time_limit_s=5", "plate.gap_mm=1"]  # fmt: skip
    for override in same:
        assert coupon(override).key == base.key, override
    other = [
        coupon("material.mu_MPa=2.0"),
        coupon("extensions.prony.tau_s=[1.0]"),
        coupon("coupon.width_mm=2.0"),
        coupon(gradients=("material.mu_MPa",)),
        request("bending", base.config),
        request("coupon", base.config.changed(protocol={"time_s": [0.0, 1.0, 2.1]})),
    ]
    assert len({each.key for each in [base, *other]}) == 7


def test_a_fingers_key_is_of_its_geometry_films_and_camera() -> None:
    base = ("finger.kind=pneunet", "film.sheet.region=paper")
    other = ("pneunet.wall_mm=1.7", "film.sheet.Et_N_per_mm=2", "material.base.mu_MPa=2",
             "camera.chord=back edges")  # fmt: skip
    made = [
        request("bending", load(None, assignments([*base, *more]))).key
        for more in ((), *((each,) for each in other))
    ]
    assert len(set(made)) == 1 + len(other)


def test_the_shortest_step_is_a_part_of_the_largest_pressure() -> None:
    """An arm of silicone that balloons at 34 kPa is followed from 24 to 30 kPa, and beyond."""

    def shortest(*kpa: float) -> float:
        protocol = {"time_s": [*map(float, range(len(kpa)))], "pressure_kPa": [*kpa]}
        return request("bending", load(None).changed(protocol=protocol)).config.solver.min_step_kPa

    assert shortest(0.0, 24.0, 30.0, 34.0) < 1.0
    assert shortest(0.0, -30.0) == shortest(0.0, 30.0)
    assert shortest(0.0, 250.0) == shortest(0.0, 500.0) == coupon().config.solver.min_step_kPa
    assert shortest(0.0, 0.0) == load(None).solver.min_step_kPa


def test_what_is_in_the_store_is_not_computed_again(tmp_path: Path) -> None:
    """By a worker of its own, then in this process, which would enter another worker."""
    job = coupon(gradients=("material.mu_MPa",))
    shown: list[int] = []
    workers = Workers(tmp_path, Where(workers=1), lambda standing: shown.append(standing.done))
    (first,) = workers.results([job])
    assert shown == [0, 1]
    with Store(tmp_path) as store:
        (before,) = store.rows()
    (second,) = Here(tmp_path).results([job])
    with Store(tmp_path) as store:
        (after,) = store.rows()
    assert before == after
    np.testing.assert_array_equal(first.columns["force_N"], second.columns["force_N"])
    assert first.failure_class is None
    # the force of a bar is proportional to its modulus
    slope = first.slopes["force_N", "material.mu_MPa"] * 2.93
    np.testing.assert_allclose(slope, first.columns["force_N"], rtol=1e-5)


def test_a_failed_simulation_is_classified_and_keeps_what_it_read(tmp_path: Path) -> None:
    """Stopped where its time is over, which another limit may retry."""
    job = coupon("solver.time_limit_s=1e-6")
    (found,) = Here(tmp_path).results([job])
    assert found.failure_class == "time limit"
    assert found.failure == "stopped at 0 mm (time limit): solver.time_limit_s is over"
    assert found.columns == {}
    (kept,) = Here(tmp_path).results([coupon()])
    assert kept.failure_class == "time limit"


def test_what_a_failed_simulation_read_is_kept() -> None:
    """As the store has it: NaN is null there, and a derivative has column and parameter."""
    read = {
        "columns": {"force_N": [0.0, None]}, "slopes": [["force_N", "material.mu_MPa", [1.0, 2.0]]],
    }  # fmt: skip
    found = of_row(
        {
            "result": None,
            "partial": read,
            "failure_class": "contact",
            "failure": "stopped",
            "wall_s": 1.0,
        }
    )
    np.testing.assert_array_equal(found.columns["force_N"], [0.0, np.nan])
    np.testing.assert_array_equal(found.slopes["force_N", "material.mu_MPa"], [1.0, 2.0])
    assert found.failure_class == "contact"
