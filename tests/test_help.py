"""What the command says about itself: version, order of the subcommands, options in common."""

from __future__ import annotations

import re

import pytest
import typer
from rich.text import Text
from support.command import run_command

import dolfingrip
from dolfingrip.cli import app as cli

COMMAND = typer.main.get_command(cli.app)


def test_version(capfd: pytest.CaptureFixture[str]) -> None:
    assert run_command("--version") == 0
    assert capfd.readouterr() == (f"dolfingrip {dolfingrip.__version__}\n", "")


def test_subcommands_are_listed_in_the_order_of_use(capfd: pytest.CaptureFixture[str]) -> None:
    assert set(COMMAND.commands) == set(cli.ORDER)  # type: ignore[attr-defined]
    assert run_command("--help") == 0
    listed = re.findall(r"^│ ([a-z][a-z-]*) ", capfd.readouterr().out, re.M)
    assert tuple(listed) == cli.ORDER


@pytest.mark.parametrize("name", cli.ORDER)
def test_every_out_has_a_short_form(name: str) -> None:
    command = COMMAND.commands[name]  # type: ignore[attr-defined]
    for option in command.params:
        if "--out" in option.opts:
            assert "-o" in option.opts


@pytest.mark.parametrize("name", cli.ORDER)
def test_a_table_of_the_configuration_is_not_taken_for_markup(name: str) -> None:
    command = COMMAND.commands[name]  # type: ignore[attr-defined]
    for text in (command.help, *(option.help for option in command.params)):
        shown = Text.from_markup(text or "").plain
        assert shown == (text or "").replace("\\[", "[")
