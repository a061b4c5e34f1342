"""``scripts/check`` finds the tests that are nearest to a change."""

from __future__ import annotations

from pathlib import Path

import pytest
from support import check
from support.checkout import needs_checkout

ROOT = Path(__file__).resolve().parents[1]


@needs_checkout
@pytest.mark.parametrize(
    ("changed", "file", "name"),
    [
        ("dolfingrip/sections/laws/gent.py", "tests/experiments/test_laws.py", "gent"),
        ("dolfingrip/extensions/prony.py", "tests/extensions/test_index.py", "prony"),
        ("dolfingrip/mechanics/readings/tip.py", "tests/mechanics/test_readings.py", "tip"),
        ("forms/neo_hookean.py", "tests/mechanics/test_taylor.py", "neo_hookean"),
    ],
)
def test_a_file_of_one_kind_takes_the_tests_with_its_name(
    changed: str, file: str, name: str
) -> None:
    selection = check.select([changed])
    assert file in selection.named
    assert name in selection.names


@needs_checkout
def test_the_line_of_an_index_takes_no_more_tests_than_its_file() -> None:
    law = "dolfingrip/sections/laws/gent.py"
    assert check.select([law, "dolfingrip/sections/laws/index.py"]) == check.select([law])


@needs_checkout
def test_another_file_takes_the_tests_that_import_it() -> None:
    assert "tests/design/test_campaign.py" in check.select(["dolfingrip/jobs/pool.py"]).files
    assert "tests/mechanics/test_hertz.py" in check.select(["tests/mechanics/test_hertz.py"]).files
    foods = check.select(["dolfingrip/foods/cube.py"]).files
    assert "tests/experiments/test_grasped.py" in foods
    assert check.select(["dolfingrip/extensions/prony.py"]).files == {
        "tests/extensions/test_prony.py"
    }


@needs_checkout
def test_every_file_of_the_package_has_tests() -> None:
    files = [
        str(file.relative_to(ROOT))
        for folder in check.PACKAGE
        for file in (ROOT / folder).rglob("*.py")
        if file.name != "__init__.py" and not file.is_symlink()
    ]
    assert len(files) > 400
    assert [file for file in files if not check.select([file]).commands()] == []


@needs_checkout
def test_every_test_file_that_is_named_is_there() -> None:
    named = {file for files in check.KINDS.values() for file in files} | {*check.OTHERS.values()}
    assert [file for file in sorted(named) if not (ROOT / file).exists()] == []


def test_calls_of_pytest_name_the_tests_once() -> None:
    selection = check.Selection(
        files=frozenset({"tests/a.py"}),
        named=frozenset({"tests/a.py", "tests/b.py"}),
        names=frozenset({"two_words"}),
    )
    assert selection.commands() == [
        ["tests/a.py"],
        ["tests/b.py", "-k", "two-words or two_words"],
    ]
