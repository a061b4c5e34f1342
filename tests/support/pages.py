"""The code blocks of documentation, as a reader copies them into an empty clone.

A comment before a block says what is special about it: parts that are separated by semicolons.

| part | meaning |
|---|---|
| ``in tests: SIZES`` | the tests run it, with these options added to its last command |
| ``dear: SIZES`` | ``tests/tools/documentation.py`` adds these, as the whole takes too long |
| ``not in tests: REASON`` | only ``tests/tools/documentation.py`` runs it |
| ``not run: REASON`` | nothing here runs it |
| ``file: NAME`` | its text is written to this file |
| ``read by: COMMAND`` | what reads this file |
| ``refused`` | its last command ends with an error |
| ``not executed`` | the documentation's build leaves it out |
| ``served`` | its last command serves a page until it is interrupted |

SIZES may be one for each command, with ``|`` between them; ``-`` leaves a command out. ``small``
stands for :data:`SMALL`. Pages that the documentation's build executes need no ``in tests``.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ("dolfingrip", "forms", "meshes")
COPIED = ("examples", "docs", "README.md", "pyproject.toml")
"""What else of a clone the blocks read."""

DOLFINGRIP = "scripts/run dolfingrip "
PYTHON: Final = "scripts/run python - <<'END'\n"
SMALL: Final = "--set mesh.edge_size_mm=7 --set finger.bellows=2 --set finger.length_mm=38"
_APART: Final = r"; (?=in tests|dear|not in tests|not run|not executed|file|read by|refused|served)"
_BLOCK = re.compile(
    r"^(?:<!-- (?P<comment>[^\n]*?) ?-->\n)?"
    r"```(?P<language>sh|toml|python|yaml|\{code-cell\})\n(?P<text>.*?)^```$",
    re.M | re.S,
)


@dataclass(frozen=True)
class Block:
    """A block of code on a page.

    Attributes:
        page: that it stands on.
        line: at which it begins.
        heading: above it.
        comment: in the line before it.
        language: of it.
        text: of the block.
    """

    page: Path
    line: int
    heading: str
    comment: str
    language: str
    text: str

    @property
    def marks(self) -> dict[str, str]:
        """Parts of the comment."""
        parts = (part.partition(":") for part in re.split(_APART, self.comment))
        return {name: said.strip() for name, _, said in parts if name}

    @property
    def typed(self) -> list[str]:
        """Its lines."""
        return self.text.splitlines()

    @property
    def commands(self) -> list[str]:
        """Its commands: a here-document or a continued line is one."""
        if self.language == "python":
            return [f"{PYTHON}{self.text}END"]
        if self.language != "sh":
            if "file" not in self.marks:
                return []
            written = f"cat > {self.marks['file']} <<'END'\n{self.text}END"
            return [written, *filter(None, [self.marks.get("read by")])]
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

    def reduced(self, mark: str = "in tests") -> list[str]:
        """Its commands with the sizes that its comment names.

        Args:
            mark: the part of the comment.
        """
        commands = self.commands
        sizes = [size.strip().replace("small", SMALL) for size in self.marks[mark].split("|")]
        sizes = [""] * (len(commands) - len(sizes)) + sizes
        return [
            f"{command if '<<' in command else re.sub(r' +# .*', '', command)} {size}".strip()
            for command, size in zip(commands, sizes, strict=True)
            if size != "-"
        ]


def blocks(page: Path) -> Iterator[Block]:
    """The code blocks of a page that its reader sees.

    Args:
        page: of Markdown.

    Yields:
        They, in their order.
    """
    text = page.read_text(encoding="utf-8")
    for match in _BLOCK.finditer(text):
        if ":tags: [remove-" in match["text"]:
            continue
        headings = re.findall(r"^#+ (.*)$", text[: match.start()], re.M)
        language = match["language"].replace("{code-cell}", "python")
        line = text.count("\n", 0, match.start("language")) + 1
        yield Block(
            page, line, (headings or [""])[-1], match["comment"] or "", language, match["text"]
        )


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
    """Run commands one after another.

    Args:
        commands: of a block.
        folder: the clone.
    """
    with chdir(folder):
        perform(commands)


def perform(commands: Sequence[str]) -> None:
    """Run commands in the present folder, those of dolfingrip without a plugin in this process.

    Args:
        commands: of a block.
    """
    from dolfingrip.cli.commands import app

    for command in commands:
        failed = 0
        print("$", command, flush=True)
        if command.startswith(PYTHON):
            code, _, sizes = command.removeprefix(PYTHON).rpartition("END")
            _python(code, sizes)
        elif command.startswith("scripts/run python -c "):
            _python(shlex.split(command)[3])
        elif command.startswith(DOLFINGRIP) and not re.search(r"[|>&;]|--plugin", command):
            failed = app(shlex.split(command)[2:], prog_name="dolfingrip", standalone_mode=False)
        else:
            failed = subprocess.run(
                ["bash", "-eo", "pipefail", "-c", command], check=False
            ).returncode
        assert not failed, command


def _python(code: str, sizes: str = "") -> None:
    """Run Python's code here, its configurations with further settings."""
    from dolfingrip import config
    from dolfingrip.sections.tables import assignments

    smaller = assignments(shlex.split(sizes)[1::2])

    def load(file: Any = None, overrides: Any = None) -> config.Config:
        return whole(file, {**(overrides or {}), **smaller})

    whole = config.load
    with mock.patch.object(config, "load", load):
        exec(compile(code, "a block of code", "exec"), {"__name__": "__main__"})
