"""What messages, docstrings, pages and results advise to type: the parsers take it.

Nothing is executed. An option alone has to be one of a command. A command line has to be one that
its command's own parser takes; what a message fills in stands as 1.
"""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer
from support import pages
from typer._click.exceptions import NoSuchOption, UsageError

from dolfingrip.cli.command import Subcommand, settings_of
from dolfingrip.cli.commands import COMMANDS, app
from dolfingrip.cli.import_command import named
from dolfingrip.config import ConfigError
from dolfingrip.importing.told import ImportOption, NamedColumn, Told

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
SOURCES = [
    path
    for path in sorted((ROOT / "dolfingrip").rglob("*"))
    if path.suffix in (".py", ".toml") or path.parent.name == "templates"
]
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9]*(?:-[a-z0-9]+)*(?![\w-])")
NAMES = "|".join(each.name for each in COMMANDS)
LINE = re.compile(rf"dolfingrip ((?:{NAMES})(?!\S)(?:(?!\. )[^`\n;|&>#])*)")
OF_OTHERS = {
    "command.py": {"--no-1"},  # of any option
    "doctor_command.py": {"--list"},  # of rdma, ldconfig and the like
    "pdf.py": {
        "--headless", "--disable-gpu-sandbox", "--enable-unsafe-swiftshader", "--no-first-run",
        "--user-data-dir", "--no-pdf-header-footer", "--virtual-time-budget", "--print-to-pdf",
        "--no-sandbox",
    },  # of a browser
    "robot.py": {"--mjcf"},  # of MuJoCo's viewer
    "simulate.py": {"--pdeathsig"},  # of setpriv
    "slurm.py": {"--no-dashboard"},  # of Dask
    "cluster.md": {"--local-directory"},  # of Dask
    "install.md": {"--system-site-packages"},  # of venv
}  # fmt: skip
"""Options of other programs, by the file that names them."""


@cache
def entries() -> dict[str, Subcommand]:
    """Each command by its name; ``doe export`` is one, too."""
    found = {each.name: each for each in COMMANDS}
    return found | {f"{a.name} {b.name}": b for a in COMMANDS for b in a.below}


@cache
def options() -> frozenset[str]:
    """All options of all commands."""
    every = list(typer.main.get_command(app).params)
    for each in entries().values():
        every += each.built().params
    return frozenset({flag for each in every for flag in (*each.opts, *each.secondary_opts)}) | {
        "--help"
    }


def parse(text: str) -> dict[str, Any]:
    """Parse a line behind ``dolfingrip``, and check its values, without executing it.

    Returns:
        The settings by name.

    Raises:
        UsageError: the parser refuses it.
        ConfigError: a value is refused.
    """
    name, *rest = shlex.split(text, comments=True)
    if rest and f"{name} {rest[0]}" in entries():
        name, *rest = f"{name} {rest[0]}", *rest[1:]
    entry = entries()[name]
    context = entry.built().make_context(name, rest)
    return {
        each.name: each.value(context.params[each.name]) for each in settings_of(entry.settings)
    }


def texts(file: Path) -> Iterator[tuple[int, str]]:
    """Texts of a source with their lines; what is filled in stands as 1."""
    if file.suffix != ".py":
        yield from enumerate(file.read_text(encoding="utf-8").splitlines(), start=1)
        return
    inside: set[int] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.JoinedStr):
            inside |= {id(part) for part in node.values}
            yield (
                node.lineno,
                "".join(
                    str(part.value) if isinstance(part, ast.Constant) else "1"
                    for part in node.values
                ),
            )
        own = getattr(node, "value", None) if isinstance(node, ast.Constant) else None
        if isinstance(own, str) and id(node) not in inside:
            yield node.lineno, own


def test_each_option_that_a_text_names_is_there() -> None:
    missing = []
    for file in [*SOURCES, *PAGES]:
        for line, text in texts(file):
            if file.suffix == ".md":  # other programs' options stand in blocks of code
                text = " ".join(re.findall(r"`(--[^`]*)`", text))
            own = {*OPTION.findall(text)} - OF_OTHERS.get(file.name, set())
            missing += [f"{file.relative_to(ROOT)}:{line}: {flag}" for flag in own - options()]
    assert not missing, "\n".join(missing)


def advised() -> Iterator[tuple[str, str, bool]]:
    """Command lines of sources and pages, each with its place, and whether it is whole."""
    for file in SOURCES:
        for line, text in texts(file):
            for match in LINE.finditer(" ".join(text.split()) if file.suffix == ".py" else text):
                yield f"{file.relative_to(ROOT)}:{line}", match[1], False
    for page in PAGES:
        for block in pages.blocks(page):
            for command in block.commands:
                for match in LINE.finditer(command.partition("<<")[0]):
                    yield f"{page.relative_to(ROOT)}:{block.line}", match[1], True
        for line, text in texts(page):
            for code in re.findall(r"`([^`]*)`", text):
                for match in LINE.finditer(code):
                    yield f"{page.relative_to(ROOT)}:{line}", match[1], False


def test_each_command_line_is_parsed() -> None:
    wrong = []
    for place, text, whole in advised():
        if "--plugin" in text:  # its names are there with the plugin alone: tests/test_examples.py
            continue
        try:
            parse(text)
        except (UsageError, ConfigError, ValueError) as error:
            # in a sentence values and arguments may be left out
            if whole or isinstance(error, NoSuchOption | ConfigError):
                wrong.append(f"{place}: {text}: {error}")
    assert not wrong, "\n".join(wrong)


ANSWERS = {
    "column": NamedColumn("p", "pressure_bar"), "experiment": "coupon", "gauge_length": 25.0,
    "area": 18.0, "mode": "planar", "frame_rate": 30.0, "rate": 2.0,
    "encoding": "cp1252", "decimal": ",", "sheet": "table 2", "shift": 2.0,
}  # fmt: skip
"""A value of each option that an import asks for."""


@pytest.mark.parametrize(
    "added",
    [
        ImportOption("zero_at_rest"),
        ImportOption("zero_at_rest", False),
        ImportOption("withdraws"),
        ImportOption("withdraws", False),
        ImportOption("side_by_side"),
        *(ImportOption(name, value) for name, value in ANSWERS.items()),
    ],
    ids=str,
)
def test_what_an_import_asks_for_is_taken_as_the_terminal_takes_it(added: ImportOption) -> None:
    settings = parse(f"import table.csv {added}")
    settings["column"] = named(settings["column"])
    taken = Told(**{field.name: settings[field.name] for field in fields(Told)})
    assert taken == Told().with_option(added)


def test_every_setting_of_an_import_is_tried() -> None:
    flags, argument = ("zero_at_rest", "withdraws", "side_by_side"), "log"
    assert {*ANSWERS, *flags, argument} == {each.name for each in fields(Told)}
