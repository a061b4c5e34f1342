"""Every number of the configuration has a range that means something, and a line that tells it."""

import importlib
import json
import pkgutil
from collections.abc import Iterator
from typing import Any, get_origin

import pytest
from pydantic import ValidationError

import dolfingrip.sections
from dolfingrip import config
from dolfingrip.cli.command import settings_of
from dolfingrip.cli.commands import COMMANDS
from dolfingrip.config import ConfigError
from dolfingrip.sections import errors
from dolfingrip.sections.section import Section

SECTIONS = (dolfingrip.sections.__path__, "dolfingrip.sections.")

for module in (
    *(
        each.name
        for each in pkgutil.walk_packages(dolfingrip.sections.__path__, "dolfingrip.sections.")
    ),
    "dolfingrip.design.gradient.file",
    "dolfingrip.design.optimum.study_file",
    "dolfingrip.diagnosis.data.rig",
):
    importlib.import_module(module)

ANY: dict[str, str] = {"seed": "any seed makes random numbers"}
"""Keys for which a huge whole number means something, and why."""


def _below(kind: type[Section]) -> Iterator[type[Section]]:
    for each in kind.__subclasses__():
        yield each
        yield from _below(each)


def _numbers() -> Iterator[tuple[type[Section], str, type, Any]]:
    """Class, key, type of the number, and how the key holds it: alone, in a list or a table."""
    for kind in sorted(set(_below(Section)), key=lambda each: (each.__module__, each.__qualname__)):
        for key, info in kind.model_fields.items():
            hint = errors.bare(info.annotation)
            entry = errors.entry_of(hint)[0]
            if hint in (float, int):
                yield kind, key, hint, lambda value: value
            elif entry in (float, int) and get_origin(hint) is dict:
                yield kind, key, entry, lambda value: {"cavity": value}
            elif entry in (float, int):
                yield kind, key, entry, lambda value: [value] * 3


FOUND = [*_numbers()]


@pytest.mark.parametrize(
    "value", [1e-300, -1e-300, 1e18, -1e18, float("nan"), float("inf"), 1e-320]
)
def test_every_number_has_a_range(value: float) -> None:
    """A number that is no size of anything is refused for every key, with its range."""
    assert len(FOUND) > 250
    wrong = []
    for kind, key, number, held in FOUND:
        given = int(value) if number is int and abs(value) == 1e18 else value
        if key in ANY and given == 10**18:
            continue
        found = _refused(kind, {key: held(given)})
        said = errors.reason(found, kind.model_fields[key], key) if found else ""
        told = said.partition("allowed: ")[2]
        low, high = "at least" in told or "above" in told, "at most" in told or "below" in told
        if not low or not (high or number is int):
            wrong.append(f"{kind.__module__}.{kind.__qualname__}.{key} = {given}: {said}")
    assert not wrong


def _refused(kind: type[Section], table: dict[str, Any]) -> str:
    """The kind of error that the only key of a table has; "" if it has none."""
    (key,) = table
    try:
        kind.model_validate(table)
    except ValidationError as error:
        return next((e["type"] for e in error.errors() if e["loc"] and e["loc"][0] == key), "")
    return ""


def test_defaults_are_in_their_ranges() -> None:
    """No default is refused where it is written down."""
    for kind, key, _, _ in FOUND:
        info = kind.model_fields[key]
        if info.is_required() or info.default is None:
            continue
        found = _refused(kind, {key: json.loads(json.dumps(info.default))})
        assert not found, f"{kind.__module__}.{kind.__qualname__}.{key} = {info.default}: {found}"


@pytest.mark.parametrize(
    ("key", "value", "line"),
    [
        ("solver.atol_N", 1e300, "allowed: at least 1e-30 and at most 0.0001 N"),
        ("coupon.gauge_length_mm", 1e-300, "allowed: at least 0.001 and at most 1000 mm"),
        ("material.mu_MPa", 1e-300, "allowed: at least 1e-06 and at most 1000000 MPa"),
        ("material.film.mu_MPa", 1e18, "allowed: at least 1e-06 and at most 1000000 MPa"),
        ("experiment.hold_s", 1e-300, "nearer to 0 than 1e-30; allowed: at least 0 and at most"),
        ("cavity.left.closed_at_kPa", 1e-300, "allowed: at least 0.0001 and at most 10000 kPa"),
        (
            "extensions.prony.tau_s",
            [1e18],
            "a list of 1 to 3 numbers, each at least 1e-09",
        ),
    ],
)
def test_lines_name_key_value_and_range(key: str, value: object, line: str) -> None:
    """The line begins with the whole key and its value, and tells the range with its unit."""
    with pytest.raises(ConfigError) as refused:
        config.load(None, {key: value})
    assert str(refused.value).startswith(f"{key} = {value}: "), refused.value
    assert line in str(refused.value), refused.value


@pytest.mark.parametrize("section", ["mesh", "food", "obstacle"])
def test_a_path_with_a_nul_is_refused(section: str) -> None:
    """No file can be called so; TOML's and JSON's texts may have the character."""
    with pytest.raises(ConfigError, match=rf"^{section}\.file = .*: allowed: a text without"):
        config.load(None, {f"{section}.file": "a\0b.stl"})


OPTIONS = [
    (f"{command.name} {each.flag}", each)
    for first in COMMANDS
    for command in (first, *first.below)
    for each in settings_of(command.settings)
    if each.bare in (float, int) and not each.key and not each.read
]


@pytest.mark.parametrize(
    "value", [1e-300, -1e-300, 1e18, -1e18, float("nan"), float("inf"), 10**18, -(10**18), 10**400]
)
def test_every_number_of_a_command_line_has_a_range(value: float) -> None:
    """As a key of the configuration: a seed may be any whole number, a count not."""
    assert len(OPTIONS) > 30
    for name, each in OPTIONS:
        whole = each.bare is int
        if whole != isinstance(value, int) or (whole and each.least is None):
            continue
        with pytest.raises(ConfigError, match=rf"^{each.flag} .*: allowed: ") as refused:
            each.value([value] if each.repeatable else value)
        assert len(str(refused.value)) < 200, name
