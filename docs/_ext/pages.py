"""What generated pages share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from dolfingrip.charts import theme

ROOT = Path(__file__).resolve().parents[2]


class Page(NamedTuple):
    """A page to be written.

    Attributes:
        name: of its file, without the ending.
        title: its heading.
        summary: one line for the list of pages.
        text: the whole page in Markdown.
    """

    name: str
    title: str
    summary: str
    text: str


def file_of(path: Path, title: str = "The whole file") -> str:
    """A file of the checkout, folded."""
    shown = path.relative_to(ROOT)
    return (
        f":::{{dropdown}} {title}: `{shown}`\n"
        f"```{{literalinclude}} ../../../{shown}\n:language: python\n```\n:::\n"
    )


def picture(path: Path, draw: Callable[[Axes], None]) -> None:
    """Draw one panel to a file."""
    with theme.figure_theme():
        figure, axes = plt.subplots(figsize=(4.6, 2.9), layout="constrained")
        draw(axes)
        figure.savefig(path, dpi=130)
        plt.close(figure)
