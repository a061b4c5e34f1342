"""Links the first use of each term of the glossary on a page to its explanation."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes

GLOSSARY = "glossary"
TERM = re.compile(r"^(\S.*)\n {2,}\S", re.M)
APART = (nodes.reference, nodes.title, nodes.literal, addnodes.pending_xref, nodes.caption)
"""Nodes whose text is no place for a link."""


def terms() -> dict[str, re.Pattern[str]]:
    """Each term with a pattern that finds it, in the singular and in the plural."""
    page = Path(__file__).resolve().parents[1] / f"{GLOSSARY}.md"
    body = page.read_text(encoding="utf-8").partition("{glossary}\n")[2].partition("```")[0]
    found = sorted(TERM.findall(body), key=len, reverse=True)
    return {term: re.compile(rf"\b{re.escape(term)}(?:s|es)?\b", re.I) for term in found}


def link(app: Any, doctree: nodes.document) -> None:
    """Put a link in the place of each term's first use."""
    page = app.env.docname
    if page in (GLOSSARY, app.config.root_doc) or "/" in page:  # cards; pages made from the code
        return
    for term, pattern in terms().items():
        for text in doctree.findall(nodes.Text):
            match = pattern.search(text.astext())
            if match is None or inside(text):
                continue
            replace(text, match, term)
            break


def inside(text: nodes.Text) -> bool:
    """Tell whether a text stands in a link, a heading or code."""
    node = text.parent
    while node is not None:
        if isinstance(node, APART):
            return True
        node = node.parent
    return False


def replace(text: nodes.Text, match: re.Match[str], term: str) -> None:
    """Split a text at a term, and make that a link."""
    whole, words = text.astext(), match[0]
    cross = addnodes.pending_xref(
        "", nodes.inline("", words, classes=["xref", "std", "std-term"]),
        refdomain="std", reftype="term", reftarget=term, refexplicit=True, refwarn=True,
    )  # fmt: skip
    parts = [nodes.Text(whole[: match.start()]), cross, nodes.Text(whole[match.end() :])]
    text.parent.replace(text, parts)


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("doctree-read", link)
    return {"parallel_read_safe": True}
