"""The numbers of a configuration that can change."""

from dolfingrip.parameter.search import (
    Parameter,
    bounds_of,
    check,
    every,
    find,
    moduli,
    named,
    scaled,
)
from dolfingrip.sections.section import Entry

__all__ = [
    "Entry",
    "Parameter",
    "bounds_of",
    "check",
    "every",
    "find",
    "moduli",
    "named",
    "scaled",
]
