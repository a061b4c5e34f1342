"""Writes pages of energies, terms, effects, examples and modules, and lists of keys and the like.

The pages and their pictures go to ``docs/generated`` before Sphinx looks for sources.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import api
import commands
import effects
import energies
import gallery
import keys
import terms
from docstrings import inline
from pages import Page

from dolfingrip.cli.reference_commands import page as columns
from dolfingrip.experiments.index import EXPERIMENTS

GROUPS = (
    (
        "energies",
        "Energies",
        "One file in `forms/` is one energy: a pure function of UFL expressions. "
        "Residual, tangent and sensitivities follow from it by differentiation.",
        energies.pages,
    ),
    (
        "terms",
        "Terms of the potential",
        "A term is a summand of the total potential that a solver asks for its value, gradient and "
        "second derivatives. Each summand has this interface.",
        terms.pages,
    ),
    (
        "effects",
        "Effects",
        "The simple model leaves these effects out. A configuration switches each on by its table; "
        "[extensions](../../extensions.md) says how.",
        effects.pages,
    ),
    ("api", "Modules", "What is not here may change.", api.pages),
)


def write(folder: Path) -> None:
    """Write all pages below ``folder``."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name, text in (
        ("commands.inc", commands.listed()),
        ("options.md", commands.options()),
        ("keys.md", keys.page()),
        ("columns.md", columns(list(EXPERIMENTS.values()))),
    ):
        (folder / name).write_text(f"{text.rstrip()}\n", encoding="utf-8")
    (folder / "gallery").mkdir()
    gallery.pages(folder / "gallery")
    for name, title, about, make in GROUPS:
        own = folder / name
        own.mkdir(parents=True)
        made: list[Page] = make(own)
        rows = "\n".join(
            f"| [{page.title}]({page.name}.md) | {inline(page.summary)} |" for page in made
        )
        listed = "\n".join(f"{page.title.strip('`')} <{page.name}>" for page in made)
        (own / "index.md").write_text(
            f"# {title}\n\n{about}\n\n| | |\n|---|---|\n{rows}\n\n"
            f"```{{toctree}}\n:hidden:\n{listed}\n```\n",
            encoding="utf-8",
        )
        for page in made:
            (own / f"{page.name}.md").write_text(page.text, encoding="utf-8")


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "generated"))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
