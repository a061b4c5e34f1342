"""What `--set` sets, `--parameters` names and `--parameter` varies are the same objects."""

from __future__ import annotations

from dataclasses import replace

import pytest
from test_config import REFUSED

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.parameter import check, every, named
from dolfingrip.sections.tables import assignments


def _said(assignment: str) -> str:
    """What is said against an assignment; nothing where it passes."""
    try:
        check(assignments([assignment]))
    except ConfigError as error:
        return str(error)
    return ""


def test_a_number_is_refused_with_the_configuration_s_words() -> None:
    """Those of one number by itself; the configuration checks texts, tables and dimensions."""
    checked = 0
    for assignment, words in REFUSED.items():
        said = _said(assignment)
        if not said:
            continue
        with pytest.raises(ConfigError) as refused:
            config.load(None, assignments([assignment]))
        assert said in (f"--set {refused.value}", str(refused.value))
        assert words in said
        checked += 1
    assert checked > 15


@pytest.mark.parametrize(
    "assignment",
    ["finger.wall_mm=1.8", "finger.bellows=5", "finger.length_mm=80", "mesh.half=false",
     "extensions.prony={}", "extensions.gent.inverse_J_m=0.1", "plate.normal=[1, 0, 0]",
     "solver.element=P1", "solver.time_limit_s=600", "extensions.prony.g=[0.2]"],
)  # fmt: skip
def test_what_is_allowed_passes(assignment: str) -> None:
    check(assignments([assignment]))


def test_a_value_has_no_keys() -> None:
    assert (
        _said("finger.wall_mm.x=1") == "--set finger.wall_mm.x: wall_mm is a value, not a section"
    )
    assert _said("extensions.angle_gain.gain=inf").startswith(
        "--set extensions.angle_gain.gain = Infinity: not a finite number; allowed: "
    )


def test_a_key_finds_the_parameter_that_derivatives_are_taken_to() -> None:
    """The same unit, bounds, prior and way of entering; the scale may be another value's."""
    at = config.load(None, assignments([f"extensions.{effect.name()}={{}}" for effect in EFFECTS]))
    found = [parameter for parameter in every(at) if "[" not in parameter.key]
    assert len(found) > 40
    for parameter in found:
        assert replace(named(parameter.key), scale=parameter.scale) == parameter
