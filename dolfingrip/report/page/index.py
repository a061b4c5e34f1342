"""The index of what kinds of results contribute to a page, in the order of the page."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from typing import Final

from dolfingrip.report.page import results
from dolfingrip.report.page.contribution import Contribution
from dolfingrip.sections.lookup import only_class

CONTRIBUTIONS: Final[tuple[Contribution, ...]] = tuple(
    sorted(
        (
            only_class(f"{results.__name__}.{file.name}", Contribution)()
            for file in pkgutil.iter_modules(results.__path__)
        ),
        key=lambda each: each.place,
    )
)
"""One for each file of ``page/results``."""

MARKS: Final[Mapping[str, str]] = {
    kind: mark for each in CONTRIBUTIONS for kind, mark in each.marks.items()
}
"""The file by which each kind of result is known; of two in a folder, the first counts."""
