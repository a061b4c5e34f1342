"""What the command says about itself: version, order of the subcommands, options in common."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from typing import get_type_hints

import pytest
import typer
from rich.text import Text
from support.command import run_command

import dolfingrip
from dolfingrip import config
from dolfingrip.cli import commands as cli
from dolfingrip.cli import settings
from dolfingrip.cli.command import settings_of

COMMAND = typer.main.get_command(cli.app)
ORDER = tuple(each.name for each in cli.COMMANDS)


def test_version(capfd: pytest.CaptureFixture[str]) -> None:
    from dolfinx import __version__

    assert run_command("--version") == 0
    said, errors = capfd.readouterr()
    first, second = said.splitlines()
    assert (first, errors) == (f"dolfingrip {dolfingrip.__version__}", "")
    assert second.startswith(f"DOLFINx {__version__}")
    assert second.endswith("; dolfingrip doctor says more")


def test_subcommands_are_listed_in_the_order_of_use(capfd: pytest.CaptureFixture[str]) -> None:
    assert tuple(COMMAND.commands) == ORDER  # type: ignore[attr-defined]
    assert run_command("--help") == 0
    listed = re.findall(r"^│ ([a-z][a-z-]*) ", capfd.readouterr().out, re.M)
    assert tuple(listed) == ORDER


@pytest.mark.parametrize("name", ORDER)
def test_every_out_has_a_short_form(name: str) -> None:
    command = COMMAND.commands[name].entry.built()  # type: ignore[attr-defined]
    for option in command.params:
        if "--out" in option.opts:
            assert "-o" in option.opts


@pytest.mark.parametrize("name", ORDER)
def test_a_table_of_the_configuration_is_not_taken_for_markup(name: str) -> None:
    command = COMMAND.commands[name].entry.built()  # type: ignore[attr-defined]
    for text in (command.help, *(option.help for option in command.params)):
        shown = Text.from_markup(text or "").plain
        assert shown == (text or "").replace("\\[", "[")


def test_commands_stand_in_six_groups_with_an_example_each(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    assert run_command("--help") == 0
    said = capfd.readouterr().out
    assert "printed or cast in silicone" in said
    headings = re.findall(r"^╭─ ([^─]+: dolfingrip [^─]+) ─", said, re.M)
    assert headings == list(settings.GROUPS)
    assert len(headings) == 6
    for heading in headings:
        _parsed(heading.partition(": ")[2])


def _parsed(line: str) -> None:
    """Read a line as the command line reads it, up to the settings of the command."""
    program, name, *words = shlex.split(line)
    assert program == "dolfingrip"
    (entry,) = (each for each in cli.COMMANDS if each.name == name)
    if entry.below and words[0] == entry.below[0].name:
        entry, words = entry.below[0], words[1:]
    context = entry.built().make_context(name, words)
    described = settings_of(entry.settings)
    asked = entry.settings(
        **{each.name: each.value(context.params[each.name]) for each in described}
    )
    changes = {**getattr(asked, "overrides", {}), **getattr(asked, "hide", {})}
    config.load(None, changes)


LINES = {
    " ".join([each.name, *below]): entry
    for each in cli.COMMANDS
    for below, entry in (((), each), *(((inner.name,), inner) for inner in each.below))
}
"""Commands as they are typed."""


@pytest.mark.parametrize("line", LINES)
def test_each_command_has_one_example_that_its_command_line_takes(line: str) -> None:
    (example,) = re.findall(r"^Example: (.*)$", LINES[line].help, re.M)
    assert example.startswith(f"dolfingrip {line}")
    assert len(f"Example: {example}") <= 76  # a terminal of 80 columns does not break it
    _parsed(example)


TERSE = re.compile(r"^(Of|With|Or|Default|e\.g\.|None)\b")
"""Beginnings of a help that goes on from the option's name."""


@pytest.mark.parametrize("line", LINES)
def test_an_option_s_help_is_understood_alone(line: str) -> None:
    described = settings_of(LINES[line].settings)
    too_short = [each.flag for each in described if len(each.help.split()) < 2]
    assert [each.flag for each in described if TERSE.match(each.help)] + too_short == []


FRAGMENTS = {
    "bend": ("--pressure", "kPa", "at most 10000 kPa", "displacement|stretch", "kPa,kPa,…"),
    "cycle": ("kPa/s", "Length of the wait at the highest pressure"),
    "grasp": ("potato-large", "cube", "scoop, pinch, claw", "coarse, default"),
    "pickup": ("kPa", "above 0 and up to 1000 kPa", "scoop, pinch, claw", "potato-small"),
    "friction": ("at least 0.0001 and up to 0.5",),
    "adopt": ("X,Y,Z", "mm", "above 0 and up to 1000 mm", "mm|cm|in|m"),
    "doe": ("grid|sobol|lhs", "KEY=LOW:HIGH[:COUNT]", "at least 1"),
    "optimise": ("at least 0 and up to 1", "default: 1000", "at least 4"),
    "study": ("50, 100, 500, 1000", "0.01, 0.1, 0.5, 0.8"),
    "predict": ("kPa,kPa,…",),
    "robot": ("--config", "finger.urdf", "at least 1"),
    "morph": ("ξ1 ξ2", "required"),
    "explore": ("KEY=LOW:HIGH", "up to 65535"),
    "synthetic": ("COLUMN=STD", "bending, blocked_force"),
}
"""Units, choices, limits and defaults that the help of a command shows."""


def _help(name: str, capfd: pytest.CaptureFixture[str]) -> str:
    """The help of a command, without the lines around it and its breaks."""
    assert run_command(*name.split(), "--help") == 0
    return " ".join(capfd.readouterr().out.replace("│", " ").split())


@pytest.mark.parametrize("name", FRAGMENTS)
def test_help_shows_units_and_choices(
    name: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    shown = _help(name, capfd)
    assert [text for text in FRAGMENTS[name] if text not in shown] == []


@pytest.mark.parametrize("name", [*ORDER, "doe export"])
def test_every_option_says_what_it_takes(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    """No type of Python stands in for a unit, a choice or a name."""
    assert re.findall(r"<[^>]*>", _help(name, capfd)) == []


@pytest.mark.parametrize("name", ORDER)
def test_a_command_is_its_settings_and_a_function_of_them(name: str) -> None:
    (found,) = (each for each in cli.COMMANDS if each.name == name)
    for each in (found, *found.below):
        function = each.function()
        (parameter,) = get_type_hints(function).keys() - {"return"}
        assert issubclass(each.settings, get_type_hints(function)[parameter])


HEAVY = {
    "mpi4py", "numpy", "ufl", "basix", "ffcx", "dolfinx", "petsc4py", "torch", "vtkmodules",
    "pyvista", "matplotlib", "gmsh", "pandas", "scipy", "distributed",
}  # fmt: skip


@pytest.mark.parametrize(
    ("code", "needed"),
    [
        ("import dolfingrip", set()),
        ("from dolfingrip.cli.app import main; sys.argv[1:] = ['--help']; main()", set()),
        (  # what meshes, draws, tabulates and distributes is imported when it is used
            "from dolfingrip.cli import experiment_commands",
            {"mpi4py", "numpy", "ufl", "basix", "ffcx", "dolfinx", "petsc4py", "scipy"},
        ),
    ],
    ids=["package", "help", "experiments"],
)
def test_what_is_imported(code: str, needed: set[str]) -> None:
    ask = "import atexit, sys; atexit.register(lambda: print('loaded', *sys.modules))\n"
    ended = subprocess.run([sys.executable, "-c", ask + code], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    loaded = ended.stdout.split("loaded ")[1].split()
    assert HEAVY & set(loaded) == needed
