"""A change of the configuration is a mapping; ``section.key=value`` is the command line's alone."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.checkout import needs_checkout

import dolfingrip
from dolfingrip import config
from dolfingrip.config import Config, ConfigError, changed

PACKAGE = Path(dolfingrip.__file__).parent
OF_THE_COMMAND_LINE = (
    "cli", "sections/tables.py", "design/campaign/space.py", "importing/told.py",
)  # fmt: skip
"""Folders and files that read or write assignments as text."""


def _pairs(tree: ast.AST) -> Iterator[int]:
    """Lines that write ``{key}={value}``, or take such a text apart."""
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            for first, middle, last in zip(
                node.values, node.values[1:], node.values[2:], strict=False
            ):
                if (
                    isinstance(first, ast.FormattedValue)
                    and isinstance(last, ast.FormattedValue)
                    and isinstance(middle, ast.Constant)
                    and middle.value in ("=", "=[")
                ):
                    yield node.lineno
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            parted = node.func.attr in ("partition", "rpartition", "split")
            if parted and any(isinstance(a, ast.Constant) and a.value == "=" for a in node.args):
                yield node.lineno


def test_assignments_are_seen() -> None:
    text = "a = f'{key}={value}'\nb = f'{key}=[{value!r}]'\nc = text.partition('=')\nd = f'x = {c}'"
    assert list(_pairs(ast.parse(text))) == [1, 2, 3]


@needs_checkout
def test_no_change_travels_as_text() -> None:
    found = [
        f"{file.relative_to(PACKAGE)}:{line}"
        for file in sorted(PACKAGE.rglob("*.py"))
        if not str(file.relative_to(PACKAGE)).startswith(OF_THE_COMMAND_LINE)
        for line in _pairs(ast.parse(file.read_text(encoding="utf-8")))
    ]
    assert found == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"finger.wal_mm": 1}, "finger.wal_mm: unknown key; did you mean finger.wall_mm? allowed"),
        ({"finger.wall_mm": -1}, "finger.wall_mm = -1: allowed: "),
        ({"morph.xi1": 2, "finger.bellows": 1.5}, "finger.bellows = 1.5: not an integer; "),
    ],
)
def test_a_bad_change_is_one_line_in_python_s_words(change: config.Change, said: str) -> None:
    for act in (lambda: config.load(overrides=change), lambda: changed(Config(), change)):
        with pytest.raises(ConfigError) as refused:
            act()
        assert str(refused.value).startswith(said)
        assert "--" not in str(refused.value)


def test_a_text_is_no_change() -> None:
    with pytest.raises(ConfigError, match=r"^\['finger.wall_mm=1'\]: allowed: values by key"):
        config.load(overrides=["finger.wall_mm=1"])  # type: ignore[arg-type]


def test_a_value_has_no_keys_and_a_list_no_entry_beyond_its_end() -> None:
    with pytest.raises(ConfigError, match=r"^finger.wall_mm.x: wall_mm is a value, not a section$"):
        changed(Config(), {"finger.wall_mm.x": 1})
    on = changed(Config(), {"extensions.prony.g": [0.1]})
    with pytest.raises(ConfigError, match=r"prony\.g\[1\]: no such entry; allowed: 0 to 0$"):
        changed(on, {"extensions.prony.g[1]": 0.1})


def test_a_change_reaches_tables_that_are_absent_and_entries_of_lists() -> None:
    """The configuration that is changed stays as it is."""
    base = Config()
    on = changed(base, {"extensions.prony.g": [0.1], "film.silk.Et_N_per_mm": 5.0})
    assert on.extensions.prony.g == (0.1,)
    assert on.film.all["silk"].Et_N_per_mm == 5.0
    assert changed(on, {"extensions.prony.g[0]": 0.2}).extensions.prony.g == (0.2,)
    assert base == Config()
