"""The list of commands and the page of their options, from the command line itself."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import MISSING
from pathlib import Path
from typing import Any

from docstrings import inline, table
from pages import ROOT

from dolfingrip.cli.command import Setting, Subcommand, settings_of
from dolfingrip.cli.commands import COMMANDS

CALL = re.compile(r"scripts/run dolfingrip ([a-z-]+)")
MOST_PAGES = 3
"""Pages that the list names of a command."""

KINDS = {Path: "FILE", str: "TEXT", int: "whole number", float: "number"}

HEAD = """# Options of all commands

Each command with its arguments and options. `COMMAND --help` prints them, too.
"""


def listed() -> str:
    """A table of all commands: its options, what it does, and the pages that use it."""
    used = pages_by_command()
    rows = [
        [f"[`{entry.name}`](generated/options.md#{entry.name})", inline(paragraph(entry)),
         ", ".join(f"[]({page}.md)" for page in used.get(entry.name, ()))]
        for entry in COMMANDS
    ]  # fmt: skip
    return table(["command", "what it does", "pages"], rows)


def paragraph(entry: Subcommand) -> str:
    """The first paragraph of a command's help."""
    return (entry.built().help or "").split("\n\n")[0]


def pages_by_command() -> dict[str, list[str]]:
    """Pages that call each command, those that call it most first."""
    calls: dict[str, Counter[str]] = {}
    for page in sorted((ROOT / "docs").glob("*.md")):
        for name in CALL.findall(page.read_text(encoding="utf-8")):
            calls.setdefault(name, Counter())[page.stem] += 1
    return {
        name: [page for page, _ in pages.most_common(MOST_PAGES)] for name, pages in calls.items()
    }


def options() -> str:
    """The page of all options."""
    parts = [HEAD]
    for entry in COMMANDS:
        for below, name in every(entry):
            rows = [line(setting) for setting in settings_of(below.settings)]
            parts += [f"## {name}", inline(paragraph(below))]
            if rows:
                parts.append(table(["option", "value", "default", "what it does"], rows))
    return "\n\n".join(parts) + "\n"


def every(entry: Subcommand) -> Iterator[tuple[Subcommand, str]]:
    """A command and those below it, with their whole names."""
    yield entry, entry.name
    for below in entry.below:
        yield below, f"{entry.name} {below.name}"


def line(setting: Setting) -> list[str]:
    """The line of one option or argument."""
    flags = ", ".join(f"`{flag}`" for flag in setting.flags or (setting.flag,))
    about = setting.help if setting.help.endswith(".") else f"{setting.help}."
    if setting.allowed and "true" not in setting.allowed:
        about += f" Allowed: {setting.allowed}."
    return [flags, inline(value(setting)), inline(default(setting)), inline(plain(about))]


def value(setting: Setting) -> str:
    """Return the value that help writes behind an option."""
    if setting.choices:
        return ", ".join(f"`{choice}`" for choice in setting.choices)
    if setting.bare is bool:
        return ""
    return setting.metavar or setting.unit or KINDS.get(setting.bare, "")


def default(setting: Setting) -> str:
    """The default of an option, where there is one to show."""
    given: Any = setting.default
    if given is MISSING:
        return "required"
    if isinstance(given, bool):
        return "on" if given else ""
    if given is None or given == () or given == {}:
        return ""
    return f"`{given.as_posix() if isinstance(given, Path) else given}`"


def plain(text: str) -> str:
    """A help text without the marks of the terminal."""
    return text.replace("\\[", "[")
