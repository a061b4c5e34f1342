"""Equations of docstrings as TeX, and pages that name what there is."""

from __future__ import annotations

import csv
import importlib.util
import re
import shlex
from itertools import takewhile
from pathlib import Path
from types import ModuleType
from typing import Final

import pytest
import typer
from support import pages
from support.checkout import needs_checkout

from dolfingrip.cli.command import settings_of
from dolfingrip.cli.commands import app
from dolfingrip.config import ConfigError

DOCS = Path(__file__).resolve().parents[1] / "docs"


@pytest.fixture(scope="module")
def equations() -> ModuleType:
    found = importlib.util.spec_from_file_location("equations", DOCS / "_ext" / "equations.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("text", "tex"),
    [
        ("ψ = μ/2 (Ī₁ − 3)²", r"ψ = μ/2 (\bar{I}_{1} - 3)^{2}"),
        ("g = (det C)^(−1/3)", r"g = (\operatorname{det} C)^{-1/3}"),
        ("ρ = √(q_y/q)", r"ρ = \sqrt{q_y/q}"),
        ("λ₁^α_k", r"λ_{1}^{α_k}"),
        ("A_kl ≤ ∂Ī/∂C", r"A_{kl} \le  \partial \bar{I}/\partial C"),
    ],
)
def test_an_equation_as_tex(equations: ModuleType, text: str, tex: str) -> None:
    assert equations.to_tex(text) == tex


@pytest.mark.parametrize(
    ("text", "is_one"),
    [
        ("ψ = −μ/2 [Jₘ ln(1 − x) + Ī₁ − 3],   x = (Ī₁ − 3)/Jₘ", True),
        ("tilt = ``plate.tilt_deg`` + offset; the force is the one normal to the plate.", False),
        ("Chains have a limited length: ψ is unbounded at x = 1, and beyond it no state.", False),
    ],
)
def test_a_sentence_is_no_equation(equations: ModuleType, text: str, is_one: bool) -> None:
    assert equations.is_equation(text) is is_one


@needs_checkout
def test_files_that_pages_name_are_there() -> None:
    """Paths from the checkout's root, such as ``tests/mechanics/test_taylor.py``."""
    root = DOCS.parent
    named = {
        (page.name, path)
        for page in [*DOCS.glob("*.md"), root / "README.md", root / "CONTRIBUTING.md"]
        for path in re.findall(
            r"`((?:tests|examples|forms|meshes|docs|scripts|benchmarks|dolfingrip)/[\w./-]+)`",
            page.read_text(encoding="utf-8"),
        )
        if "NAME" not in path
    }
    assert len(named) > 50
    missing = [(page, path) for page, path in sorted(named)
               if not (root / path).exists() and not (root / f"{path}.py").exists()]  # fmt: skip
    assert missing == []


@needs_checkout
def test_the_gallery_names_examples_and_pictures_that_are_there() -> None:
    root = DOCS.parent
    with (DOCS / "gallery.csv").open(encoding="utf-8", newline="") as text:
        rows = list(csv.DictReader(text))
    assert len(rows) > 20
    assert [row for row in rows if not (root / "examples" / row["example"]).is_file()] == []
    assert [row for row in rows if row["picture"] and not (root / row["picture"]).is_file()] == []
    assert all(float(row["processor_s"] or 1) > 0 for row in rows)


@needs_checkout
def test_the_glossary_is_in_order() -> None:
    page = (DOCS / "glossary.md").read_text(encoding="utf-8")
    terms = re.findall(r"^(\w.*)\n  \S", page, re.M)
    assert len(terms) >= 30
    assert terms == sorted(terms, key=str.casefold)


DOCUMENTS: Final = [*sorted(DOCS.glob("*.md")), DOCS.parent / "README.md"]


def _commands() -> list[tuple[str, str]]:
    """Page and command of all calls of dolfingrip in shell blocks."""
    return [
        (page.name, command)
        for page in DOCUMENTS
        for block in pages.blocks(page)
        for command in block.commands
        if command.startswith(pages.DOLFINGRIP)
        and "--plugin" not in command  # without the plugin its names are not there
    ]


def _words(command: str) -> list[str]:
    """Name and arguments, up to where the shell goes on."""
    parts = shlex.shlex(command, posix=True, punctuation_chars="|&;<>")
    parts.whitespace_split = True
    parts.commenters = "#"
    own = list(takewhile(lambda part: not set(part) <= set("|&;<>"), parts))[2:]
    return own[:-1] if "2>&1" in command and own[-1] == "2" else own


@needs_checkout
def test_every_command_on_a_page_is_understood() -> None:
    """Names, options, values and keys of ``--set`` are there; nothing is computed."""
    known = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    found = _commands()
    assert len(found) > 60
    wrong = []
    for page, command in found:
        words = _words(command)
        try:
            entry = known[words[0]].entry
            context = entry.built().make_context(words[0], words[1:])
            described = settings_of(entry.settings)
            {each.name: each.value(context.params[each.name]) for each in described}
        except Exception as error:  # whatever it is, the page tells a reader to type it
            wrong.append((page, command, f"{type(error).__name__}: {error}"))
    assert wrong == []


MARKS: Final = {"in tests", "not in tests", "not run"}


def _executed(block: pages.Block) -> bool:
    """True of what runs when the documentation is built."""
    head = block.page.read_text(encoding="utf-8").partition("\n# ")[0]
    return (
        "file_format: mystnb" in head
        and block.language in {"sh", "python"}
        and "not executed" not in block.marks
    )


@needs_checkout
def test_every_block_says_how_it_is_run() -> None:
    """By a test, when the documentation is built, by a script alone, or not at all."""
    silent = [
        f"{page.name}:{block.line}"
        for page in DOCUMENTS
        for block in pages.blocks(page)
        if not MARKS & set(block.marks) and not _executed(block)
    ]
    assert silent == []


RUN: Final = {
    page: marked
    for page in DOCUMENTS
    if page.stem != "five_answers"  # those are tests/test_newcomer.py's
    and (marked := [each for each in pages.blocks(page) if "in tests" in each.marks])
}
"""Marked blocks by the page."""


@pytest.mark.slow
@needs_checkout
@pytest.mark.parametrize("page", RUN, ids=[page.stem for page in RUN])
def test_blocks_run_in_an_empty_clone(page: Path, tmp_path: Path) -> None:
    """Blocks run one after another as they are copied, with the sizes that their markers name."""
    clone = pages.clone(tmp_path)
    for block in RUN[page]:
        *first, last = block.reduced()
        pages.run(first, clone)
        if "refused" in block.marks:
            with pytest.raises(ConfigError):
                pages.run([last], clone)
        else:
            pages.run([last], clone)
