"""Names and integer tags of the groups that every mesh of a finger carries.

The tags are the same in every file written and in every mesh read, so that a form can be
restricted to a group without looking names up.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Final

SOLID: Final = "solid"
CAVITY: Final = "cavity"
CLAMP: Final = "clamp"
SKIN: Final = "skin"
TIP: Final = "tip"
SYMMETRY: Final = "symmetry"

SOLID_TAG: Final = 1
"""Tag of the volume group that all elements are in."""

VOLUME_TAGS: Final[dict[str, int]] = {"body": 2, "film": 3, "base": 4, "paper": 5}
"""Tag of each region of the kinds of geometry, by name; those of other names come after them."""

_OTHER_VOLUMES: Final = 23
"""Tag of the first region of another name."""

SURFACE_TAGS: Final[dict[str, int]] = {CAVITY: 11, CLAMP: 12, SKIN: 13, TIP: 14, SYMMETRY: 15}
"""Tag of each surface group, by name; those of further cavities come after them."""

_NUMBERED: Final = re.compile(rf"{CAVITY}_([2-9]|[1-9][0-9]+)")
_BEFORE: Final = max(SURFACE_TAGS.values()) - 1
"""What is added to a further cavity's number, which starts at 2, for its tag."""

BODY: Final = (CLAMP, SKIN, TIP)
"""Surface groups that every mesh must have; a half finger also has ``symmetry``."""

NEEDED: Final = (CAVITY, *BODY)
"""Surface groups of a finger; a solid body has no cavity."""


def volume_tags(names: Sequence[str]) -> dict[str, int]:
    """Tag of each region, in the order of the names."""
    others = [name for name in names if name not in VOLUME_TAGS]
    tags = VOLUME_TAGS | {name: _OTHER_VOLUMES + i for i, name in enumerate(others)}
    return {name: tags[name] for name in names}


def surface_tag(name: str) -> int | None:
    """Tag of a surface group; None of a name that no surface group has."""
    numbered = _NUMBERED.fullmatch(name)
    return _BEFORE + int(numbered[1]) if numbered else SURFACE_TAGS.get(name)


def surface_name(tag: int) -> str | None:
    """Name of the surface group with a tag; None of a tag that no surface group has."""
    names = {tag: name for name, tag in SURFACE_TAGS.items()}
    return names.get(tag) if tag < _BEFORE + 2 else f"{CAVITY}_{tag - _BEFORE}"


def surfaces(names: Iterable[str]) -> list[str]:
    """Names of surface groups among some names, by their tags."""
    tags = {name: tag for name in names if (tag := surface_tag(name)) is not None}
    return sorted(tags, key=lambda name: tags[name])


def cavities(names: Iterable[str]) -> tuple[str, ...]:
    """Names of cavities among some names.

    Args:
        names: of surface groups, and others.

    Returns:
        The names of cavities, in their order.
    """
    return tuple(name for name in surfaces(names) if name.startswith(CAVITY))


def cavity_names(count: int) -> tuple[str, ...]:
    """Names of so many cavities.

    Args:
        count: number of cavities.

    Returns:
        Their names, in their order.
    """
    return (CAVITY, *(f"{CAVITY}_{i}" for i in range(2, count + 1)))[:count]


def missing_message(missing: list[str]) -> str:
    """The error about a mesh that lacks some of the needed groups."""
    plural = "s" if len(missing) > 1 else ""
    return (
        f"missing group{plural} {', '.join(missing)}; "
        f"needed: {', '.join(NEEDED)}, and {SYMMETRY} for a half finger"
    )
