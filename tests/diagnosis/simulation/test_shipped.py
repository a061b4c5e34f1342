"""Results that come with the package are used where they hold, and nowhere else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from support.here import Here, simulated

from benchmarks import shipped_file
from benchmarks.reference_measurement import reference_measurement
from dolfingrip.config import Config, changed
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.lab_setup import LabSetup
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.model import coarser
from dolfingrip.diagnosis.plan import analyse_plan
from dolfingrip.diagnosis.simulation import runner
from dolfingrip.diagnosis.simulation.runner import Shipped, Workers, request, staying
from dolfingrip.diagnosis.simulation.simulated import groups
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.jobs.cluster import Where
from dolfingrip.sections.tables import assignments

UP_DOWN_mm = [0.0, 4.0, 8.0, 4.0, 0.0]


def coupon(count: int, *overrides: str, gradients: tuple[str, ...] = ()) -> Request:
    protocol = {
        "time_s": [float(i) for i in range(count)], "displacement_mm": UP_DOWN_mm[:count],
        "cycle": [1] * count, "branch": ["loading"] * min(count, 3) + ["unloading"] * (count - 3),
    }  # fmt: skip
    return request(
        "coupon", changed(Config(), assignments(overrides)).changed(protocol=protocol), gradients
    )


PRONY = ("extensions.prony.g=[0.2]",)
ONE_OF_LIST = ("extensions.prony.g[0]",)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("shipped")
    jobs = [coupon(5, gradients=("material.mu_MPa",)), coupon(5, *PRONY, gradients=ONE_OF_LIST)]
    shipped_file.write(folder / "results.json.gz", jobs, Here(folder / "store").results(jobs))
    return folder / "results.json.gz"


def opened(file: Path) -> Shipped:
    runner.shipped.cache_clear()
    found = runner.shipped(file)
    assert found is not None
    return found


def never(asked: Request) -> Answer:
    raise AssertionError("nothing is to be computed")


def test_a_beginning_is_served(file: Path) -> None:
    asked = [
        coupon(3), coupon(4, *PRONY), coupon(3, gradients=("material.mu_MPa",)),
        coupon(3, *PRONY, gradients=ONE_OF_LIST),
    ]  # fmt: skip
    found = opened(file).answers(asked, never)
    assert [each for each, _ in found] == asked
    for each, answer in found:
        assert answer.failure_class is None
        own = compute(each)
        assert answer.columns.keys() == own.columns.keys()
        assert answer.slopes.keys() == own.slopes.keys()
        for before, now in ((answer.columns, own.columns), (answer.slopes, own.slopes)):
            for name, values in now.items():
                np.testing.assert_allclose(before[name], values, rtol=1e-5, atol=1e-5)


def test_other_configurations_protocols_and_derivatives_are_not(file: Path) -> None:
    asked = [
        coupon(3, "material.mu_MPa=3.0"),
        coupon(3, 'solver.element="P2"'),
        coupon(3, "extensions.prony.g=[0.3]"),
        coupon(3, *PRONY, gradients=("extensions.prony.tau_s[0]",)),
        replace(coupon(3), config=coupon(3).config.changed(
            protocol={"time_s": [0.0, 1.0, 2.0], "displacement_mm": [0.0, 4.0, 8.1]})),
    ]  # fmt: skip
    assert opened(file).answers(asked, never) == []


def test_stale_results_are_not_used(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The mechanics have changed: the quickest simulation is computed anew, and decides."""
    monkeypatch.setattr(runner, "core_digest", lambda: "changed")
    again: list[str] = []

    def as_before(asked: Request, factor: float = 1.0) -> Answer:
        again.append(asked.key)
        columns = compute(asked).columns
        return Answer({name: factor * values for name, values in columns.items()})

    for asked in ([coupon(3), coupon(3, *PRONY)], [coupon(3, *PRONY)]):
        again.clear()
        found = opened(file)
        known = [found.entry(each) for each in asked]
        times = [each.answer.wall_s for each in known if each is not None and each.answer.wall_s]
        quickest = asked[int(np.argmin(times))].key
        assert len(found.answers(asked, as_before)) == len(asked)
        assert again == [quickest]
        assert len(found.answers(asked, never)) == len(asked)
        assert opened(file).answers(asked, lambda each: as_before(each, 1.1)) == []


def test_an_effect_whose_code_has_changed_is_left_out(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runner, "effect_digest", lambda name: "changed")
    found = opened(file).answers([coupon(3), coupon(3, *PRONY)], never)
    assert [each for each, _ in found] == [coupon(3)]


def test_an_effects_digest_follows_its_energy() -> None:
    assert runner.effect_digest("mooney_rivlin") != runner.effect_digest("yeoh")
    assert "Constant" in runner.structure("x = 1")
    same = [runner.structure(text) for text in ('def f():\n "a"\n return 1', "def f(): return 1 #")]
    assert same[0] == same[1]


def test_the_file_that_is_shipped_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    """One of its simulations computed anew, whatever has changed since: it is there, and agrees."""
    monkeypatch.setattr(runner, "core_digest", lambda: "changed")
    measurement = reference_measurement(1, unload=False, experiments=["bending"])
    (group,) = groups(measurement, Config())
    config = changed(group.config, coarser(Config())[0])
    wanted = request("bending", config.changed(protocol=group.curve.protocol()))
    again: list[str] = []

    def computed(asked: Request) -> Answer:
        again.append(asked.key)
        return compute(asked)

    assert len(opened(runner.FILE).answers([wanted], computed)) == 1
    assert again == [wanted.key]
    assert runner.FILE.stat().st_size < 1e6


def three_cycles() -> Measurement:
    """Bending and blocked force as a laboratory reads them."""
    seed = 3
    print("seed", seed)
    planned = reference_measurement()
    noise = {"pressure_kPa": 0.5, "angle_deg": 0.3, "force_N": 0.02}
    rows = planned.readings.copy()
    rows["pressure_kPa"] += 0.5 * np.random.default_rng(seed).standard_normal(len(rows))
    tests = [replace(test, setup=LabSetup(noise=noise)) for test in planned.tests]
    return replace(planned, readings=rows, tests=tests)


def test_other_walls_are_at_hand_too(tmp_path: Path) -> None:
    """With all nuisances beside them, and no simulation."""
    found = opened(runner.FILE)
    found.agrees = True
    workers = Workers(tmp_path, Where(workers=1), known=found, computes=False)
    measurement = three_cycles()
    walls = simulated(measurement, Config(), workers).walls
    thinner, thicker = (walls[by].readings - walls[1.0].readings for by in (0.9, 1.1))
    free = (measurement.listed["column"] == "angle_deg").to_numpy()
    assert thinner[free].max() > 5.0  # degrees
    assert thicker[free].min() < -5.0


class Asked(Exception):
    """All simulations of the causes were asked for and found."""


@dataclass(frozen=True, slots=True)
class UpToTheCauses(Workers):
    def results(self, requests: Sequence[Request]) -> list[Answer]:
        found = Workers.results(self, requests)
        acting = {e.name() for each in requests for e in each.config.extensions.active()}
        if "prony" in acting:  # causes that are not known by derivatives come last
            raise Asked
        return found


@pytest.mark.slow
def test_simulations_of_all_causes_are_at_hand_too(tmp_path: Path) -> None:
    """What a plan of the paper's protocol asks for; places of causes may have changed since."""
    paper, _ = rig.read(None, Config())
    for number, measurement in enumerate((reference_measurement(), paper)):
        found = opened(runner.FILE)
        found.agrees = True
        workers = UpToTheCauses(tmp_path / f"{number}", known=found, computes=False)
        with pytest.raises(Asked):
            analyse_plan(measurement, Config(), workers, None)


def test_anew_believes_nothing(tmp_path: Path) -> None:
    for anew in (False, True):
        with staying(tmp_path, 1, lambda standing: None, anew=anew) as workers:
            assert (workers.known is None) == anew
