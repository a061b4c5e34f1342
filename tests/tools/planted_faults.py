"""Plants faults, one at a time, in a copy of the tree, and counts those that the tests catch.

``scripts/plant-faults`` runs it. ``planted_faults.toml`` lists the faults: a file, a text that it
holds once, what stands in its place, and the test files that should fail then.
``planted_faults.csv`` keeps the outcomes; its column ``at_first`` says whether the tests of the
first run of a fault caught it. ``mutants.toml`` is another such list, which ``mutants.py`` drew; a
mutant that no test can tell from the code has a key ``equivalent`` that says why, and is not run.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
LISTS = ("planted_faults", "mutants")
COLUMNS = ("fault", "file", "what", "at_first", "now", "by")
TEMPORARY = "dolfingrip-planted-"
LONGEST_s = 900
"""Time (s) of one fault's tests; a fault that makes them run longer is caught."""

PASSED, FAILED, INTERRUPTED = 0, 1, 2
"""Exit codes of pytest, the last where a file of tests cannot be imported; others say that there
are no such tests."""


@dataclass(frozen=True)
class Fault:
    """A fault and the tests that should catch it.

    Attributes:
        name: unique.
        file: relative to the checkout.
        text, fault: what stands in the file once, and what is put there.
        what: the fault in a few words.
        tests: files, folders or node ids below ``tests/``.
        only: pytest's ``-k``, "" for all.
        equivalent: why the code does the same with it; "" where it is a fault.
    """

    name: str
    file: str
    text: str
    fault: str
    what: str
    tests: tuple[str, ...]
    only: str = ""
    equivalent: str = ""

    def amiss(self) -> str:
        """Why it cannot be planted in the checkout, "" where it can."""
        file = ROOT / self.file
        found = file.read_text(encoding="utf-8").count(self.text) if file.is_file() else 0
        for test in self.tests:
            if not (ROOT / "tests" / test.partition("::")[0]).exists():
                return f"{self.name}: no tests/{test}"
        return (
            "" if found == 1 else f"{self.name}: {self.file} has its text {found} times, not once"
        )

    def planted(self, source: str) -> str:
        """A source with the fault."""
        return source.replace(self.text, self.fault)


def listed(name: str) -> list[Fault]:
    """All faults of a list."""
    with (HERE / f"{name}.toml").open("rb") as file:
        tables = tomllib.load(file)
    return [
        Fault(name=name, **{**table, "tests": tuple(table["tests"])})
        for name, table in tables.items()
    ]


@contextmanager
def copied() -> Iterator[Path]:
    """A copy of what git knows of, as it stands now; Python imports it, not the checkout."""
    with tempfile.TemporaryDirectory(prefix=TEMPORARY) as folder:
        copy = Path(folder)
        names = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        ).stdout  # fmt: skip
        for name in filter(None, names.split("\0")):
            if (ROOT / name).is_file():
                (copy / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, copy / name)
        for name in ("forms", "meshes"):  # parts of the package that lie next to it
            (copy / "dolfingrip" / name).symlink_to(copy / name)
        yield copy


def tested(copy: Path, fault: Fault) -> tuple[bool, str]:
    """Tell if the fault's tests fail in the copy, and which does.

    Raises:
        RuntimeError: the tests cannot be run.
    """
    call = [sys.executable, "-m", "pytest", "-n0", "-m", "", "-x", "-q", "-p", "no:cacheprovider"]
    call += [f"tests/{each}" for each in fault.tests] + (["-k", fault.only] if fault.only else [])
    environment = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        ended = subprocess.run(
            call, cwd=copy, env=environment, capture_output=True, text=True, check=False,
            timeout=LONGEST_s,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return True, f"longer than {LONGEST_s} s"
    if ended.returncode not in (PASSED, FAILED, INTERRUPTED):
        raise RuntimeError(f"{fault.name}: {ended.stdout[-2000:]}{ended.stderr[-2000:]}")
    failed = [line.split(" ")[1] for line in ended.stdout.splitlines()
              if line.startswith(("FAILED ", "ERROR "))]  # fmt: skip
    return ended.returncode != PASSED, failed[0].removeprefix("tests/") if failed else ""


def read(file: Path) -> dict[str, dict[str, str]]:
    """Outcomes so far, by the fault's name."""
    if not file.exists():
        return {}
    with file.open(encoding="utf-8", newline="") as text:
        return {row["fault"]: row for row in csv.DictReader(text)}


def write(rows: dict[str, dict[str, str]], file: Path) -> None:
    """Write outcomes."""
    with file.open("w", encoding="utf-8", newline="") as text:
        table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows.values())


def main(arguments: Sequence[str] | None = None) -> int:
    """Plant the faults; 1 where one is not caught."""
    parser = argparse.ArgumentParser(prog="scripts/plant-faults", description=__doc__)
    parser.add_argument("names", nargs="*", help="of the faults; default: all")
    parser.add_argument("--list", choices=LISTS, default=LISTS[0], help="of faults")
    parser.add_argument("--missed", action="store_true", help="those alone that were not caught")
    parser.add_argument("--check", action="store_true", help="only whether each can be planted")
    parser.add_argument("--without", action="store_true", help="run their tests without the fault")
    asked = parser.parse_args(arguments)
    every, outcomes = listed(asked.list), HERE / f"{asked.list}.csv"
    rows = read(outcomes)
    if unknown := set(asked.names) - {fault.name for fault in every}:
        parser.error(f"no such fault: {', '.join(sorted(unknown))}")
    chosen = [
        fault
        for fault in every
        if (not asked.names or fault.name in asked.names)
        and not (asked.missed and rows.get(fault.name, {}).get("now") in ("caught", "equivalent"))
    ]
    if astray := [said for fault in chosen if (said := fault.amiss())]:
        print("\n".join(astray), file=sys.stderr)
        return 2
    if asked.check:
        print(f"{len(chosen)} faults can be planted")
        return 0
    missed = 0
    with copied() as copy:
        for number, fault in enumerate(chosen, 1):
            file = copy / fault.file
            source = file.read_text(encoding="utf-8")
            start = time.monotonic()
            if fault.equivalent and not asked.without:
                caught, by, outcome = True, fault.equivalent, "equivalent"
            else:
                if not asked.without:
                    file.write_text(fault.planted(source), encoding="utf-8")
                try:
                    caught, by = tested(copy, fault)
                finally:
                    file.write_text(source, encoding="utf-8")
                outcome = "caught" if caught else "not caught"
            took = f"{time.monotonic() - start:.0f} s"
            print(f"{number}/{len(chosen)} {fault.name}: {outcome}, {took} {by}", flush=True)
            if asked.without:
                missed += caught  # a failure that no fault explains
                continue
            missed += not caught
            first = rows.get(fault.name, {}).get("at_first", outcome)
            rows[fault.name] = {
                "fault": fault.name, "file": fault.file, "what": fault.what, "at_first": first,
                "now": outcome, "by": by,
            }  # fmt: skip
            write({fault.name: rows[fault.name] for fault in every if fault.name in rows}, outcomes)
    if not asked.without:
        kept = read(outcomes)
        counts = [sum(row[key] == "caught" for row in kept.values()) for key in ("at_first", "now")]
        same = sum(row["now"] == "equivalent" for row in kept.values())
        print(
            f"of {len(kept)} faults {counts[0]} were caught at first, {counts[1]} are caught now, "
            f"{same} are equivalent"
        )
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
