"""Tables of text, as Markdown, a console and a notebook show them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from textwrap import wrap


@dataclass(frozen=True, slots=True)
class TextTable:
    """Numbers as text: headings, rows, and a title."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""

    def markdown(self) -> list[str]:
        """Lines of the table in Markdown, without the title."""
        lines = [self.headings, ["---"] * len(self.headings), *self.rows]
        return [f"| {' | '.join(row)} |" for row in lines]

    def text(self, columns: int = 100, rows: int = 30) -> str:
        """Lines for a console: the title, and the table.

        Args:
            columns: most characters of a line; longer ones are wrapped in the last column.
            rows: most rows; those in the middle are left out.
        """
        shown = [self.headings, *self.rows[: rows // 2], *self.rows[rows // 2 :][-rows // 2 :]]
        widths = [max(map(len, cells)) for cells in zip(*shown, strict=True)]
        lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in shown if any(row)]
        if (hidden := len(self.rows) - rows) > 0:
            lines.insert(-rows // 2, f"… {hidden} rows …")
        indent = " " * sum(width + 2 for width in widths[:-1])
        wrapped = [part for line in lines for part in wrap(line, columns, subsequent_indent=indent)]
        return "\n".join([*wrap(self.title, columns), *wrapped])

    def html(self) -> str:
        """HTML for a notebook: the table below its title, which folds it."""
        import pandas as pd

        with pd.option_context("display.max_colwidth", None):
            table = pd.DataFrame(list(self.rows), columns=list(self.headings)).to_html(index=False)
        return f"<details open><summary>{escape(self.title)}</summary>{table}</details>"
