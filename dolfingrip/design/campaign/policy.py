"""Numbers of the searches that grasps decide."""

from __future__ import annotations

from typing import Final

LIFT_MM: Final = 10.0
"""Way up in a trial; what slips does so within the first millimetres."""

LARGEST_FRICTION: Final = 2.0
"""Coefficient above which none is tried."""

ESTIMATES: Final = 4
"""Grasps at most from which the pressure is estimated, before others confirm it."""
