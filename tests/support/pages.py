"""The shell blocks of documentation, as a reader copies them into an empty clone."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ("dolfingrip", "forms", "meshes")
COPIED = ("examples", "docs", "README.md", "pyproject.toml")
"""What else of a clone the blocks read."""

DOLFINGRIP = "scripts/run dolfingrip "
_BLOCK = re.compile(r"^(?:<!-- (?P<comment>[^\n]*?) ?-->\n)?```sh\n(?P<text>.*?)^```$", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """A block of ``sh`` on a page.

    Attributes:
        page: that it stands on.
        heading: above it.
        comment: in the line before it, as :mod:`docs/_ext/tutorials.py` says.
        text: of the block.
    """

    page: Path
    heading: str
    comment: str
    text: str

    @property
    def typed(self) -> list[str]:
        """Its lines."""
        return self.text.splitlines()

    @property
    def commands(self) -> list[str]:
        """Its commands: a here-document or a continued line is one."""
        found: list[str] = []
        lines = iter(self.typed)
        for line in lines:
            command = line
            while command.endswith("\\"):
                command = f"{command[:-1]}{next(lines)}"
            if (end := re.search(r"<<'?(\w+)'?$", command)) is not None:
                body = []
                for further in lines:
                    body.append(further)
                    if further == end[1]:
                        break
                command = "\n".join([command, *body])
            if command.strip() and not command.startswith("#"):
                found.append(command)
        return found

    @property
    def sizes(self) -> str | None:
        """What the tests add to its last command; None where they do not run it."""
        _, marked, sizes = self.comment.partition("in tests:")
        return sizes.strip() if marked else None

    @property
    def refused(self) -> bool:
        """True where its last command ends with an error in one line."""
        return self.comment.startswith("refused")

    def reduced(self) -> list[str]:
        """Its commands as the tests run them: the last one takes the sizes."""
        *first, last = self.commands
        return [*first, f"{last} {self.sizes or ''}".strip()]


def blocks(page: Path) -> Iterator[Block]:
    """The shell blocks of a page.

    Args:
        page: of Markdown.

    Yields:
        They, in their order.
    """
    text = page.read_text(encoding="utf-8")
    for match in _BLOCK.finditer(text):
        headings = re.findall(r"^#+ (.*)$", text[: match.start()], re.M)
        yield Block(page, (headings or [""])[-1], match["comment"] or "", match["text"])


def clone(folder: Path) -> Path:
    """What a clone has of the package, and nothing else.

    Args:
        folder: that it is made in.
    """
    for name in (*PACKAGE, *COPIED):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, folder / name)
    run_script = folder / "scripts" / "run"
    run_script.parent.mkdir()
    run_script.write_text('#!/bin/sh\nexec "$@"\n', encoding="utf-8")  # the tests are inside
    run_script.chmod(0o755)
    for name in PACKAGE[1:]:  # parts of the package that lie next to it
        (folder / "dolfingrip" / name).symlink_to(folder / name)
    return folder


def run(commands: Sequence[str], folder: Path) -> None:
    """Run commands one after another, those of dolfingrip in one process.

    It is this process, unless they change the package's own files.

    Args:
        commands: of a block.
        folder: the clone.
    """
    if not any(f"{name}/" in each for each in commands for name in PACKAGE):
        with chdir(folder):
            perform(commands)
        return
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(ROOT / "tests")])}
    code = f"from support.pages import perform; perform({list(commands)!r})"
    ended = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, f"{ended.stdout}\n{ended.stderr}"


def perform(commands: Sequence[str]) -> None:
    """Run commands in the present folder, those of dolfingrip in this process.

    Args:
        commands: of a block.
    """
    from dolfingrip.cli.app import app

    for command in commands:
        print("$", command, flush=True)
        if command.startswith(DOLFINGRIP) and not set("|>&;") & set(command):
            code = app(shlex.split(command)[2:], prog_name="dolfingrip", standalone_mode=False)
        else:
            code = subprocess.run(
                ["bash", "-eo", "pipefail", "-c", command], check=False
            ).returncode
        assert not code, command
