"""A page of any mix of results: what each contributes, in the order of reading."""

from __future__ import annotations

from collections.abc import Sequence

from dolfingrip.report.page.content import Page
from dolfingrip.report.page.contribution import FoundResult, Given
from dolfingrip.report.page.key_numbers import MOST, summary
from dolfingrip.report.page.sources import CONTRIBUTIONS


def build(found: Sequence[FoundResult], given: Given | None = None, title: str = "") -> Page:
    """Gather everything on the page of these results.

    Args:
        found: folders with results, at least one.
        given: what else it is made with; None: nothing.
        title: of the page; "": made of the results.

    Returns:
        The page.

    Raises:
        ResultFileError: one line, if a result cannot be read.
        ConfigError: one line, if its configuration cannot.
    """
    page, names = Page(title), []
    for each in CONTRIBUTIONS:
        own = [result for result in found if result.kind in each.marks]
        if own:
            names += each.add(page, own, given or Given())
    checked = summary(page.checks)
    page.numbers = page.numbers[: MOST - len(checked)] + checked
    once = list(dict.fromkeys(names))
    text = once[0] if len(once) == 1 else f"{', '.join(once[:-1])} and {once[-1]}"
    page.title = title or text[0].upper() + text[1:]
    return page
