"""The turning point of a blocked-force curve, on curves whose answer is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import Config
from dolfingrip.experiments.blocked_force import BlockedForce
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results import turning_point
from dolfingrip.files.run import RunFile
from dolfingrip.report.page.key_numbers import of_runs
from dolfingrip.report.page.runs import Run

PRESSURES = np.arange(0.0, 251.0, 25.0)
BEFORE, AFTER = 0.011, 0.018
TOUCH_MM = 0.1


def _bent(pressure: np.ndarray, at: float) -> np.ndarray:
    return BEFORE * pressure + (AFTER - BEFORE) * np.maximum(pressure - at, 0.0)


@pytest.mark.parametrize("at", [50.0, 113.0, 140.0, 212.5])
def test_two_lines_are_found_as_they_are(at: float) -> None:
    """The curve is exactly of the fitted kind: only the grid of 20 breaks a reading is felt."""
    found = turning_point.find(PRESSURES, _bent(PRESSURES, at))
    assert found is not None
    assert found.pressure_kPa == pytest.approx(at, abs=1.0)
    assert found.slope_before_N_per_kPa == pytest.approx(BEFORE, rel=0.02)
    assert found.slope_after_N_per_kPa == pytest.approx(AFTER, rel=0.02)
    assert found.force_N == pytest.approx(BEFORE * at, rel=0.02)
    assert (found.touch_kPa, found.touching) == (None, None)


def test_noise_moves_it_little() -> None:
    """Noise of 1 % of the largest force; the bounds are four standard deviations of the fit."""
    seed = 20240817
    print(f"seed {seed}")
    rng = np.random.default_rng(seed)
    exact = _bent(PRESSURES, 140.0)
    for _ in range(20):
        found = turning_point.find(PRESSURES, exact + rng.normal(0, 0.01 * exact[-1], exact.size))
        assert found is not None
        assert found.pressure_kPa == pytest.approx(140.0, abs=60.0)
        assert found.slope_before_N_per_kPa == pytest.approx(BEFORE, rel=0.25)
        assert found.slope_after_N_per_kPa == pytest.approx(AFTER, rel=0.4)


@pytest.mark.parametrize(
    "force",
    [
        BEFORE * PRESSURES,
        0 * PRESSURES,
        -BEFORE * PRESSURES,
        np.sqrt(PRESSURES),
        BEFORE * np.minimum(PRESSURES, 140.0),
    ],
    ids=["straight", "zero", "falling", "concave", "levelling off"],
)
def test_no_turn_where_the_curve_does_not_steepen(force: np.ndarray) -> None:
    assert turning_point.find(PRESSURES, force) is None


def test_fewer_than_five_readings_are_too_few() -> None:
    pressures = np.array([0.0, 100.0, 140.0, 250.0, 300.0])
    assert turning_point.find(pressures[:4], _bent(pressures[:4], 140.0)) is None
    assert turning_point.find(pressures, _bent(pressures, 140.0)) is not None
    assert turning_point.find([], []) is None


def _find(gaps: list[dict[str, float]]) -> tuple[float | None, str | None]:
    found = turning_point.find(PRESSURES, _bent(PRESSURES, 140.0), gaps, TOUCH_MM)
    assert found is not None
    return found.touch_kPa, found.touching


def _closing(at: float) -> list[float]:
    """A gap that closes linearly to the touch and stays there, held open by the barrier."""
    return [max(TOUCH_MM + 0.012 * (at - p), 0.9 * TOUCH_MM) for p in PRESSURES.tolist()]


def test_first_touch_is_where_the_free_gap_would_have_closed() -> None:
    pairs = zip(_closing(187.0), _closing(153.0), _closing(999.0), strict=True)
    gaps = [{"1 and 2": a, "2 and 3": b, "3 and 4": c} for a, b, c in pairs]
    touch, pair = _find(gaps)
    assert pair == "2 and 3"
    assert touch == pytest.approx(153.0, abs=1e-9)


def test_first_touch_with_few_known_distances() -> None:
    """Distances are infinite while a pair is far apart."""
    none = [np.inf] * 5
    interpolated = [{"a": gap} for gap in [*none, 0.3, 0.05, 0.05, 0.05, 0.05, 0.05]]
    touch, _ = _find(interpolated)
    assert touch == pytest.approx(125.0 + 25.0 * 0.2 / 0.25)
    sudden = [{"a": gap} for gap in [*none, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05]]
    assert _find(sudden) == (125.0, "a")
    assert _find([{"a": 0.05} for _ in PRESSURES]) == (0.0, "a")
    assert _find([{"a": np.inf} for _ in PRESSURES]) == (None, None)


def test_sentence_tells_pressure_slopes_and_bellows() -> None:
    gaps = [{"bellows 1 and bellows 2": gap} for gap in _closing(153.0)]
    found = turning_point.find(PRESSURES, _bent(PRESSURES, 150.0), gaps, TOUCH_MM)
    assert found is not None
    assert found.sentence() == (
        "turning point at 150 kPa, 1.65 N: slope 0.0110 N/kPa before, 0.0180 N/kPa after; "
        "first to touch: bellows 1 and bellows 2, at 153 kPa"
    )


def test_a_page_does_not_take_the_turning_point_for_the_touch() -> None:
    gaps = [{"bellows 1 and bellows 2": gap} for gap in _closing(203.0)]
    force = _bent(PRESSURES, 150.0)
    rows = [
        {"pressure_kPa": p, "force_N": f} for p, f in zip(PRESSURES.tolist(), force, strict=True)
    ]
    for known, told in ((gaps, "bellows 1 and bellows 2, at 203 kPa"), ([], "no touch")):
        turn = turning_point.find(PRESSURES, force, known, TOUCH_MM)
        facts = RunFile(experiment="blocked_force", complete=True, turning_point=turn)
        result = Result(
            "blocked_force", Config(), rows, turning_point=turn, facts=facts, folder=Path()
        )
        number = of_runs([Run(result, BlockedForce(), "Blocked force")], {})[-1]
        assert number.value == "150 kPa"
        assert "touch" not in number.name.lower()
        assert told in number.said
