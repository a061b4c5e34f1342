"""Adding an effect is one file: ``foundation.py``, which docs/add_effect.md shows."""

from __future__ import annotations

from pathlib import Path

import pytest
from additions.foundation import Foundation
from support import trial
from support.checkout import needs_checkout

from dolfingrip.config import ConfigError
from dolfingrip.experiments import run
from dolfingrip.extensions.index import EFFECTS, NAMES, SHARED, effect

ONE = ("contact.self_contact=false", "experiment.max_pressure_kPa=20", "experiment.step_kPa=20")


def test_it_can_be_switched_on_and_does_what_it_says() -> None:
    soft = run("bending", trial.configured({}, *ONE), comm=trial.SELF)
    held = run("bending", trial.configured({Foundation: {}}, *ONE), comm=trial.SELF)
    assert 0.1 < held.column("angle_deg")[-1] < 0.98 * soft.column("angle_deg")[-1]


def test_its_derivatives() -> None:
    settings = trial.configured({Foundation: {}}, *ONE, "plate.gap_mm=30")
    assert min(trial.orders(trial.stirred(settings))) > 1.9


def test_its_parameters_are_checked_like_all_others() -> None:
    with pytest.raises(ConfigError, match=r"foundation.k_N_per_mm3 = -1: allowed: at least 0"):
        trial.configured({Foundation: {"k_N_per_mm3": -1}})


@needs_checkout
def test_a_file_is_all_that_an_effect_needs() -> None:
    assert [effect(name) for name in NAMES] == list(EFFECTS)
    folder = Path(__file__).resolve().parents[2] / "dolfingrip" / "extensions"
    assert {file.stem for file in folder.glob("*.py")} - {"__init__", *SHARED} == set(NAMES)


def test_effects_act_in_their_order() -> None:
    """What scales or remembers a strain energy comes after what adds to it, drift after offset."""
    orders = (
        ("mooney_rivlin", "print_anisotropy", "mullins", "permanent_set", "prony",
         "temperature_drift"),
        ("wall_offset", "coarse_mesh", "locking"),
        ("pressure_gain", "pressure_offset", "set_point_logged"),
        ("force_gain", "force_offset", "zero_drift"),
        ("angle_definition", "angle_gain", "sensor_lag", "angle_offset"),
    )  # fmt: skip
    for order in orders:
        places = [NAMES.index(name) for name in order]
        assert places == sorted(places), order
    elastic = [each for each in EFFECTS if each.kind == "elastic"]
    assert {each.place for each in elastic} == {0}  # their sum has no order
