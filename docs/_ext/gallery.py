"""The gallery: a page for each example, and one with all of their pictures.

``docs/gallery.csv`` has the picture and the processor time of each; ``docs/pictures/gallery.py``
measures the times.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from docstrings import inline
from pages import ROOT, Page

TABLE = ROOT / "docs" / "gallery.csv"
MINUTE_S = 100
"""Longer times are told in minutes."""

HEAD = """# Gallery

Each picture is an example that comes with the package. A card tells how many lines it has, and how
long it takes on one core of an AMD EPYC (processor time; `docs/pictures/gallery.py` measures it).
Click on a card for its command and its file.
"""


def examples() -> Iterator[Path]:
    """The files that are run or read as they stand: those with a row first, in its order."""
    folder = ROOT / "examples"
    known = [folder / name for name in rows()]
    yield from known
    others = sorted([*folder.glob("*.py"), *folder.glob("*.toml")])
    yield from (file for file in others if file not in known)


def rows() -> dict[str, Mapping[str, str]]:
    """Rows of the table by the example's file."""
    with TABLE.open(encoding="utf-8", newline="") as text:
        return {row["example"]: row for row in csv.DictReader(text)}


def text_of(example: Path) -> str:
    """Return the docstring or comment at the top of an example."""
    text = example.read_text(encoding="utf-8")
    if example.suffix == ".py":
        return text.split('"""')[1]
    lines = [line.removeprefix("#")[1:] for line in head(text.splitlines())]
    return "\n".join(lines)


def head(lines: list[str]) -> Iterator[str]:
    """The comment at the top of a file."""
    for line in lines:
        if not line.startswith("#"):
            return
        yield line


def command(example: Path) -> str:
    """The command that runs an example."""
    pattern = rf"(?:python|dolfingrip) .*{re.escape(example.name)}.*"
    found = re.search(pattern, text_of(example))
    return f"scripts/run {found[0].partition('#')[0].strip()}" if found else ""


def title(example: Path) -> str:
    """The first sentence of an example, without what follows a colon or a bracket."""
    first = " ".join(text_of(example).split("\n\n")[0].split())
    return re.split(r"[.:](?: |$)| \(", first)[0]


def time(row: Mapping[str, str]) -> str:
    """The processor time of an example in words."""
    if not row.get("processor_s"):
        return ""
    seconds = float(row["processor_s"])
    return f"{seconds:.0f} s" if seconds < MINUTE_S else f"{seconds / 60:.0f} min"


def pages(folder: Path) -> list[Page]:
    """A page for each example, and the gallery itself in ``folder``."""
    table, made, cards = rows(), [], []
    for example in examples():
        row = table.get(str(example.relative_to(ROOT / "examples")), {})
        lines = len(example.read_text(encoding="utf-8").splitlines())
        said = ", ".join(filter(None, [f"{lines} lines", time(row)]))
        name = f"{example.stem}_{example.suffix[1:]}"
        picture = f"../../../{row['picture']}" if row.get("picture") else ""
        cards.append(card(name, title(example), picture, said))
        made.append(Page(name, title(example), said, page(example, picture, said)))
    grid = ":::::{grid} 1 2 3 3\n:gutter: 3\n\n" + "\n".join(cards) + "\n:::::\n"
    names = "\n".join(each.name for each in made)
    toctree = f"```{{toctree}}\n:hidden:\n\n{names}\n```\n"
    (folder / "index.md").write_text(f"{HEAD}\n{grid}\n{toctree}", encoding="utf-8")
    for each in made:
        (folder / f"{each.name}.md").write_text(each.text, encoding="utf-8")
    return made


def card(name: str, title: str, picture: str, said: str) -> str:
    """A card of the gallery."""
    image = f":img-top: {picture}\n" if picture else ""
    link = f":link: {name}\n:link-type: doc\n"
    return f"::::{{grid-item-card}} {inline(title)}\n{link}{image}\n{said}\n::::\n"


def page(example: Path, picture: str, said: str) -> str:
    """The page of one example."""
    language = {".py": "python", ".toml": "toml"}[example.suffix]
    parts = [f"# {inline(title(example))}", f"`{example.relative_to(ROOT)}`, {said}."]
    if run := command(example):
        parts.append(f"```sh\n{run}\n```")
    if picture:
        parts.append(f"![{inline(title(example))}]({picture})")
    shown = example.relative_to(ROOT)
    parts.append(f"```{{literalinclude}} ../../../{shown}\n:language: {language}\n```")
    return "\n\n".join(parts) + "\n"
