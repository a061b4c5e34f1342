"""The loop of diagnosis and experiment: what a result file advises is done by its fields alone."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.pretended_finger import Pretended

from benchmarks.blind import ci, frozen
from benchmarks.blind.fingers import cases as fingers
from benchmarks.blind.fingers.finger import Truth
from benchmarks.blind.frozen import FrozenCase
from benchmarks.blind.loop import cases, rounds, scores
from benchmarks.blind.loop.laboratory import Laboratory, truth_of
from benchmarks.blind.said import rows
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.additions.checks import checks, coupon_check, numbers_read
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.simulation.nuisances import keys
from dolfingrip.experiments.derivatives.gradients import MASS, shape_number
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files.diagnosis import NextExperiment

SEED = (5, 7)
OFF_N = 0.05
FAR = {"wall_offset": 1.2, "plate_gap": 0.6, "pressure_gain": -1.0, "pressure_offset": 0.5}
TRUTH = Truth({"extensions.force_offset.offset_N": OFF_N}, modulus=1.2, far=FAR)


@pytest.fixture
def laboratory(tmp_path: Path) -> Laboratory:
    """With its first measurement."""
    print("seed", SEED)
    workers = Pretended(tmp_path / "hidden")
    true = fingers.finger.measured(cases.SMALL, TRUTH, workers)
    noisy = fingers.finger.scattered(cases.SMALL, true, np.random.default_rng(SEED))
    file = fingers.finger.write(cases.SMALL, noisy, tmp_path / "first")
    return Laboratory(cases.SMALL, TRUTH, workers, SEED, [(cases.SMALL, file)])


def advised(addition: Any) -> NextExperiment:
    """An addition as a result file has it: written and read again."""
    made = NextExperiment(
        name=addition.name, minutes=addition.minutes, gain=1.0, gain_per_minute=0.1, chance=0.5,
        tests=addition.tests, quantities=addition.quantities,
    )  # fmt: skip
    return NextExperiment.model_validate_json(made.model_dump_json())


def test_the_truth_comes_back_from_its_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(fingers, "Workers", Pretended)
    bench = fingers.Bench(cases.SMALL, tmp_path, 1, ci.EFFECTS)
    case = fingers.drawn_from(bench, SEED, cases.KIND, 0, cases.SEEN)
    assert case.sigma[0] >= cases.SEEN
    kept = FrozenCase.of({k: f"{v}" for k, v in fingers.frozen(bench, case).row().items()})
    again = truth_of(kept, cases.SMALL)
    assert again.modulus == pytest.approx(case.truth.modulus)
    assert again.causes == pytest.approx(case.truth.causes)
    assert again.far == pytest.approx(case.truth.far)


def test_committed_cases_are_measured_data(tmp_path: Path) -> None:
    for protocol, plan in cases.PROTOCOLS.items():
        for case in frozen.cases(protocol, cases.FOLDER):
            assert min(case.sigma) >= cases.SEEN * (1 - 1e-3)
            file = frozen.written(case, tmp_path / case.name, cases.FOLDER)
            assert not read([file], plan.analysed()).warnings


def test_every_further_measurement_is_made_as_it_is_told(
    laboratory: Laboratory, tmp_path: Path
) -> None:
    """Reference: the rows of the proposals, which the analyser would simulate."""
    first = read(laboratory.write(tmp_path), laboratory.config)
    every = proposals(first, laboratory.config)
    kinds = {"cycles", "hold", "tip", "gap", "orientation", "coupon"}
    assert kinds <= {proposal.kind for proposal in every}
    for turn, proposal in enumerate(every):
        before = len(laboratory.tests)
        plan = advised(proposal)
        laboratory.do(plan, turn)
        assert len(laboratory.tests) == before + len(plan.tests)
        files = laboratory.write(tmp_path)[before:]
        made = read(files, laboratory.config)
        assert not made.warnings
        for number, test in enumerate(plan.tests):
            again = made.rows(number)
            assert tuple(again[test.control]) == pytest.approx(test.value)
            assert tuple(again["time_s"]) == pytest.approx(np.array(test.time_s), rel=1e-5)
            assert set(test.read) == {name for name in made.columns if again[name].notna().any()}
            applied = made.tests[number].applied(laboratory.config)
            for key, value in test.settings.items():
                section, _, name = key.partition(".")
                shown = getattr(getattr(applied, section), name)
                assert np.asarray(shown) == pytest.approx(np.asarray(value))
    together = read(laboratory.write(tmp_path), laboratory.config)
    assert keys(together, laboratory.config)
    again = {proposal.name for proposal in proposals(together, laboratory.config)}
    done = {proposal.name for proposal in every if proposal.kind in {"cycles", "hold", "tip"}}
    assert again
    assert again.isdisjoint(done)


def test_every_check_reads_a_hidden_number_and_is_told(
    laboratory: Laboratory, tmp_path: Path
) -> None:
    """All that effects and the body tell how to read goes into the measurement by its key."""
    config = cases.SMALL.analysed()
    every = [*checks(config), coupon_check(Policy())]
    expected: dict[str, float] = {}
    for turn, check in enumerate(every):
        plan = advised(check)
        assert plan.quantities
        laboratory.do(plan, turn)
        expected |= {quantity.key: quantity.std for quantity in plan.quantities}
    made = read(laboratory.write(tmp_path), laboratory.config)
    assert not made.warnings
    assert keys(made, laboratory.config)
    told = {reading.key: reading for reading in numbers_read(made, laboratory.config)}
    gauge_mm = expected.pop("plate.gap_mm")
    assert {key: reading.std for key, reading in told.items()} == pytest.approx(expected)
    assert {"mass_g", "modulus", "finger.wall_mm"} <= told.keys()
    first = made.tests[0]
    assert first.setup.nuisances["plate_gap_mm"] == gauge_mm
    true = fingers.finger.configured(cases.SMALL, TRUTH)
    gap_mm = made.tests[-1].applied(config).plate.gap_mm
    # of twenty numbers that were read, none is four standard deviations off
    assert gap_mm == pytest.approx(true.plate.gap_mm, abs=4 * gauge_mm)
    hidden = {
        "modulus": 1.2, "finger.wall_mm": true.finger.wall_mm,
        "finger.base_layer_mm": config.finger.base_layer_mm,
        "mass_g": shape_number(MASS, true, ())[0], "extensions.force_offset.offset_N": OFF_N,
        "extensions.pressure_gain.gain": true.extensions.pressure_gain.gain,
        "extensions.angle_gain.gain": 1.0, "extensions.gravity_pitch.acceleration_m_s2": 0.0,
    }  # fmt: skip
    for key, value in hidden.items():
        assert told[key].value != value
        assert told[key].value == pytest.approx(value, abs=4 * told[key].std)


def result(name: str, answer: str, effects: tuple[str, ...], chance: float) -> Any:
    number = outcome.FittedNumber(key="material.mu_MPa", value=3.5, low=3.0, high=4.0, unit="MPa")
    verdict = {"answer": answer, "class": effects, "probability": chance, "takes_part": chance}
    (check,) = (one for one in checks(cases.SMALL.analysed()) if one.name == name)
    return outcome.DiagnosisFile(
        version="0", data=(), quick=False, readings=1, causes=(), none=0.0, unknown=0.0,
        verdict=outcome.Verdict.model_validate(verdict), next_experiments=(advised(check),),
        headline=outcome.Headline(number=number, option=""), simulated_s=0.0,
        fits=(outcome.FittedHypothesis(effects=(), log_evidence=0.0, parameters=(number,)),),
    )  # fmt: skip


CASE = FrozenCase(
    "small", cases.KIND, 0, False, ("force_offset",), sigma=(9.0,),
    numbers={"modulus": 1.2, "finger.wall_mm": 1.7},
)  # fmt: skip


def test_a_loop_that_is_killed_goes_on(
    laboratory: Laboratory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first answer is wrong and sure; a weight at the load cell tells the cause."""
    monkeypatch.setattr(frozen, "cases", lambda protocol, folder: [CASE])
    (weight,) = (
        check.name for check in checks(cases.SMALL.analysed())
        if any("extensions.force_offset.offset_N" in each.numbers for each in check.readings)
    )  # fmt: skip
    stands: list[tuple[int, bool]] = []
    key = "extensions.force_offset.offset_N"

    def diagnosing(here: Laboratory, folder: Path) -> outcome.DiagnosisFile:
        stands.append((len(here.tests), key in here.read))
        if len(stands) == 2:
            raise KeyboardInterrupt
        answer = result(weight, *(("cause", ("force_offset",), 0.9) if key in here.read
                                 else ("cause", ("yeoh",), 0.95)))  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        answer.write(folder)
        return answer

    def run(here: Laboratory) -> None:
        rounds.run(CASE, here, diagnosing, tmp_path / "case", 2, tmp_path / "small.csv")

    with pytest.raises(KeyboardInterrupt):
        run(laboratory)
    again = Laboratory(cases.SMALL, TRUTH, laboratory.workers, SEED, laboratory.tests[:1])
    run(again)
    run(again)  # nothing is left to do
    assert stands == [(1, False), (1, True), (1, True)]
    table = rows(tmp_path / "small.csv")
    assert [(row["round"], row["answer"], row["first"]) for row in table] == [
        ("0", "cause", "yeoh"), ("1", "cause", "force_offset"),
    ]  # fmt: skip
    assert table[0]["advised"] == weight
    assert table[1]["undone"] == f"{weight}: it was done before"
    assert [row["covers"] for row in table] == ["1", "1"]  # 3.52 MPa is within 3.0 to 4.0
    figures = scores.table(list(scores.answers(tmp_path)), cases.FINGERS).splitlines()
    named, wrong, held, *_ = (line.split(" | ")[2:] for line in figures[2:])
    assert [cell.partition(" (")[0] for cell in named] == ["0 of 1", "1 of 1", "1 of 1"]
    assert [cell.partition(" (")[0] for cell in wrong] == ["1 of 1", "0 of 1", "0 of 1"]
    assert held[0].startswith("1 of 1")
    assert figures[-1] == "small, reference: 1 of 40 cases are finished."


def test_a_refused_setup_ends_a_case(laboratory: Laboratory, tmp_path: Path) -> None:
    def diagnosing(here: Laboratory, folder: Path) -> outcome.DiagnosisFile:
        raise ConfigError("nuisance.wall = -1: allowed: at least 0")

    rounds.run(CASE, laboratory, diagnosing, tmp_path / "case", 2, tmp_path / "small.csv")
    (row,) = rows(tmp_path / "small.csv")
    assert (row["answer"], row["undone"]) == (
        rounds.REFUSED, "nuisance.wall = -1: allowed: at least 0",
    )  # fmt: skip


def test_a_diagnosis_that_takes_too_long_ends_a_case(
    laboratory: Laboratory, tmp_path: Path
) -> None:
    def diagnosing(here: Laboratory, folder: Path) -> outcome.DiagnosisFile:
        time.sleep(60)
        raise AssertionError

    table = tmp_path / "small.csv"
    for _ in range(2):  # nothing is left to do the second time
        rounds.run(CASE, laboratory, diagnosing, tmp_path / "case", 2, table, minutes=1e-3)
    (row,) = rows(table)
    assert (row["answer"], row["undone"]) == (rounds.LATE, "no answer within 0.001 minutes")
