"""Every code block of README and documentation, copied into an empty clone and run whole.

    scripts/run env PYTHONPATH=tests python -m tools.documentation
    scripts/run env PYTHONPATH=tests python -m tools.documentation README report  # these anew

writes ``tests/tools/documentation.csv``: a row for each block. Pages are run one by one in a clone
of the last commit, emptied before each, and the blocks of a page one after another. A comment
before a block says what is special about it (``tests/support/pages.py``). Blocks that are marked
as dear take the sizes of their marks, those that need what a machine may lack are listed with the
reason. Pages whose blocks are those of the table are not run again, so a second call goes on.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from support import pages
from support.pages import ROOT, Block

from dolfingrip.files import table

TABLE: Final = Path(__file__).with_suffix(".csv")
LIMIT_S: Final = 3600
"""Wall time that a block may take."""

SERVED: Final = b"http://"
"""What a command prints once its page can be opened."""


def documents() -> Iterator[Path]:
    """README and all pages of the documentation."""
    yield ROOT / "README.md"
    yield from sorted((ROOT / "docs").glob("*.md"))


class Clone:
    """A clone of the last commit.

    Args:
        folder: in which it is made, where there is none.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if not folder.exists():
            _git(ROOT, "clone", "--quiet", "--no-checkout", str(ROOT), str(folder))

    def empty(self) -> str:
        """Remove all that blocks have written; compiled bytecode stays.

        Returns:
            The commit.
        """
        commit = _git(ROOT, "rev-parse", "HEAD").strip()
        _git(self.folder, "fetch", "--quiet", "origin", commit)
        _git(self.folder, "checkout", "--quiet", "--force", "--detach", commit)
        _git(self.folder, "clean", "-ffdxq", "--exclude=__pycache__")
        return commit

    def run(self, script: str, *, served: bool) -> tuple[int, float, float]:
        """Run a block as bash reads it.

        Args:
            script: its commands.
            served: whether the last one is to be interrupted once it serves its page.

        Returns:
            Exit code, seconds of processor, wall seconds.
        """
        began = time.monotonic()
        process = subprocess.Popen(
            ["bash", "-eo", "pipefail", "-c", script],
            cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        limit = threading.Timer(LIMIT_S, os.killpg, [process.pid, signal.SIGTERM])
        limit.start()
        assert process.stdout is not None
        for line in process.stdout:
            sys.stdout.buffer.write(b"    " + line)
            sys.stdout.flush()
            if served and SERVED in line:
                os.killpg(process.pid, signal.SIGINT)
        _, status, usage = os.wait4(process.pid, 0)
        limit.cancel()
        code = os.waitstatus_to_exitcode(status)
        return code, usage.ru_utime + usage.ru_stime, time.monotonic() - began


def of_block(block: Block, clone: Clone) -> dict[str, object]:
    """Run a block and say how it ended.

    Args:
        block: of a page.
        clone: in which the blocks before it were run.

    Returns:
        A row of the table.
    """
    marks = block.marks
    row: dict[str, object] = {
        "page": block.page.relative_to(ROOT).as_posix(), "line": block.line,
        "language": block.language, "begins": block.typed[0].strip(),
    }  # fmt: skip
    if "not run" in marks:
        return row | {"run": "no", "exit_code": "", "ended": "", "processor_s": "", "limit_s": "",
                      "note": marks["not run"]}  # fmt: skip
    dear = "dear" in marks
    commands = block.reduced("dear") if dear else block.commands
    print(f"{row['page']}:{row['line']}", *commands, sep="\n  $ ", flush=True)
    code, processor_s, _ = clone.run("\n".join(commands), served="served" in marks)
    ends = {0, 128 + signal.SIGINT} if "served" in marks else {0}
    good = (code in ends) is not ("refused" in marks)
    return row | {
        "run": "reduced" if dear else "whole", "exit_code": code,
        "ended": "as told" if good else "FAILED", "processor_s": f"{processor_s:.0f}",
        "limit_s": LIMIT_S, "note": marks["dear"] if dear else "",
    }  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what has changed and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", nargs="*", help="stems of pages; default: all")
    parser.add_argument("--out", type=Path, default=Path("out/documentation"))
    asked = parser.parse_args(arguments)
    asked.out.mkdir(parents=True, exist_ok=True)
    clone = Clone(asked.out.resolve() / "clone")
    known: list[dict[str, str]] = []
    if TABLE.exists():
        with TABLE.open(encoding="utf-8", newline="") as file:
            known = list(csv.DictReader(file))
    told = {page: _told(page, known) for page in documents()}
    for page in told:
        if page.stem in asked.page or not (asked.page or told[page]):
            commit, digest = clone.empty()[:8], _digest(page)
            told[page] = [of_block(block, clone) | {"commit": commit, "blocks": digest}
                          for block in pages.blocks(page)]  # fmt: skip
            table.write(TABLE, [row for rows in told.values() for row in rows])
    rows = [row for rows in told.values() for row in rows]
    table.write(TABLE, rows)
    failed = [row for row in rows if row["ended"] == "FAILED"]
    print(f"{len(rows)} blocks, {len(failed)} failed:", *failed, sep="\n")


def _digest(page: Path) -> str:
    """Digest of the blocks of a page: the same as long as they say the same."""
    said = [[block.comment, block.text] for block in pages.blocks(page)]
    return hashlib.sha256(json.dumps(said).encode()).hexdigest()[:8]


def _told(page: Path, known: Sequence[Mapping[str, object]]) -> list[dict[str, object]]:
    """Rows of the table that hold for a page as it is, at the lines where its blocks are today."""
    kept = [row for row in known if row["page"] == page.relative_to(ROOT).as_posix()]
    if any(row["blocks"] != _digest(page) for row in kept):
        return []
    return [
        row | {"line": block.line} for row, block in zip(kept, pages.blocks(page), strict=False)
    ]


def _git(folder: Path, *words: str) -> str:
    return subprocess.run(
        ["git", "-C", str(folder), *words], check=True, stdout=subprocess.PIPE, text=True
    ).stdout


if __name__ == "__main__":
    main()
