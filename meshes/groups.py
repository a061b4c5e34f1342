"""Names and integer tags of the groups that every mesh of a finger carries.

The tags are the same in every file written and in every mesh read, so that a form can be
restricted to a group without looking names up.
"""

from __future__ import annotations

from collections.abc import Sequence
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

CAVITIES: Final = (CAVITY, *(f"{CAVITY}_{i}" for i in range(2, 9)))
"""Surface groups of cavities; a mesh has the first, or the first few, of them."""

SURFACE_TAGS: Final[dict[str, int]] = {
    **{CAVITY: 11, CLAMP: 12, SKIN: 13, TIP: 14, SYMMETRY: 15},
    **{name: 16 + i for i, name in enumerate(CAVITIES[1:])},
}
"""Tag of each surface group, by name."""

NEEDED: Final = (CAVITY, CLAMP, SKIN, TIP)
"""Surface groups that every mesh must have; a half finger also has ``symmetry``."""


def volume_tags(names: Sequence[str]) -> dict[str, int]:
    """Tag of each region, in the order of the names."""
    others = [name for name in names if name not in VOLUME_TAGS]
    first = max(*VOLUME_TAGS.values(), *SURFACE_TAGS.values()) + 1
    tags = VOLUME_TAGS | {name: first + i for i, name in enumerate(others)}
    return {name: tags[name] for name in names}


def missing_message(missing: list[str]) -> str:
    """The error about a mesh that lacks some of the needed groups."""
    plural = "s" if len(missing) > 1 else ""
    return (
        f"missing group{plural} {', '.join(missing)}; "
        f"needed: {', '.join(NEEDED)}, and {SYMMETRY} for a half finger"
    )
