"""Tutorials: their shell blocks run when the documentation is built, and read as they are typed.

A page with ``file_format: mystnb`` has ordinary blocks of ``sh``. For the build they become cells
of Jupyter's ``%%bash``; the page then shows them without this line. A comment before a block says
what is special about it: ``<!-- not executed -->``, or ``<!-- refused -->`` where the command ends
with an error. Comments that begin with ``in tests:`` are read by ``tests/support/pages.py``.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes

EXECUTED = "mystnb"
BLOCK = re.compile(r"^(?P<comment><!-- [^\n]* -->\n)?```sh\n", re.M)
MAGIC = re.compile(r"\A%%bash[^\n]*\n")


def executed(app: Any, docname: str, source: list[str]) -> None:
    """Make cells of the shell blocks of a tutorial."""
    head, _, _ = source[0].partition("\n---\n")
    if EXECUTED not in head:
        return

    def cell(match: re.Match[str]) -> str:
        comment = match["comment"] or ""
        if "not executed" in comment:
            return match[0]
        line = "%%bash --no-raise-error" if "refused" in comment else "%%bash"
        return f"```{{code-cell}}\n{line}\n"

    source[0] = BLOCK.sub(cell, source[0])


def as_typed(app: Any, doctree: nodes.document) -> None:
    """Show shell cells without Jupyter's line."""
    for block in list(doctree.findall(nodes.literal_block)):
        text = block.astext()
        if MAGIC.match(text):
            own = MAGIC.sub("", text)
            shown = nodes.literal_block(own, own, **{**block.attributes, "language": "sh"})
            block.replace_self(shown)


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("source-read", executed)
    app.connect("doctree-read", as_typed)
    return {"parallel_read_safe": True}
