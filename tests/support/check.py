"""Checks a change: style, types, imports, and the tests that are nearest to what changed.

    scripts/check            # what differs from main, with what is not committed
    scripts/check COMMIT     # what differs from another commit
    scripts/check --list     # only say which tests it would run

Everything that it leaves out, continuous integration runs.
"""

from __future__ import annotations

import argparse
import ast
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
PACKAGE: Final = ("dolfingrip", "forms", "meshes")
TESTS: Final = ("tests", "benchmarks/tests")
"""Folders of tests; benchmarks have their own."""

KINDS: Final = {
    "dolfingrip/sections/laws": (
        "tests/experiments/test_laws.py", "tests/experiments/test_material_fit.py",
        "tests/test_config.py",
    ),
    "dolfingrip/extensions": (
        "tests/extensions/test_index.py", "tests/extensions/test_neutral.py",
        "tests/extensions/test_elastic.py", "tests/extensions/test_instruments.py",
        "tests/extensions/test_setup.py", "tests/extensions/test_supply.py",
        "tests/test_config.py",
    ),
    "dolfingrip/foods": (
        "tests/mechanics/test_shapes.py", "tests/meshes/test_closed_surface.py",
        "tests/experiments/test_grasped.py",
    ),
    "dolfingrip/mechanics/readings": (
        "tests/mechanics/test_readings.py", "tests/test_columns.py",
    ),
    "forms": (
        "tests/mechanics/test_taylor.py", "tests/experiments/test_laws.py",
        "tests/extensions/test_index.py", "tests/forms/test_examples.py",
    ),
    "docs": ("tests/test_docs.py", "tests/test_advice.py", "tests/test_newcomer.py"),
}  # fmt: skip
"""Test files that take every file of a folder as a parameter; those with its name are run."""

WHOLE: Final = ("docs", "dolfingrip/foods")
"""Folders whose tests do not have the names of files."""

OTHERS: Final = {
    "pyproject.toml": "tests/test_installation.py",
    "CHANGELOG.md": "tests/test_installation.py",
}
"""Tests of files that are no Python."""


@dataclass(frozen=True)
class Selection:
    """Tests to be run.

    Attributes:
        files: test files that are run whole.
        named: test files of which those tests are run that have one of ``names``.
        names: of changed files.
    """

    files: frozenset[str]
    named: frozenset[str] = frozenset()
    names: frozenset[str] = frozenset()

    def commands(self) -> list[list[str]]:
        """Arguments of pytest, one list for each call."""
        calls = [sorted(self.files)] if self.files else []
        if left := sorted(self.named - self.files):
            words = {word for name in self.names for word in (name, name.replace("_", "-"))}
            calls.append([*left, *(["-k", " or ".join(sorted(words))] if words else [])])
        return calls


def select(changed: Iterable[str], root: Path = ROOT) -> Selection:
    """The tests that are nearest to changed files.

    Args:
        changed: paths from the root of the checkout.
        root: of the checkout.

    Returns:
        Changed tests; tests of the same name; test files that import a changed module; of folders
        whose files are parameters of tests, those with the file's name; else the nearest folder of
        tests.
    """
    files: set[str] = set()
    named: set[str] = set()
    names: set[str] = set()
    for name in changed:
        path = Path(name)
        if path.match("test_*.py") and any(path.is_relative_to(folder) for folder in TESTS):
            if (root / path).exists():
                files.add(name)
            continue
        kind = next((each for each in KINDS if path.is_relative_to(each)), None)
        if kind in WHOLE:
            files.update(KINDS[kind])
        elif path.suffix == ".py" and path.parts[0] in PACKAGE:
            if kind is not None:
                named.update(each for each in KINDS[kind] if (root / each).exists())
                if path.stem == "index":  # its line is that of a file beside it
                    continue
                names.add(path.stem)
            near = {*same_name(path, root), *(importing(path, root) if kind is None else ())}
            files |= near
            if kind is None and not near:
                files |= nearest(path, root)
        elif path.parts[0] == "examples":
            named.add("tests/test_examples.py")
            names.add(path.stem)
        elif name in OTHERS:
            files.add(OTHERS[name])
    return Selection(frozenset(files), frozenset(named), frozenset(names))


def mirrored(path: Path) -> Path:
    """The folder of tests that belongs to a file of the package."""
    parts = path.parent.parts
    return Path("tests", *(parts[1:] if parts[0] == "dolfingrip" else parts))


def same_name(path: Path, root: Path) -> set[str]:
    """Test files that are called as a file of the package."""
    folder = mirrored(path)
    for place in (folder, *folder.parents[:-1]):
        found = sorted((root / place).glob(f"**/test_{path.stem}.py"))
        if found:
            return {str(each.relative_to(root)) for each in found}
    return set()


def importing(path: Path, root: Path) -> set[str]:
    """Test files that import a file of the package."""
    parts = path.with_suffix("").parts
    module = ".".join(parts if parts[0] == "dolfingrip" else ("dolfingrip", *parts))
    return {
        str(file.relative_to(root))
        for folder in TESTS
        for file in sorted((root / folder).rglob("test_*.py"))
        if module.removesuffix(".__init__") in imports(file)
    }


@cache
def imports(file: Path) -> set[str]:
    """Modules that a file imports, and names that it takes from them."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
            found.update(f"{node.module}.{each.name}" for each in node.names)
    return found


def nearest(path: Path, root: Path) -> set[str]:
    """The test files of the nearest folder of tests."""
    folder = mirrored(path)
    while not (root / folder).is_dir():
        folder = folder.parent
    return {str(each.relative_to(root)) for each in (root / folder).glob("test_*.py")}


def changed_files(commit: str | None) -> list[str]:
    """Files that differ from a commit, or from where this branch left main, and new ones."""
    if commit is None:
        base = git("merge-base", "HEAD", "main") or git("merge-base", "HEAD", "origin/main")
        commit = base.strip() or "HEAD"
    names = git("diff", "--name-only", commit) + git("ls-files", "--others", "--exclude-standard")
    return sorted(set(names.splitlines()))


def git(*words: str) -> str:
    """What git prints; "" where it fails."""
    ended = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    return ended.stdout if ended.returncode == 0 else ""


def collected(arguments: Sequence[str]) -> int:
    """The number of tests that pytest would run."""
    command = [sys.executable, "-m", "pytest", "-n", "0", "--collect-only", "-q", *arguments]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return sum("::" in line for line in ended.stdout.splitlines())


def tests_in(folder: Path) -> int:
    """The number of test functions below a folder."""
    return sum(
        isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
        for file in folder.rglob("test_*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
    )


def step(title: str, *command: str) -> bool:
    """Run a part of the check; say how it ended and how long it took."""
    began = time.monotonic()
    passed = subprocess.run(command, cwd=ROOT, check=False).returncode in (0, 5)  # 5: no tests
    print(f"{'passed' if passed else 'FAILED'}: {title} ({time.monotonic() - began:.0f} s)",
          flush=True)  # fmt: skip
    return passed


def main() -> int:
    """Check a change.

    Returns:
        0 if all passed.
    """
    parser = argparse.ArgumentParser(
        prog="scripts/check", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("commit", nargs="?", help="compare with this commit; default: main")
    parser.add_argument("--list", action="store_true", help="only say which tests would run")
    asked = parser.parse_args()
    changed = changed_files(asked.commit)
    if not changed:
        print("nothing has changed")
        return 0
    selection = select(changed)
    calls = selection.commands()
    print(f"{len(changed)} changed files; tests: "
          f"{' '.join(word for call in calls for word in call) or 'none'}", flush=True)  # fmt: skip
    if asked.list:
        return 0
    python = [each for each in changed if each.endswith(".py") and (ROOT / each).exists()]
    passed = []
    if python:
        passed.append(step("style", "ruff", "check", *python))
        passed.append(step("format", "ruff", "format", "--check", *python))
    if any(each.split("/")[0] in PACKAGE for each in python):
        passed.append(step("types", "mypy"))
        passed.append(step("imports", "scripts/lint-imports"))
    ran = 0
    for call in calls:
        number = collected(call)
        if "-k" in call and not number:  # no test has the file's name
            call = call[: call.index("-k")]
            number = collected(call)
        passed.append(step("tests", sys.executable, "-m", "pytest", "-q", *call))
        ran += number
    left = sum(tests_in(ROOT / folder) for folder in TESTS)
    print(f"{ran} tests were run here; CI runs all of the {left} test functions, slow ones too")
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
