"""What the command says about itself: version, order of the subcommands, options in common."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import pytest
import typer
from rich.text import Text
from support.command import run_command

import dolfingrip
from dolfingrip.cli import app as cli
from dolfingrip.cli import listing

BARE = {key: value for key, value in os.environ.items() if key not in cli.LAUNCHERS}
COMMAND = typer.main.get_command(cli.app)


def test_version(capfd: pytest.CaptureFixture[str]) -> None:
    assert run_command("--version") == 0
    assert capfd.readouterr() == (f"dolfingrip {dolfingrip.__version__}\n", "")


def test_subcommands_are_listed_in_the_order_of_use(capfd: pytest.CaptureFixture[str]) -> None:
    assert run_command("--help") == 0
    listed = re.findall(r"^│ ([a-z][a-z-]*) ", capfd.readouterr().out, re.M)
    assert listed == listing.names()


@pytest.mark.parametrize("name", listing.names())
def test_every_out_has_a_short_form(name: str) -> None:
    command = COMMAND.commands[name]  # type: ignore[attr-defined]
    for option in command.params:
        if "--out" in option.opts:
            assert "-o" in option.opts


@pytest.mark.parametrize("name", listing.names())
def test_a_table_of_the_configuration_is_not_taken_for_markup(name: str) -> None:
    command = COMMAND.commands[name]  # type: ignore[attr-defined]
    for text in (command.help, *(option.help for option in command.params)):
        shown = Text.from_markup(text or "").plain
        assert shown == (text or "").replace("\\[", "[")


@pytest.mark.parametrize("name", listing.names())
def test_the_list_of_commands_says_of_each_what_its_own_help_says(name: str) -> None:
    assert listing.summary(name) == COMMAND.commands[name].help  # type: ignore[attr-defined]


HEAVY = {
    "mpi4py", "numpy", "ufl", "basix", "dolfinx", "petsc4py", "torch", "vtk", "vtkmodules",
    "pyvista", "scipy", "matplotlib", "pandas", "gmsh", "pydantic",
}  # fmt: skip
LOADED = """
import sys
import dolfingrip
sys.argv[1:] = {arguments!r}
if sys.argv[1:]:
    from dolfingrip.cli.app import main
    try:
        main()
    except SystemExit as end:
        assert not end.code
print(*{{name.partition(".")[0] for name in sys.modules}})
"""


@pytest.mark.parametrize("arguments", [[], ["--help"], ["--version"]])
def test_help_imports_nothing_heavy(arguments: list[str]) -> None:
    code = LOADED.format(arguments=arguments)
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=BARE
    )
    loaded = set(ended.stdout.splitlines()[-1].split())
    assert "dolfingrip" in loaded
    assert not loaded & HEAVY
