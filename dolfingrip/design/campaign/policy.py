"""Numbers of the searches that grasps decide."""

from __future__ import annotations

from typing import Final

LIFT_MM: Final = 10.0
"""Way up in a trial; what slips does so within the first millimetres."""

HIGHEST_KPA: Final = 300.0
"""Pressure above which none is tried; the paper's highest."""

LARGEST_PRESSURE_KPA: Final = 1000.0
"""Pressure that a user may ask for, at most."""

LARGEST_FRICTION: Final = 2.0
"""Coefficient above which none is tried."""

ESTIMATES: Final = 4
"""Grasps at most from which the pressure is estimated, before others confirm it."""
